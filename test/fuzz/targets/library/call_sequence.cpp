#include "../../random_frames.h"

#include <cstring>

namespace {

using namespace fuse_flow;
using Fusion = FuseFlow<PointFused>;
using fuse_flow_fuzz::refusalOf;
using fuse_flow_fuzz::require;

bool sameBytes(const pcl::PointCloud<PointFused>& a, const pcl::PointCloud<PointFused>& b) {
  const auto same = [](const PointFused& p, const PointFused& q) {
    return std::memcmp(&p.x, &q.x, 12) == 0 && p.rgba == q.rgba && std::memcmp(&p.confidence, &q.confidence, 4) == 0 &&
           p.view_count == q.view_count;
  };
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), same);
}

}  // namespace

/** \brief Calls on one object in any order, with frames of other rigs and sizes, and with what is refused: each frame gives what a new object with the same
 *  settings gives. PCL's bilateral filter takes a grid of the image and its depths, and a copy: some 230 MB each if its standard deviations are small. */
FUSE_FLOW_FUZZ_TARGET(call_sequence, 1 << 30, 0, 30) {
  random_rig::Random random(input);
  Fusion fusion;
  FuseFlowParameters parameters;
  unsigned int threads = 1;
  fusion.setNumberOfThreads(threads);
  random_rig::RandomFrame frame;
  fuse_flow_fuzz::drawFrame(random, frame);
  for (int call = 0; call < 8; ++call) {
    switch (random.below(4)) {
      case 0: {
        const FuseFlowParameters others =
            fuse_flow_fuzz::drawParameters(random, static_cast<int>(frame.rig.cameras.size()));
        if (!refusalOf([&] { fusion.setParameters(others); })) parameters = others;
        break;
      }
      case 1:
        threads = 1 + static_cast<unsigned int>(random.below(2));
        fusion.setNumberOfThreads(threads);
        break;
      case 2:
        fuse_flow_fuzz::drawFrame(random, frame);
        break;
      default:
        if (random.oneIn(6)) {
          Fusion moved = std::move(fusion);
          fusion = std::move(moved);
        }
    }
    Fusion fresh;
    fresh.setNumberOfThreads(1);
    fresh.setParameters(parameters);
    pcl::PointCloud<PointFused> cloud, expected;
    const auto refused = refusalOf([&] { fusion.fuse(frame.rig, cloud); });
    require(refused == refusalOf([&] { fresh.fuse(frame.rig, expected); }), "another refusal than of a new object");
    fuse_flow_fuzz::acceptedInputs() += refused ? 0 : 1;
    require(refused || sameBytes(cloud, expected), "other points than of a new object");
  }
}
