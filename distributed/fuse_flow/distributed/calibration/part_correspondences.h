#pragma once

#include <fuse_flow/distributed/calibration/alignment_messages.h>
#include <fuse_flow/distributed/calibration/pose_messages.h>
#include <fuse_flow/distributed/frame_digest.h>
#include <fuse_flow/impl/calibration/alignment_system.hpp>

#include <algorithm>
#include <cstring>
#include <exception>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief What the views of a rig say about its poses where each rank has some of the views. Counterparts are searched at the rank that has the
 *  view they lie in; so all ranks get the samples of all views, once, and then nothing larger than sums goes over the wire.
 *
 *  Rank 0 runs host::alignRig(), which asks this class; the others serve() it. All sums of a pair are made at one rank, in the order in which
 *  one process makes them, so that rank 0 has the same bytes as one process, for any number of ranks. */
class PartCorrespondences : public host::AlignmentSystem {
 public:
  explicit PartCorrespondences(Communicator& communicator) : communicator_(communicator) {}

  /** \brief Every rank, before anything else of a search: what views there are. \param digest of the rig and the parameters  \param error why this
   *  rank cannot take part; empty: it can  \throws RankError where another cannot, or has another rig, other parameters, other frames or a
   *  view of this one's: every rank then throws */
  void meet(std::uint64_t digest, const std::string& error) {
    Message own;
    MessageWriter out(own);
    out.put(kMagic);
    out.put(kVersion);
    out.put(digest);
    out.put(static_cast<std::uint64_t>(instants_));
    out.put(error);
    std::vector<Entry> entries;
    views_of_ranks_.assign(instants_ * cameras_, {});
    for (std::size_t t = 0; error.empty() && t < instants_; ++t)
      for (std::size_t i = 0; i < cameras_; ++i)
        if (const host::AlignmentView& own_view = view(t, i); !own_view.missing()) {
          const Entry entry{index(t, i), own_view.normalNoise(), own_view.hasColor() ? 1u : 0u};
          entries.push_back(entry);
          views_of_ranks_[entry.view] = {communicator_.rank(), entry.normal_noise, entry.has_color != 0};
        }
    out.put(static_cast<std::uint32_t>(entries.size()));
    out.put(entries.data(), entries.size());
    const std::vector<Message> in = exchangeWithOthers(communicator_, own);
    const std::vector<int> others = otherRanks(communicator_);
    for (std::size_t k = 0; k < others.size(); ++k) takeOthers(in[k], others[k], digest);
  }

  /** \brief Every rank but 0: does what rank 0 asks, until it has found the poses. \returns what finish() of rank 0 sent
   *  \throws RankError where rank 0 gives up */
  Message serve() {
    for (;;) {
      std::vector<Message> in;
      communicator_.exchange({}, {0}, in);
      MessageReader order(in[0], 0);
      switch (order.get<Order>()) {
        case Order::Sample:
          serveSamples(order);
          break;
        case Order::CountSeen:
          reply([&](MessageWriter& out) { serveSeen(order, out); });
          break;
        case Order::AddUp:
          reply([&](MessageWriter& out) { serveSums(order, out); });
          break;
        case Order::Clusters:
          reply([&](MessageWriter& out) { writeClusters(out); });
          break;
        case Order::Found:
          return in[0];
        case Order::GiveUp:
          throw RankError(0, "has given up the search for poses: " + order.getText());
        default:
          order.fail("an order that is none");
      }
    }
  }

  /** \brief Rank 0, at the end of the search. \param write what serve() returns at the others, behind skipOrder() */
  void finish(const std::function<void(MessageWriter&)>& write) { send(Order::Found, write); }
  /** \brief Rank 0, where the search cannot go on: the others throw. */
  void giveUp(const std::string& why) {
    try {
      send(Order::GiveUp, [&](MessageWriter& out) { out.put(why); });
    } catch (const std::exception&) {  // ranks that cannot be told: they wait no longer than exchange() does
    }
  }
  /** \brief What serve() returns begins with it. */
  static void skipOrder(MessageReader& in) { in.get<Order>(); }

  bool hasColor() const override {
    return std::any_of(views_of_ranks_.begin(), views_of_ranks_.end(), [](const ViewOfRank& v) { return v.has_color; });
  }

  void sample(const std::vector<Eigen::Isometry3d>& poses, int count) override {
    send(Order::Sample, [&](MessageWriter& out) {
      PoseMessages::put(out, poses);
      out.put(static_cast<std::int32_t>(count));
    });
    Message own;
    writeAnswer(own, [&](MessageWriter& out) { writeSamples(poses, count, out); });
    takeSamples(own, exchangeWithOthers(communicator_, own));
  }

