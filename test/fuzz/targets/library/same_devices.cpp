#include "../../../gpu/device_comparison.h"
#include "../../random_frames.h"

namespace {

using namespace device_comparison;
using fuse_flow_fuzz::refusalOf;
using fuse_flow_fuzz::require;

void requireSameStatistics(const fuse_flow::FrameStatistics& a, const fuse_flow::FrameStatistics& b) {
  require(a.measured_points == b.measured_points && a.gated_points == b.gated_points &&
              a.coarse_cells == b.coarse_cells && a.missing_cameras == b.missing_cameras &&
              a.noise_scales == b.noise_scales && a.out_of_range.size() == b.out_of_range.size(),
          "other statistics on another device");
}

}  // namespace

/** \brief The same frames with the same parameters on the host and by Thrust: the same points, as far as exp() of both is the same, or the same refusal.
 *  Frames of five small cameras; both keep buffers, and Thrust some for each step. */
FUSE_FLOW_FUZZ_TARGET(same_devices, 256 << 20, 0, 20) {
  random_rig::Random random(input);
  static Host host;
  static Device device;
  random_rig::RandomFrame frame;
  fuse_flow_fuzz::drawFrame(random, frame);
  const fuse_flow::FuseFlowParameters parameters =
      fuse_flow_fuzz::drawParameters(random, static_cast<int>(frame.rig.cameras.size()));
  const auto refusal = refusalOf([&] { host.setParameters(parameters); });
  require(refusal == refusalOf([&] { device.setParameters(parameters); }),
          "another refusal of parameters on another device");
  if (refusal) return;
  Cloud expected, cloud;
  const auto refused = refusalOf([&] { host.fuse(frame.rig, expected); });
  require(refused == refusalOf([&] { device.fuse(frame.rig, cloud); }), "another refusal of a frame on another device");
  if (refused) return;
  ++fuse_flow_fuzz::acceptedInputs();
  requireSameStatistics(host.getStatistics(), device.getStatistics());
  const std::size_t both = expected.size() + cloud.size(), alone = fusedPointsAlone(expected, cloud);
  require(alone <= std::min(both / 20 + 1, 4 + both / 1000),
          std::to_string(alone) + " of " + std::to_string(both) + " points are on one device only");
}
