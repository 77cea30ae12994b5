#include "../seeds.h"
#include "../small_pose_rig.h"

#include <fuse_flow/distributed/camera_message.h>
#include <fuse_flow/distributed/gathered_cells.h>
#include <fuse_flow/distributed/part_summary.h>
#include <fuse_flow/distributed/thread_ranks.h>
#include <fuse_flow/point_types.h>

#if defined(FUSE_FLOW_WITH_ZSTD)
#include <fuse_flow/distributed/zstd_codec.h>
#endif

#include <thread>

namespace fuse_flow_fuzz {
namespace {

using namespace fuse_flow::distributed;

std::string seed(char kind, const Message& message) {
  return std::string(1, kind) + std::string(message.begin(), message.end());
}

Message summary() {
  PartSummary part;
  part.views.resize(2);
  part.views[1].view = 69;
  part.blocks = {{77, 3, 0, 9}, {78, 32, 1, 1}};
  Message message;
  part.write(message);
  return message;
}

Message cameras() {
  fuse_flow::Camera camera;
  camera.name = "left";
  camera.intrinsics.width = 64;
  camera.intrinsics.height = 48;
  camera.intrinsics.fx = camera.intrinsics.fy = 50;
  camera.color = fuse_flow::ColorCamera();
  camera.color->intrinsics = camera.intrinsics;
  Message message;
  MessageWriter out(message);
  CameraMessage::put(out, {camera, camera});
  return message;
}

Message gathered(MessageParts& parts) {
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  cloud.resize(3);
  Message message;
  writeGathered({{2, 1}, {9, 2}}, cloud, message, parts);
  return message;
}

/** \brief Keeps what comes in. */
class Recorder : public Communicator {
 public:
  explicit Recorder(Communicator& rank) : rank_(rank), heard_(1, static_cast<char>(rank.rank())) {}
  int rank() const override { return rank_.rank(); }
  int size() const override { return rank_.size(); }
  void exchange(const std::vector<Outgoing>& out, const std::vector<int>& from, std::vector<Message>& in) override {
    rank_.exchange(out, from, in);
    for (const Message& message : in) {
      for (int k = 0; k < 3; ++k) heard_ += static_cast<char>(message.size() >> 8 * k);
      heard_.append(message.begin(), message.end());
    }
  }
  const std::string& heard() const { return heard_; }

 private:
  Communicator& rank_;
  std::string heard_;
};

/** \brief What each of two ranks hears from the other. */
std::vector<std::string> searches() {
  const SmallPoseRig rig;
  ThreadRanks ranks(2);
  std::vector<std::string> heard(2);
  const auto run = [&](int rank) {
    Recorder recorder(ranks.communicator(rank));
    rig.estimate(recorder);
    heard[static_cast<std::size_t>(rank)] = recorder.heard();
  };
  std::thread other([&] { run(1); });
  run(0);
  other.join();
  return heard;
}

}  // namespace

void addRankSeeds(Seeds& seeds) {
  std::vector<std::string>& all = seeds["rank_message"];
  MessageParts parts;
  const Message points = gathered(parts);
  all = {seed(0, summary()), seed(1, cameras()), seed(2, points)};
#if defined(FUSE_FLOW_WITH_ZSTD)
  Message coded;
  CodedMessage().code(ZstdCodec(), points, parts, 1, coded);
  all.push_back(seed(3, coded));
  // Nothing in it repeats itself, so that Zstandard stores it, and mutations get through.
  Message noise(64);
  for (std::size_t k = 0; k < noise.size(); ++k) noise[k] = static_cast<char>(k * k * 37 + 11);
  CodedMessage().code(ZstdCodec(), noise, {{30, ByteKind::Words}, {30, ByteKind::Colors}}, 1, coded);
  all.push_back(seed(3, coded));
#endif
  seeds["pose_search"] = searches();
}

}  // namespace fuse_flow_fuzz