  const std::vector<host::AlignmentCluster>& clusters() override {
    const std::vector<Message> in = ask(
        Order::Clusters, [](MessageWriter&) {}, [] {});
    const std::vector<int> others = otherRanks(communicator_);
    for (std::size_t k = 0; k < in.size(); ++k) readClusters(in[k], others[k]);
    return allClusters();
  }

 private:
  /** \brief What rank 0 asks of all. */
  enum class Order : std::uint8_t { Sample, CountSeen, AddUp, Clusters, Found, GiveUp };
  /** \brief A view that a rank has, as all are told. */
  struct Entry {
    std::uint32_t view;  ///< see index()
    float normal_noise;
    std::uint32_t has_color;
  };
  struct ViewOfRank {
    int rank{-1};  ///< who has it; −1: nobody
    float normal_noise{0};
    bool has_color{false};
  };
  static constexpr std::uint32_t kMagic = 0x46465050;  // "PPFF"
  /** \brief Of what is sent here; changes with every change of it. */
  static constexpr std::uint32_t kVersion = 1;

  std::uint32_t index(std::size_t instant, std::size_t camera) const {
    return static_cast<std::uint32_t>(instant * cameras_ + camera);
  }
  bool isOwn(std::size_t instant, std::size_t camera) const {
    return views_of_ranks_[index(instant, camera)].rank == communicator_.rank();
  }
  /** \brief Who makes the sums of what lies in a camera's images: one rank, though instants may be shared out. −1: nobody. */
  int ownerOf(std::size_t camera) const {
    for (std::size_t t = 0; t < instants_; ++t)
      if (const int rank = views_of_ranks_[index(t, camera)].rank; rank >= 0) return rank;
    return -1;
  }

  bool missing(std::size_t instant, std::size_t camera) const override {
    return views_of_ranks_[index(instant, camera)].rank < 0;
  }
  float normalNoiseOf(std::size_t instant, std::size_t camera) const override {
    return views_of_ranks_[index(instant, camera)].normal_noise;
  }

  void takeOthers(const Message& message, int from, std::uint64_t digest) {
    MessageReader in(message, from);
    if (in.get<std::uint32_t>() != kMagic || in.get<std::uint32_t>() != kVersion)
      in.fail("what another version of this library sends: all ranks must run the same");
    const auto its_digest = in.get<std::uint64_t>();
    const auto its_instants = in.get<std::uint64_t>();
    if (const std::string error = in.getText(); !error.empty())
      throw RankError(from, "cannot search for poses: " + error);
    if (its_digest != digest)
      throw RankError(from, "has other cameras or other parameters than rank " + std::to_string(communicator_.rank()) +
                                ": all must search for the poses of one rig");
    if (its_instants != instants_)
      throw RankError(from, "has " + std::to_string(its_instants) + " frames, rank " +
                                std::to_string(communicator_.rank()) + " has " + std::to_string(instants_));
    const auto count = in.get<std::uint32_t>();
    for (std::uint32_t k = 0; k < count; ++k) {
      const auto entry = in.get<Entry>();
      if (entry.view >= views_of_ranks_.size()) in.fail("a view of a camera that the rig does not have");
      if (!AlignmentMessages::areBelow(1, entry.normal_noise)) in.fail("normals that cannot be");
      for (std::size_t t = 0; t < instants_; ++t) {
        const int other = views_of_ranks_[index(t, entry.view % cameras_)].rank;
        if (other >= 0 && other != from)
          throw RankError(from, "has a view of camera " + std::to_string(entry.view % cameras_) + ", and so has rank " +
                                    std::to_string(other));
      }
      views_of_ranks_[entry.view] = {from, entry.normal_noise, entry.has_color != 0};
    }
    in.finish();
  }

  /** \brief Rank 0 to all others. */
  void send(Order order, const std::function<void(MessageWriter&)>& write) {
    Message message;
    MessageWriter out(message);
    out.put(order);
    write(out);
    sendToOthers(communicator_, message);
  }

  /** \brief Rank 0 has all others do something, and does its own part meanwhile. \returns what they answer: a text, empty where all is well, and
   *  then the rest */
  std::vector<Message> ask(Order order, const std::function<void(MessageWriter&)>& write,
                           const std::function<void()>& own_part) {
    send(order, write);
    std::exception_ptr failure;
    try {
      own_part();
    } catch (const std::exception&) {
      failure = std::current_exception();  // the answers come all the same
    }
    std::vector<Message> in;
    const std::vector<int> others = otherRanks(communicator_);
    communicator_.exchange({}, others, in);
    if (failure) std::rethrow_exception(failure);
    for (std::size_t k = 0; k < in.size(); ++k) skipError(in[k], others[k]);
    return in;
  }
  static MessageReader skipError(const Message& message, int from) {
    MessageReader in(message, from);
    if (const std::string error = in.getText(); !error.empty())
      throw RankError(from, "cannot search for poses: " + error);
    return in;
  }

