#include "evaluation/tables/open3d_methods.h"

#include <fuse_flow/impl/sensors/preprocessing.hpp>

#include <open3d/camera/PinholeCameraIntrinsic.h>
#include <open3d/geometry/Image.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/geometry/RGBDImage.h>
#include <open3d/pipelines/integration/ScalableTSDFVolume.h>

#include <algorithm>
#include <chrono>
#include <cstring>

namespace fuse_flow::tables {
namespace {

using Clock = std::chrono::steady_clock;
using Cloud = io::Method::Cloud;

constexpr const char* kDownSampling = "open3d_voxel_down_sample";
constexpr const char* kTsdf = "open3d_tsdf";

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

open3d::geometry::PointCloud toOpen3d(const Cloud& cloud) {
  open3d::geometry::PointCloud result;
  result.points_.reserve(cloud.size());
  result.colors_.reserve(cloud.size());
  for (const PointFused& p : cloud) {
    result.points_.push_back(p.getVector3fMap().cast<double>());
    result.colors_.push_back(Eigen::Vector3d(p.r, p.g, p.b) / 255);
  }
  return result;
}

void fromOpen3d(const open3d::geometry::PointCloud& cloud, Cloud& result) {
  result.clear();
  result.reserve(cloud.points_.size());
  for (std::size_t k = 0; k < cloud.points_.size(); ++k) {
    PointFused& p = result.emplace_back();
    p.getVector3fMap() = cloud.points_[k].cast<float>();
    const Eigen::Vector3d color = (255 * cloud.colors_[k].array() + 0.5).max(0).min(255);
    p.r = static_cast<std::uint8_t>(color.x());
    p.g = static_cast<std::uint8_t>(color.y());
    p.b = static_cast<std::uint8_t>(color.z());
    p.confidence = 1.0f;
    p.view_count = 1;
  }
}

/** \brief The concatenated cloud through PointCloud::VoxelDownSample(). */
class VoxelDownSampling : public io::Method {
 public:
  explicit VoxelDownSampling(const io::MethodOptions& options)
      : concatenation_(io::makeMethod("concatenate", options)), leaf_(static_cast<double>(options.leaf_size)) {}

  void fuse(const RigFrame& frame, Cloud& output) override {
    concatenation_->fuse(frame, output);
    const open3d::geometry::PointCloud all = toOpen3d(output);
    const Clock::time_point start = Clock::now();
    const auto thinned = all.VoxelDownSample(leaf_);
    statistics_ = concatenation_->statistics();
    statistics_.total_ms += millisecondsSince(start);
    fromOpen3d(*thinned, output);
    statistics_.fused_points = output.size();
  }

 private:
  std::unique_ptr<io::Method> concatenation_;
  double leaf_;
};

/** \brief Every view into a ScalableTSDFVolume of its own frame, and its surface out. Its depth is that of the other peers, multipath interference
 *  taken away; the truncation is that of Open3D's own examples. For lenses without distortion, as the simulator's are. */
class Tsdf : public io::Method {
 public:
  explicit Tsdf(const io::MethodOptions& options) : options_(options) {}

  void fuse(const RigFrame& frame, Cloud& output) override {
    using open3d::pipelines::integration::ScalableTSDFVolume;
    using open3d::pipelines::integration::TSDFVolumeColorType;
    statistics_ = {};
    ScalableTSDFVolume volume(static_cast<double>(options_.leaf_size), 0.04, TSDFVolumeColorType::RGB8);
    for (std::size_t i = 0; i < frame.cameras.size(); ++i) {
      if (frame.views[i].missing()) continue;
      const open3d::geometry::RGBDImage image = imageOf(frame.cameras[i], frame.views[i]);
      const Intrinsics& K = frame.cameras[i].intrinsics;
      const Eigen::Matrix4d T_camera_world = frame.cameras[i].T_world_camera.inverse().matrix();
      const Clock::time_point start = Clock::now();
      volume.Integrate(image,
                       {K.width, K.height, static_cast<double>(K.fx), static_cast<double>(K.fy),
                        static_cast<double>(K.cx), static_cast<double>(K.cy)},
                       T_camera_world);
      statistics_.total_ms += millisecondsSince(start);
    }
    const Clock::time_point start = Clock::now();
    const auto surface = volume.ExtractPointCloud();
    statistics_.total_ms += millisecondsSince(start);
    fromOpen3d(*surface, output);
    statistics_.fused_points = output.size();
  }

 private:
  open3d::geometry::RGBDImage imageOf(const Camera& camera, const DepthView& view) const {
    host::ViewGeometry geometry;
    geometry.assign(camera);
    open3d::geometry::RGBDImage image;
    image.depth_.Prepare(view.width(), view.height(), 1, sizeof(float));
    image.color_.Prepare(view.width(), view.height(), 3, 1);
    host::DepthMap depth;
    host::makeDepthMap(options_.parameters.preprocessing, geometry, view, depth);
    for (int v = 0; v < view.height(); ++v) {
      std::copy_n(depth.row(v), view.width(), image.depth_.PointerAt<float>(0, v));
      if (view.color)
        std::memcpy(image.color_.PointerAt<std::uint8_t>(0, v, 0), view.color.row(v),
                    3 * static_cast<std::size_t>(view.width()));
    }
    return image;
  }

  io::MethodOptions options_;
};

}  // namespace

std::vector<Open3dPeer> open3dPeers() {
  return {{"Open3D, voxel down-sampling", kDownSampling}, {"Open3D, TSDF", kTsdf}};
}

std::unique_ptr<io::Method> makeOpen3dMethod(const std::string& name, const io::MethodOptions& options) {
  if (name == kDownSampling) return std::make_unique<VoxelDownSampling>(options);
  if (name == kTsdf) return std::make_unique<Tsdf>(options);
  return nullptr;
}

}  // namespace fuse_flow::tables
