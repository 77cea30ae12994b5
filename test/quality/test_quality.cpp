#include "../scenes.h"
#include "../simulated_recording.h"
#include "simulation/true_view.h"

#include <fuse_flow/quality/reprojection_quality.h>
#include <fuse_flow/quality/surface_quality.h>
#include <fuse_flow/recordings/recording.h>

#include <pcl/filters/voxel_grid.h>

#include <filesystem>

namespace {

using fuse_flow::reprojectionQuality;
using fuse_flow::ReprojectionQuality;
using fuse_flow::ReprojectionQualityParameters;
using fuse_flow::surfaceQuality;
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
        const auto z = static_cast<double>(frame.cameras[i].depth_scale) * raw;
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

/** \brief Median and 95th percentile of the distance to the true surface, and the share of ghosts, over 30 mm from it; of every third
 *  point, which is enough. */
template <typename Cloud>
std::array<float, 3> surfaceDistances(const Cloud& cloud, const fuse_flow::simulation::RayScene& surfaces) {
  std::vector<float> distances;
  for (std::size_t k = 0; k < cloud.size(); k += 3) distances.push_back(surfaces.nearest(cloud[k].getVector3fMap()).t);
  std::sort(distances.begin(), distances.end());
  const auto ghosts = distances.end() - std::upper_bound(distances.begin(), distances.end(), 0.03f);
  return {distances[distances.size() / 2], distances[distances.size() * 95 / 100],
          static_cast<float>(ghosts) / static_cast<float>(distances.size())};
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

/** \brief A frame as its cameras would have measured it without noise, in the true places, and the memory behind it. */
struct TrueFrame {
  TrueFrame(fuse_flow::simulation::Simulator& simulator, std::size_t frame) {
    rig.cameras = simulator.trueCameras();
    rig.views.resize(rig.cameras.size());
    for (const fuse_flow::Camera& camera : rig.cameras)
      depth.push_back(fuse_flow::simulation::renderTrueView(simulator.truth(frame), camera.intrinsics,
                                                            camera.T_world_camera, Eigen::Vector3f::Zero(), 2)
                          .depth);
    for (std::size_t i = 0; i < rig.views.size(); ++i) rig.views[i].depth32 = depth[i].view();
  }

  fuse_flow::RigFrame rig;
  std::vector<fuse_flow::io::FloatImage> depth;
};

/** \brief The demo recording at 320x240, fused with its calibrated cameras, or where the cameras really were. */
class DemoQuality : public testing::TestWithParam<bool> {};

TEST_P(DemoQuality, ComesOutNearerToTheTruthCleanerAndCovered) {
  fuse_flow::simulation::Simulator simulator(simulated_recording::options(0.5));
  const auto frames = simulated_recording::frames(simulator, scenes::kSanitized ? 1 : 2);
  for (std::size_t frame = 0; frame < frames.size(); ++frame) {
    fuse_flow::RigFrame rig = frames[frame].rig;
    if (!GetParam()) rig.cameras = simulator.trueCameras();
    const scenes::Cloud fused = scenes::fuse(rig);
    const Points raw = concatenated(rig);
    const fuse_flow::simulation::RayScene& surfaces = simulator.truth(frame);
    const auto fused_distance = surfaceDistances(fused, surfaces);
    // Thinned as well: the median of all measurements is that of the near surfaces, which have most pixels.
    for (const Points& peer : {raw, onePerCentimetre(raw)}) {
      const auto distance = surfaceDistances(peer, surfaces);
      EXPECT_LT(fused_distance[0], 0.4f * distance[0]);
      EXPECT_LT(fused_distance[1], 0.4f * distance[1]);
      EXPECT_LT(fused_distance[2], 0.1f * distance[2]);
    }
    // Away from silhouettes: at the exact pixel, poses a few millimetres off make points at edges count.
    EXPECT_LT(surfaceQuality(fused, rig).violationShare(), 0.375 * surfaceQuality(raw, rig).violationShare());
    EXPECT_LT(reprojectionQuality(fused, rig).violationShare(), 0.6 * reprojectionQuality(raw, rig).violationShare());
    // Against what the cameras would have measured without noise: agreement with the noise itself is no merit.
    const TrueFrame truth(simulator, frame);
    const ReprojectionQuality quality = reprojectionQuality(fused, truth.rig),
                              raw_quality = reprojectionQuality(raw, truth.rig);
    EXPECT_GT(quality.coverage(), raw_quality.coverage());
    EXPECT_LT(quality.error, 0.55 * raw_quality.error);
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

  const ReprojectionQuality quality = reprojectionQuality(fused, frame.rig),
                            reference = reprojectionQuality(voxels, frame.rig);
  EXPECT_LE(quality.multi_view_error, 0.80 * reference.multi_view_error);
  EXPECT_NEAR(static_cast<double>(fused.size()), static_cast<double>(voxels.size()),
              0.15 * static_cast<double>(voxels.size()));
  const double violations = surfaceQuality(fused, frame.rig).violationShare();
  EXPECT_LE(violations, 0.01);
  EXPECT_LE(quality.violationShare(),
            0.3 * reference.violationShare());  // most of those left are true surface at edges
  EXPECT_GE(quality.coverage(), 0.97);
  RecordProperty("multi_view_error_ratio", std::to_string(quality.multi_view_error / reference.multi_view_error));
  RecordProperty("coverage", std::to_string(quality.coverage()));
  RecordProperty("violations_off_silhouettes", std::to_string(violations));
  RecordProperty("points_ratio",
                 std::to_string(static_cast<double>(fused.size()) / static_cast<double>(voxels.size())));
}

INSTANTIATE_TEST_SUITE_P(SevenScenes, RealRecording, testing::Values(kFourViews, "0:160:20"));

}  // namespace