  /** \brief Begins with why it cannot be done, where it cannot. */
  static void writeAnswer(Message& message, const std::function<void(MessageWriter&)>& write) {
    try {
      MessageWriter out(message);
      out.put(std::string());
      write(out);
    } catch (const std::exception& error) {
      MessageWriter(message).put(std::string(error.what()));
    }
  }
  void reply(const std::function<void(MessageWriter&)>& write) {
    Message message;
    if (unusable_.empty()) {
      writeAnswer(message, write);
    } else {
      MessageWriter(message).put(unusable_);
    }
    std::vector<Message> none;
    communicator_.exchange({{0, message.data(), message.size()}}, {}, none);
  }

  void serveSamples(MessageReader& order) {
    Message own;
    writeAnswer(own, [&](MessageWriter& out) {
      const std::vector<Eigen::Isometry3d> poses = PoseMessages::getPoses(order, cameras_);
      const int count = order.get<std::int32_t>();
      order.finish();
      writeSamples(poses, count, out);
    });
    const std::vector<Message> in = exchangeWithOthers(communicator_, own);
    try {
      takeSamples(own, in);
      unusable_.clear();
    } catch (const RankError& error) {
      unusable_ = error.what();  // rank 0 gives up now, or hears of it when it asks for more
    }
  }

  /** \brief Samples of the own views. */
  void writeSamples(const std::vector<Eigen::Isometry3d>& poses, int count, MessageWriter& out) {
    AlignmentSystem::sample(poses, count);
    for (std::size_t t = 0; t < instants_; ++t)
      for (std::size_t i = 0; i < cameras_; ++i) {
        if (!isOwn(t, i)) continue;
        const std::vector<AlignmentSample>& its = samples(t, i);
        if (!std::all_of(its.begin(), its.end(),
                         AlignmentMessages::canBe))  // or the others would refuse them, and this rank not
          throw pcl::PCLException("fuse_flow::distributed::ExtrinsicEstimation: points that cannot be");
        out.put(static_cast<std::uint32_t>(its.size()));
        out.put(its.data(), its.size());
      }
  }

  /** \brief Samples of the views of others. \param own answer \param in theirs */
  void takeSamples(const Message& own, const std::vector<Message>& in) {
    skipError(own, communicator_.rank());
    const std::vector<int> others = otherRanks(communicator_);
    for (std::size_t k = 0; k < in.size(); ++k) {
      MessageReader reader = skipError(in[k], others[k]);
      for (std::size_t t = 0; t < instants_; ++t)
        for (std::size_t i = 0; i < cameras_; ++i) {
          if (views_of_ranks_[index(t, i)].rank != others[k]) continue;
          const auto size = reader.get<std::uint32_t>();
          const char* bytes = reader.take(size, sizeof(AlignmentSample));
          std::vector<AlignmentSample>& its = allSamples()[index(t, i)];
          its.resize(size);
          if (size > 0) std::memcpy(static_cast<void*>(its.data()), bytes, size * sizeof(AlignmentSample));
          if (!std::all_of(its.begin(), its.end(), AlignmentMessages::canBe)) reader.fail("points that cannot be");
        }
      reader.finish();
    }
  }

  void countSeen(const std::vector<Eigen::Isometry3d>& poses, const AlignmentGates& gates,
                 std::vector<Seen>& seen) override {
    const std::vector<Message> in = ask(
        Order::CountSeen,
        [&](MessageWriter& out) {
          PoseMessages::put(out, poses);
          out.put(gates);
        },
        [&] { AlignmentSystem::countSeen(poses, gates, seen); });  // of views that are not here nothing is asked
    const std::vector<int> others = otherRanks(communicator_);
    for (std::size_t k = 0; k < in.size(); ++k) {
      MessageReader reader = skipError(in[k], others[k]);
      for (Seen& pair : seen) {
        pair.count += static_cast<std::size_t>(reader.get<std::uint64_t>());
        pair.asked += static_cast<std::size_t>(reader.get<std::uint64_t>());
      }
      reader.finish();
    }
  }
  void serveSeen(MessageReader& order, MessageWriter& out) {
    const std::vector<Eigen::Isometry3d> poses = PoseMessages::getPoses(order, cameras_);
    const AlignmentGates gates = AlignmentMessages::getGates(order);
    order.finish();
    std::vector<Seen> seen(cameras_ * cameras_);
    AlignmentSystem::countSeen(poses, gates, seen);
    for (const Seen& pair : seen) {
      out.put(static_cast<std::uint64_t>(pair.count));
      out.put(static_cast<std::uint64_t>(pair.asked));
    }
  }

