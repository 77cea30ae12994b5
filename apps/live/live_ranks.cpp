#include "live/live_ranks.h"

#include <fuse_flow/distributed/camera_message.h>
#include <fuse_flow/distributed/message.h>
#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

namespace fuse_flow::io {
namespace {

using distributed::CameraMessage;
using distributed::Communicator;
using distributed::Message;
using distributed::MessageReader;
using distributed::MessageWriter;

/** \brief Of what is sent here; changes with every change of it. */
constexpr std::uint32_t kVersion = 3;

/** \brief What all ranks do next. */
enum class Order : std::uint8_t { Report, Fuse, Stop };

/** \brief Views of a camera that are kept until rank 0 has said which it takes: those that wait in its synchroniser, which keeps eight, and those
 *  that come while a frame is fused. */
constexpr std::size_t kKeptViews = 24;

/** \brief A view that came, as rank 0 hears of it. */
struct ReportedView {
  std::uint32_t camera;
  std::uint32_t age;  ///< microseconds
  std::uint64_t stamp;
};

std::chrono::steady_clock::time_point now() { return std::chrono::steady_clock::now(); }

std::string nameOf(int rank) { return "rank " + std::to_string(rank); }

}  // namespace

RankPart partOfPlayed(Communicator& patient, const std::string& played) {
  Message own;
  MessageWriter(own).put(played);
  const std::vector<int> others = distributed::otherRanks(patient);
  const std::vector<Message> in = distributed::exchangeWithOthers(patient, own);
  std::vector<std::string> all(static_cast<std::size_t>(patient.size()));  // by rank
  all[static_cast<std::size_t>(patient.rank())] = played;
  for (std::size_t k = 0; k < others.size(); ++k) {
    MessageReader reader(in[k], others[k]);
    all[static_cast<std::size_t>(others[k])] = reader.getText();
    reader.finish();
  }
  RankPart result{0, 0};
  int first = 0;  // that plays; every rank finds the same fault, whatever it plays itself
  for (int rank = 0; rank < patient.size(); ++rank) {
    const std::string& its = all[static_cast<std::size_t>(rank)];
    if (its.empty()) continue;
    if (result.parts++ == 0) first = rank;
    const std::string& of_first = all[static_cast<std::size_t>(first)];
    if (its != of_first)
      throw distributed::RankError(rank, "plays " + its + ", and rank " + std::to_string(first) + " plays " + of_first +
                                             ": must be the same recording, or devices");
    if (rank < patient.rank()) ++result.part;
  }
  if (played.empty()) return {0, 0};
  return result;
}

/** \brief At rank 0, the cameras of another rank. */
class RankSource : public CameraSource {
 public:
  RankSource(int rank, MessageReader& in, const std::vector<Camera>& cameras) : rank_(rank), cameras_(cameras) {
    has_poses_ = in.get<std::uint8_t>() != 0;
    for (std::size_t k = 0; k < cameras_.size(); ++k) {
      has_depth_.push_back(in.get<std::uint8_t>() != 0);
      has_color_.push_back(in.get<std::uint8_t>() != 0);
    }
    clocks_ = in.get<std::uint8_t>() != 0 ? ClockModel::Shared : ClockModel::Separate;
  }

  const std::vector<Camera>& cameras() const override { return cameras_; }
  bool hasPoses() const override { return has_poses_; }
  bool hasDepth(std::size_t camera) const override { return has_depth_[camera]; }
  bool hasColor(std::size_t camera) const override { return has_color_[camera]; }
  ClockModel clocks() const override { return clocks_; }
  void start(const Receiver& receiver) override { receiver_ = receiver; }
  void stop() override { receiver_ = {}; }
  bool running() const override { return running_; }
  std::string failure() const override { return failure_; }

