#pragma once

#include <fuse_flow/gpu/point_layout.h>
#include <fuse_flow/gpu/runtime/execution.h>

#include <pcl/point_cloud.h>

#include <memory>
#include <utility>

namespace fuse_flow {
namespace gpu {

/** \brief A point cloud in device memory: what the filters for device::Thrust take from and hand to each other without a copy
 *  over the bus. It moves, it is not copied; its memory grows and is kept, so that a cloud that is used frame after frame
 *  allocates nothing. Filters that follow each other must run on one stream (setStream()). Only one thread at a time may use an object. */
template <typename PointT>
class DeviceCloud {
 public:
  using Layout = PointLayout<PointT>;
  using Words = typename Layout::Words;
  using Ptr = std::shared_ptr<DeviceCloud>;
  using ConstPtr = std::shared_ptr<const DeviceCloud>;

  ///@{
  /** \brief As those of pcl::PointCloud. */
  pcl::PCLHeader header;
  std::uint32_t width{0};
  std::uint32_t height{0};
  bool is_dense{true};
  Eigen::Vector4f sensor_origin_ = Eigen::Vector4f::Zero();
  Eigen::Quaternionf sensor_orientation_ = Eigen::Quaternionf::Identity();
  ///@}

  std::size_t size() const { return std::size_t{width} * height; }
  bool empty() const { return size() == 0; }
  bool isOrganized() const { return height > 1; }

  /** \brief The points, in device memory. */
  const PointT* data() const { return reinterpret_cast<const PointT*>(points_.data()); }
  ///@{
  /** \brief The same, as device code reads and writes them: see PointLayout. */
  const Words* words() const { return points_.data(); }
  Words* words() { return points_.data(); }
  ///@}

  /** \brief Its contents are lost where it grows. */
  void resize(std::uint32_t new_width, std::uint32_t new_height) {
    points_.resize(std::size_t{new_width} * new_height);
    width = new_width;
    height = new_height;
  }

  /** \brief From and to a cloud in host memory; waits for the stream. */
  void upload(const pcl::PointCloud<PointT>& cloud, Stream stream = {}) {
    resize(cloud.width, cloud.height);
    copyHeader(cloud, *this);
    Execution run;
    run.stream = stream;
    run.copy(words(), reinterpret_cast<const Words*>(cloud.data()), size());
    run.wait();
  }
  void download(pcl::PointCloud<PointT>& cloud, Stream stream = {}) const {
    cloud.resize(size());
    cloud.width = width;
    cloud.height = height;
    copyHeader(*this, cloud);
    Execution run;
    run.stream = stream;
    run.copy(reinterpret_cast<Words*>(cloud.data()), words(), size());
    run.wait();
  }

  /** \brief Device memory held. */
  std::size_t bytes() const { return points_.bytes(); }

  /** \brief What both kinds of clouds have besides points and size. */
  template <typename From, typename To>
  static void copyHeader(const From& from, To& to) {
    to.header = from.header;
    to.is_dense = from.is_dense;
    to.sensor_origin_ = from.sensor_origin_;
    to.sensor_orientation_ = from.sensor_orientation_;
  }

  EIGEN_MAKE_ALIGNED_OPERATOR_NEW

 private:
  DeviceBuffer<Words> points_;
};

}  // namespace gpu
}  // namespace fuse_flow