  void addUp(const std::vector<Eigen::Isometry3d>& poses, float per_radius, const AlignmentGates& gates) override {
    const std::vector<Message> in = ask(
        Order::AddUp,
        [&](MessageWriter& out) {
          PoseMessages::put(out, poses);
          out.put(per_radius);
          out.put(gates);
          out.put(static_cast<std::uint32_t>(pairs_.size()));
          for (std::size_t k = 0; k < pairs_.size(); ++k) {
            out.put(pairs_[k].i);
            out.put(pairs_[k].j);
            out.put(offsets_[k]);
          }
        },
        [&] { AlignmentSystem::addUp(poses, per_radius, gates); });
    const std::vector<int> others = otherRanks(communicator_);
    for (std::size_t k = 0; k < in.size(); ++k) {
      MessageReader reader = skipError(in[k], others[k]);
      for (std::uint32_t& residuals : residuals_) residuals += reader.get<std::uint32_t>();
      for (host::PairSums& pair : pairs_) {
        if (ownerOf(pair.j) != others[k]) continue;
        pair.geometry = AlignmentMessages::getSums(reader);
        pair.color = AlignmentMessages::getSums(reader);
      }
      reader.finish();
    }
  }
  void serveSums(MessageReader& order, MessageWriter& out) {
    const std::vector<Eigen::Isometry3d> poses = PoseMessages::getPoses(order, cameras_);
    const auto per_radius = order.get<float>();
    const AlignmentGates gates = AlignmentMessages::getGates(order);
    if (!AlignmentMessages::areBelow(1e6f, per_radius)) order.fail("a scene that cannot be");
    const auto count = order.get<std::uint32_t>();
    if (count > cameras_ * cameras_) order.fail("more pairs of cameras than the rig has");
    pairs_.clear();
    offsets_.clear();
    begin_.assign(1, 0);
    for (std::uint32_t k = 0; k < count; ++k) {
      host::PairSums pair;
      pair.i = order.get<std::uint32_t>();
      pair.j = order.get<std::uint32_t>();
      if (pair.i >= cameras_ || pair.j >= cameras_ || pair.i + 1 < begin_.size())
        order.fail("a pair of cameras that cannot be");
      while (begin_.size() <= pair.i) begin_.push_back(pairs_.size());
      pairs_.push_back(pair);
      offsets_.push_back(order.get<float>());
      if (!AlignmentMessages::areBelow(1e6f, offsets_.back())) order.fail("grey levels that cannot be");
    }
    while (begin_.size() <= cameras_) begin_.push_back(pairs_.size());
    order.finish();
    residuals_.assign(kNoiseBins, 0);
    AlignmentSystem::addUp(poses, per_radius, gates);
    out.put(residuals_.data(), residuals_.size());
    for (const host::PairSums& pair : pairs_) {
      if (ownerOf(pair.j) != communicator_.rank()) continue;
      out.put(pair.geometry);
      out.put(pair.color);
    }
  }

  /** \brief Of the last sums, those of the own views. */
  void writeClusters(MessageWriter& out) {
    forEachCluster(communicator_.rank(), [&](AlignmentSums& sums) { out.put(sums); });
  }
  void readClusters(const Message& message, int from) {
    MessageReader in = skipError(message, from);
    forEachCluster(from, [&](AlignmentSums& sums) { sums = AlignmentMessages::getSums(in); });
    in.finish();
  }
  /** \brief Of what lies in a rank's views. */
  template <typename Visit>
  void forEachCluster(int rank, const Visit& visit) {
    for (host::AlignmentCluster& cluster : allClusters())
      for (std::size_t slot = 0; slot < cluster.geometry.size(); ++slot)
        if (ownerOf(pairs_[firstPair(cluster.camera) + slot].j) == rank) {
          visit(cluster.geometry[slot]);
          visit(cluster.color[slot]);
        }
  }

  Communicator& communicator_;
  std::vector<ViewOfRank> views_of_ranks_;  ///< see index()
  std::string unusable_;                    ///< why the samples are; empty: they can be used
};

}  // namespace distributed
}  // namespace fuse_flow