  /** \brief What FollowingRank::report() has written. */
  void take(const Message& message) {
    MessageReader in(message, rank_);
    const auto views = in.get<std::uint32_t>();
    for (std::uint32_t k = 0; k < views; ++k) {
      const auto view = in.get<ReportedView>();
      if (view.camera >= cameras_.size()) in.fail("a view of a camera that it has not");
      if (receiver_.view) receiver_.view({view.camera, view.stamp, nullptr, std::chrono::microseconds(view.age)});
    }
    const auto notices = in.get<std::uint32_t>();
    for (std::uint32_t k = 0; k < notices; ++k) {
      const std::string line = in.getText();
      if (receiver_.notice) receiver_.notice(nameOf(rank_) + ": " + line);
    }
    running_ = in.get<std::uint8_t>() != 0;
    if (const std::string why = in.getText(); !why.empty()) failure_ = nameOf(rank_) + ": " + why;
    in.finish();
  }

 private:
  int rank_;
  std::vector<Camera> cameras_;
  bool has_poses_;
  std::vector<bool> has_depth_, has_color_;
  ClockModel clocks_;
  Receiver receiver_;
  bool running_{true};
  std::string failure_;
};

void LeadingRank::sendToAll(const std::vector<Message>& out, Communicator& communicator) const {
  std::vector<Communicator::Outgoing> messages;
  for (std::size_t k = 0; k < others_.size(); ++k) messages.push_back({others_[k].rank, out[k].data(), out[k].size()});
  std::vector<Message> none;
  communicator.exchange(messages, {}, none);
}

std::vector<std::unique_ptr<CameraSource>> LeadingRank::meet(std::vector<std::unique_ptr<CameraSource>> own,
                                                             Communicator& patient) {
  const std::vector<int> from = distributed::otherRanks(communicator_);
  patient.exchange({}, from, in_);
  std::size_t cameras = 0;
  for (const std::unique_ptr<CameraSource>& source : own) cameras += source->cameras().size();
  for (std::size_t k = 0; k < from.size(); ++k) {
    MessageReader in(in_[k], from[k]);
    if (const auto version = in.get<std::uint32_t>(); version != kVersion)
      throw distributed::RankError(from[k], "has another version of this program, " + std::to_string(version) +
                                                ", must be " + std::to_string(kVersion));
    const std::vector<Camera> its = CameraMessage::get(in);
    auto source = std::make_unique<RankSource>(from[k], in, its);
    in.finish();
    others_.push_back({from[k], its.size(), cameras, its.empty() ? nullptr : source.get()});
    cameras += its.size();
    if (!its.empty()) own.push_back(std::move(source));
  }
  return own;
}

void LeadingRank::begin(const std::vector<Camera>& cameras, Communicator& patient) {
  std::vector<Message> out(others_.size());
  for (std::size_t k = 0; k < others_.size(); ++k) {
    MessageWriter writer(out[k]);
    writer.put(static_cast<std::uint32_t>(others_[k].first));
    CameraMessage::put(writer, cameras);
  }
  sendToAll(out, patient);
}

void LeadingRank::awaitOthers(Communicator& patient) {
  patient.exchange({}, distributed::otherRanks(communicator_), in_);  // they have started
  sendToAll(std::vector<Message>(others_.size()), patient);           // and all have: orders follow
}

void LeadingRank::poll() {
  std::vector<Message> out(others_.size());
  for (Message& order : out) MessageWriter(order).put(Order::Report);
  sendToAll(out, communicator_);
  communicator_.exchange({}, distributed::otherRanks(communicator_), in_);
  for (std::size_t k = 0; k < others_.size(); ++k)
    if (others_[k].source != nullptr) others_[k].source->take(in_[k]);
}

void LeadingRank::fuse(const LiveInstant& instant, bool refines) {
  std::vector<Message> out(others_.size());
  for (std::size_t k = 0; k < others_.size(); ++k) {
    MessageWriter writer(out[k]);
    writer.put(Order::Fuse);
    writer.put(static_cast<std::uint8_t>(refines));
    writer.put(instant.rig.stamp);
    for (std::size_t c = 0; c < others_[k].cameras; ++c) {
      const std::optional<std::uint64_t>& stamp = instant.stamps[others_[k].first + c];
      writer.put(static_cast<std::uint8_t>(stamp.has_value()));
      writer.put(stamp.value_or(0));
    }
  }
  sendToAll(out, communicator_);
}

void LeadingRank::stop() {
  std::vector<Message> out(others_.size());
  for (Message& order : out) MessageWriter(order).put(Order::Stop);
  sendToAll(out, communicator_);
}

struct FollowingRank::Kept {
  struct View {
    std::uint64_t stamp;
    std::chrono::steady_clock::time_point came;
    bool reported;
    std::shared_ptr<const LoadedView> images;
  };
  std::mutex mutex;
  std::vector<std::deque<View>> views;  ///< of each camera, oldest first
  std::vector<std::string> notices;
};

FollowingRank::FollowingRank(Communicator& communicator, std::vector<std::unique_ptr<CameraSource>> sources)
    : communicator_(communicator), sources_(std::move(sources)), kept_(std::make_unique<Kept>()) {
  for (const std::unique_ptr<CameraSource>& source : sources_) own_ += source->cameras().size();
  kept_->views.resize(own_);
}

FollowingRank::~FollowingRank() { stop(); }

void FollowingRank::stop() {
  for (const std::unique_ptr<CameraSource>& source : sources_) source->stop();
}

void FollowingRank::meet(Communicator& patient) {
  Message hello;
  MessageWriter writer(hello);
  writer.put(kVersion);
  std::vector<Camera> cameras;
  bool posed = true, shared = sources_.size() == 1;
  for (const std::unique_ptr<CameraSource>& source : sources_) {
    cameras.insert(cameras.end(), source->cameras().begin(), source->cameras().end());
    posed = posed && source->hasPoses();
    shared = shared && source->clocks() == ClockModel::Shared;
  }
  CameraMessage::put(writer, cameras);
  writer.put(static_cast<std::uint8_t>(posed));
  for (const std::unique_ptr<CameraSource>& source : sources_)
    for (std::size_t k = 0; k < source->cameras().size(); ++k) {
      writer.put(static_cast<std::uint8_t>(source->hasDepth(k)));
      writer.put(static_cast<std::uint8_t>(source->hasColor(k)));
    }
  writer.put(static_cast<std::uint8_t>(shared));
  std::vector<Message> in;
  patient.exchange({{0, hello.data(), hello.size()}}, {}, in);

  patient.exchange({}, {0}, in);
  MessageReader reader(in[0], 0);
  first_ = reader.get<std::uint32_t>();
  cameras_ = CameraMessage::get(reader);
  reader.finish();
  if (first_ + own_ > cameras_.size()) reader.fail("another rig than that of this rank's cameras");

  std::size_t camera = 0;
  for (const std::unique_ptr<CameraSource>& source : sources_) {
    CameraSource::Receiver receiver;
    receiver.view = [this, camera](CameraView view) {
      std::shared_ptr<const LoadedView> given_up;  // freed when nobody waits for the lock
      const std::lock_guard<std::mutex> lock(kept_->mutex);
      std::deque<Kept::View>& views = kept_->views[camera + view.camera];
      if (views.size() >= kKeptViews) {
        given_up = std::move(views.front().images);
        views.pop_front();
      }
      views.push_back({view.stamp, now() - view.age, false, std::move(view.images)});
    };
    receiver.notice = [this](const std::string& line) {
      const std::lock_guard<std::mutex> lock(kept_->mutex);
      kept_->notices.push_back(line);
    };
    source->start(receiver);
    camera += source->cameras().size();
  }
  const char started = 1;
  patient.exchange({{0, &started, 1}}, {}, in);
  patient.exchange({}, {0}, in);
}

void FollowingRank::report() {
  // Asked before what came is looked at: of a source that has ended, all has come.
  bool running = false;
  std::string failure;
  for (const std::unique_ptr<CameraSource>& source : sources_) {
    const bool runs = source->running();
    if (!runs && failure.empty()) failure = source->failure();
    running = running || runs;
  }
  Message message;
  MessageWriter out(message);
  {
    const std::lock_guard<std::mutex> lock(kept_->mutex);
    std::vector<ReportedView> came;
    const auto time = now();
    for (std::size_t k = 0; k < kept_->views.size(); ++k)
      for (Kept::View& view : kept_->views[k]) {
        if (std::exchange(view.reported, true)) continue;
        const auto age = std::chrono::duration_cast<std::chrono::microseconds>(time - view.came).count();
        came.push_back({static_cast<std::uint32_t>(k),
                        static_cast<std::uint32_t>(std::clamp<std::int64_t>(age, 0, 60'000'000)), view.stamp});
      }
    // As they came: rank 0's synchroniser has no more than eight of a camera.
    std::stable_sort(came.begin(), came.end(),
                     [](const ReportedView& a, const ReportedView& b) { return a.age > b.age; });
    out.put(static_cast<std::uint32_t>(came.size()));
    out.put(came.data(), came.size());
    out.put(static_cast<std::uint32_t>(kept_->notices.size()));
    for (const std::string& line : std::exchange(kept_->notices, {})) out.put(line);
  }
  out.put(static_cast<std::uint8_t>(running));
  out.put(failure);
  std::vector<Message> none;
  communicator_.exchange({{0, message.data(), message.size()}}, {}, none);
}

LiveInstant FollowingRank::instantOf(const Message& order) {
  MessageReader in(order, 0);
  in.get<Order>();
  in.get<std::uint8_t>();  // see run()
  LiveInstant instant;
  instant.rig.stamp = in.get<std::uint64_t>();
  instant.rig.cameras = cameras_;
  instant.rig.views.assign(cameras_.size(), {});
  instant.held.assign(cameras_.size(), nullptr);
  instant.stamps.assign(cameras_.size(), std::nullopt);
  std::vector<std::shared_ptr<const LoadedView>> past;  // freed when nobody waits for the lock
  const std::lock_guard<std::mutex> lock(kept_->mutex);
  for (std::size_t k = 0; k < own_; ++k) {
    const bool there = in.get<std::uint8_t>() != 0;
    const auto stamp = in.get<std::uint64_t>();
    if (!there) continue;
    std::deque<Kept::View>& views = kept_->views[k];
    const auto taken = std::find_if(views.begin(), views.end(),
                                    [&](const Kept::View& view) { return view.reported && view.stamp == stamp; });
    if (taken == views.end()) {  // it was given up while rank 0 was long away
      kept_->notices.push_back("camera '" + cameras_[first_ + k].name + "': its view of one instant was no more there");
      continue;
    }
    instant.stamps[first_ + k] = stamp;
    instant.setView(first_ + k, taken->images);
    // Sets only go on: what is before this one is of no use.
    for (auto view = views.begin(); view != std::next(taken); ++view) past.push_back(std::move(view->images));
    views.erase(views.begin(), std::next(taken));
  }
  in.finish();
  return instant;
}

void FollowingRank::run(const std::function<void(const LiveInstant& instant, bool refines)>& fuse) {
  std::vector<Message> in;
  for (;;) {
    communicator_.exchange({}, {0}, in);
    MessageReader order(in[0], 0);
    switch (order.get<Order>()) {
      case Order::Report:
        report();
        break;
      case Order::Fuse:
        fuse(instantOf(in[0]), order.get<std::uint8_t>() != 0);
        break;
      case Order::Stop:
        stop();
        return;
      default:
        order.fail("an order that is none");
    }
  }
}

}  // namespace fuse_flow::io
