#include "device_comparison.h"
#include "random_rig.h"

namespace {

using namespace device_comparison;
using random_rig::Random;
using random_rig::RandomFrame;
using Stage = fuse_flow::gpu::StageTimes::Stage;

std::vector<Stage> stagesOf(const fuse_flow::FuseFlowParameters& parameters) {
  Random random(61);
  RandomFrame frame;
  Cloud cloud;
  Device device;
  device.setParameters(parameters);
  while (cloud.empty()) {
    frame.draw(random, 6, 60);
    device.fuse(frame.rig, cloud);
  }
  device.stageTimes().enabled = true;
  device.fuse(frame.rig, cloud);
  return device.stageTimes().stages();
}

const Stage& stageOf(const std::vector<Stage>& stages, const std::string& name) {
  for (const Stage& stage : stages)
    if (stage.name == name) return stage;
  throw std::runtime_error("no stage " + name);
}

TEST(GpuStageBytes, EachStageThatReadsSomethingSaysSoAndMovesAtLeastAsMuch) {
  fuse_flow::FuseFlowParameters bilateral, point_wise;
  bilateral.preprocessing.bilateral = true;
  bilateral.preprocessing.fill_neighbours = 3;
  point_wise.use_spatial_hash = false;
  for (const auto& parameters : {fuse_flow::FuseFlowParameters(), bilateral, point_wise})
    for (const Stage& stage : stagesOf(parameters)) {
      // Where the device is the CPU, images stay where they are.
      if (std::string(stage.name) == "upload" && !FUSE_FLOW_CUDA) continue;
      EXPECT_GT(stage.bytes, 0) << stage.name;
      EXPECT_GE(stage.moved_bytes, stage.bytes) << stage.name;
    }
}

TEST(GpuStageBytes, PassesCountInWhatIsMovedAlone) {
  fuse_flow::FuseFlowParameters one, four;
  one.smoothing.passes = 1;
  four.smoothing.passes = 4;
  four.smoothing.twicing = false;
  const std::vector<Stage> once = stagesOf(one), often = stagesOf(four);
  EXPECT_EQ(stageOf(often, "smoothing").bytes, stageOf(once, "smoothing").bytes);
  EXPECT_EQ(stageOf(often, "smoothing").moved_bytes, 4 * stageOf(once, "smoothing").moved_bytes);
  four.smoothing.twicing = true;  // three passes more, and a look at what was there before them
  EXPECT_EQ(stageOf(stagesOf(four), "smoothing").moved_bytes, 7.5 * stageOf(once, "smoothing").moved_bytes);
  EXPECT_GT(stageOf(often, "sort").moved_bytes, stageOf(often, "sort").bytes);
}

}  // namespace
