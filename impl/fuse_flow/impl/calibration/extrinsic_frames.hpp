#pragma once

#include <fuse_flow/rig_frame.h>

#include <pcl/exceptions.h>
#include <pcl/point_cloud.h>

#include <vector>

namespace fuse_flow {
namespace detail {

// What ExtrinsicEstimation asks of its input, wherever it runs.

/** \brief The cameras of the frames so far, or of a first one. */
inline void takeCameras(const RigFrame& frame, std::vector<Camera>& cameras) {
  checkRigFrame(frame);
  if (cameras.empty()) {
    cameras = frame.cameras;
    return;
  }
  if (cameras.size() != frame.cameras.size())
    throwBadArgument("fuse_flow::ExtrinsicEstimation: a frame of ", frame.cameras.size(), " cameras after one of ",
                     cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i)
    if (!sameInside(cameras[i], frame.cameras[i]))
      throwBadArgument("fuse_flow::ExtrinsicEstimation: camera '", frame.cameras[i].name,
                       "' has other intrinsics than in the frame before, must have the same");
}

inline std::vector<Eigen::Isometry3d> posesOf(const std::vector<Camera>& cameras) {
  std::vector<Eigen::Isometry3d> poses;
  for (const Camera& camera : cameras) poses.push_back(camera.T_world_camera);
  return poses;
}

/** \brief Throws unless there is a frame, and a pose for each camera to begin at. */
inline void checkInitialPoses(const std::vector<Camera>& cameras, std::size_t instants,
                              const std::vector<Eigen::Isometry3d>& initial) {
  if (instants == 0) throw pcl::PCLException("fuse_flow::ExtrinsicEstimation: no frame was added");
  if (initial.size() != cameras.size())
    throwBadArgument("fuse_flow::ExtrinsicEstimation: ", initial.size(), " poses for ", cameras.size(), " cameras");
  for (std::size_t i = 0; i < initial.size(); ++i)
    checkPose({"fuse_flow::ExtrinsicEstimation: camera '", cameras[i].name, "'"}, "initial pose", initial[i]);
}

/** \brief Organised clouds in their cameras' frames as depth images; null: missing. */
template <typename PointT>
class CloudFrame {
 public:
  CloudFrame(const std::vector<Camera>& cameras,
             const std::vector<typename pcl::PointCloud<PointT>::ConstPtr>& clouds) {
    if (cameras.size() != clouds.size())
      throwBadArgument("fuse_flow::ExtrinsicEstimation: ", cameras.size(), " cameras but ", clouds.size(), " clouds");
    rig.cameras = cameras;
    rig.views.resize(cameras.size());
    depths_.resize(cameras.size());
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      if (!clouds[i]) continue;
      for (const PointT& point : *clouds[i]) depths_[i].push_back(point.z);
      rig.views[i].depth32 = {depths_[i].data(), static_cast<int>(clouds[i]->width),
                              static_cast<int>(clouds[i]->height)};
    }
  }
  CloudFrame(const CloudFrame&) = delete;

  RigFrame rig;

 private:
  std::vector<std::vector<float>> depths_;
};

}  // namespace detail
}  // namespace fuse_flow
