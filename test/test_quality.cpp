#include "io/demo_scene.h"
#include "io/recording.h"
#include "scenes.h"

#include <fuse_flow/multi_camera_consistency.h>

#include <pcl/filters/voxel_grid.h>

#include <filesystem>

namespace {

using fuse_flow::multiCameraConsistency;
using fuse_flow::Quality;
using fuse_flow::QualityParameters;
using Points = pcl::PointCloud<pcl::PointXYZ>;

/** \brief All measurements of a frame in one cloud: pixel by pixel, nothing fused. */
Points concatenated(const fuse_flow::RigFrame& frame) {
  fuse_flow::FuseFlowParameters parameters;
  Points cloud;
  for (std::size_t i = 0; i < frame.cameras.size(); ++i) {
    const fuse_flow::Intrinsics& K = frame.cameras[i].intrinsics;
    const fuse_flow::DepthView& view = frame.views[i];
    for (int v = 0; v < K.height; ++v)
      for (int u = 0; u < K.width; ++u) {
        const std::uint16_t raw = view.depth16.row(v)[u];
        const auto z = static_cast<double>(view.depth_scale) * raw;
        if (raw == 0 || raw == 65535 || z < static_cast<double>(parameters.preprocessing.min_range) ||
            z > static_cast<double>(parameters.preprocessing.max_range))
          continue;
        const auto ray = fuse_flow::unproject(K, {static_cast<float>(u), static_cast<float>(v)});
        const Eigen::Vector3f p = (frame.cameras[i].T_world_camera *
                                   (z * Eigen::Vector3d(static_cast<double>(ray.x), static_cast<double>(ray.y), 1)))
                                      .cast<float>();
        cloud.push_back({p.x(), p.y(), p.z()});
      }
  }
  return cloud;
}

/** \brief Median and 95th percentile of the distance to the demo scene's surfaces. */
template <typename Cloud>
std::array<double, 2> surfaceDistances(const Cloud& cloud, std::size_t frame) {
  std::vector<double> distances;
  for (const auto& point : cloud)
    distances.push_back(fuse_flow::io::demoSurfaceDistance(point.getVector3fMap().template cast<double>(), frame));
  std::sort(distances.begin(), distances.end());
  return {distances[distances.size() / 2], distances[distances.size() * 95 / 100]};
}

/** \brief The first measurement in each cell of 1 cm, which is about how dense the fused cloud is. Concatenation has most points
 *  where cameras are near and good; this has as many everywhere. */
Points onePerCentimetre(const Points& cloud) {
  std::vector<std::pair<std::array<int, 3>, std::size_t>> cells;
  for (std::size_t k = 0; k < cloud.size(); ++k)
    cells.push_back({{static_cast<int>(std::floor(100 * cloud[k].x)), static_cast<int>(std::floor(100 * cloud[k].y)),
                      static_cast<int>(std::floor(100 * cloud[k].z))},
                     k});
  std::sort(cells.begin(), cells.end());
  Points thinned;
  for (std::size_t k = 0; k < cells.size(); ++k)
    if (k == 0 || cells[k].first != cells[k - 1].first) thinned.push_back(cloud[cells[k].second]);
  return thinned;
}

/** \brief The demo recording at 320x240, fused with its calibrated cameras, or where the cameras really were. */
class DemoQuality : public testing::TestWithParam<bool> {};

TEST_P(DemoQuality, ComesOutNearerToTheTruthCleanerAndCovered) {
  fuse_flow::io::DemoOptions options;
  options.frames = scenes::kSanitized ? 1 : 2;
  options.width = 320;
  options.height = 240;
  const auto recording = fuse_flow::io::makeDemoRecording(options);
  options.sensor_noise = false;
  const auto exact = fuse_flow::io::makeDemoRecording(options);
  for (std::size_t frame = 0; frame < recording.depth.size(); ++frame) {
    fuse_flow::RigFrame rig;
    rig.cameras = GetParam() ? recording.cameras : recording.true_cameras;
    rig.views.resize(rig.cameras.size());
    for (std::size_t i = 0; i < rig.views.size(); ++i) rig.views[i].depth16 = recording.depth[frame][i].view();
    const scenes::Cloud fused = scenes::fuse(rig);
    const Points raw = concatenated(rig);
    const auto fused_distance = surfaceDistances(fused, frame), raw_distance = surfaceDistances(raw, frame);
    const auto thinned_distance = surfaceDistances(onePerCentimetre(raw), frame);
    EXPECT_LT(fused_distance[1], raw_distance[1]);
    // With exact poses the median of all measurements is that of the near surfaces, which have most pixels; only a cloud of the
    // same density is comparable.
    if (GetParam()) {
      EXPECT_LT(fused_distance[0], raw_distance[0]);
    }
    EXPECT_LT(fused_distance[0], 0.9 * thinned_distance[0]);
    EXPECT_LT(fused_distance[1], 0.9 * thinned_distance[1]);
    EXPECT_LT(multiCameraConsistency(fused, rig).violationShare(),
              multiCameraConsistency(raw, rig).violationShare() / 3);
    // Against what the cameras would have measured without noise: agreement with the noise itself is no merit.
    fuse_flow::RigFrame truth;
    truth.cameras = exact.true_cameras;
    truth.views.resize(truth.cameras.size());
    for (std::size_t i = 0; i < truth.views.size(); ++i) truth.views[i].depth16 = exact.depth[frame][i].view();
    const Quality quality = multiCameraConsistency(fused, truth), raw_quality = multiCameraConsistency(raw, truth);
    EXPECT_GE(quality.coverage(), 0.97 * raw_quality.coverage());
    EXPECT_LT(quality.error, 0.8 * raw_quality.error);
  }
}

INSTANTIATE_TEST_SUITE_P(WithCalibratedCameras, DemoQuality, testing::Values(true));
INSTANTIATE_TEST_SUITE_P(WithTrueCameras, DemoQuality, testing::Values(false));

constexpr const char* kFourViews = "0,60,120,180";

class RealRecording : public testing::TestWithParam<const char*> {};

TEST_P(RealRecording, AgreesBetterThanAVoxelGridWithAsManyPointsAndCoversAsMuch) {
  if (scenes::kSanitized && GetParam() != std::string(kFourViews)) GTEST_SKIP() << "the code of the other views";
  const std::string folder = std::string(FUSE_FLOW_TEST_SHARED_DATA) + "/seven_scenes";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  fuse_flow::io::RecordingOptions options;
  options.views = GetParam();
  options.read_color = false;
  fuse_flow::io::LoadedFrame frame;
  fuse_flow::io::openRecording({folder}, options)->read(0, frame);

  Points raw = concatenated(frame.rig), voxels;
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(raw.makeShared());
  grid.setLeafSize(0.01f, 0.01f, 0.01f);
  grid.filter(voxels);
  const scenes::Cloud fused = scenes::fuse(frame.rig);

  const Quality quality = multiCameraConsistency(fused, frame.rig),
                reference = multiCameraConsistency(voxels, frame.rig);
  EXPECT_LE(quality.multi_view_error, 0.80 * reference.multi_view_error);
  EXPECT_NEAR(static_cast<double>(fused.size()), static_cast<double>(voxels.size()),
              0.15 * static_cast<double>(voxels.size()));
  EXPECT_LE(quality.violationShare(), 0.01);
  EXPECT_GE(quality.coverage(), 0.97);
  RecordProperty("multi_view_error_ratio", std::to_string(quality.multi_view_error / reference.multi_view_error));
  RecordProperty("coverage", std::to_string(quality.coverage()));
  RecordProperty("violations", std::to_string(quality.violationShare()));
  RecordProperty("points_ratio",
                 std::to_string(static_cast<double>(fused.size()) / static_cast<double>(voxels.size())));
}

INSTANTIATE_TEST_SUITE_P(SevenScenes, RealRecording, testing::Values(kFourViews, "0:160:20"));

}  // namespace
