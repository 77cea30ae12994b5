#pragma once

#include "fusion.h"
#include "methods/point_fused_normal.h"
#include "pool.h"

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <pcl/point_cloud.h>
#include <pcl/type_traits.h>

#include <memory>

namespace fuse_flow::python {

/** \brief Where a field lies, in bytes: a number, as PCL's constants have no address. */
template <typename PointT, typename Field>
constexpr std::size_t offsetOf() {
  return pcl::traits::offset<PointT, Field>::value;
}

/** \brief Where the fields lie that are asked for. */
template <typename PointT>
PointLayout layoutOf(const PointExtras& extras = {}) {
  namespace fields = pcl::fields;
  PointLayout layout;
  layout.size = sizeof(PointT);
  layout.rgba = offsetOf<PointT, fields::rgba>();
  layout.confidence = offsetOf<PointT, fields::confidence>();
  layout.view_count = offsetOf<PointT, fields::view_count>();
  if constexpr (pcl::traits::has_field<PointT, fields::normal_x>::value)
    if (extras.normals) layout.normal = offsetOf<PointT, fields::normal_x>();
  if constexpr (pcl::traits::has_field<PointT, fields::camera_mask>::value)
    if (extras.camera_mask) layout.camera_mask = offsetOf<PointT, fields::camera_mask>();
  return layout;
}

/** \brief A FuseFlow with clouds in host memory. */
template <typename PointT, typename Device>
class FusionOf : public Fusion {
 public:
  explicit FusionOf(const PointExtras& extras) : extras_(extras) { fusion_.setComputeNormals(extras.normals); }
  void setParameters(const FuseFlowParameters& parameters) override { fusion_.setParameters(parameters); }
  void setNumberOfThreads(unsigned int threads) override { fusion_.setNumberOfThreads(threads); }
  FrameStatistics statistics() const override { return fusion_.getStatistics(); }

  Cloud fuse(const RigFrame& frame) override {
    const std::shared_ptr<pcl::PointCloud<PointT>> points = pool_->take();
    fusion_.fuse(frame, *points);
    return {points, reinterpret_cast<std::byte*>(points->data()), points->size(), layoutOf<PointT>(extras_),
            frame.stamp};
  }

 private:
  PointExtras extras_;
  FuseFlow<PointT, Device> fusion_;
  std::shared_ptr<Pool<pcl::PointCloud<PointT>>> pool_ = std::make_shared<Pool<pcl::PointCloud<PointT>>>();
};

/** \brief With points that have at least what is asked for: two kinds, as each takes long to compile for a GPU. */
template <typename Device>
std::unique_ptr<Fusion> makeFusion(const PointExtras& extras) {
  if (extras.normals || extras.camera_mask) return std::make_unique<FusionOf<io::PointFusedNormal, Device>>(extras);
  return std::make_unique<FusionOf<PointFused, Device>>(extras);
}

}  // namespace fuse_flow::python
