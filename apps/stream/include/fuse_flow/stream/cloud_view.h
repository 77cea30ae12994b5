#pragma once

#include <fuse_flow/math/host_device.h>
#include <fuse_flow/point_traits.h>

#include <pcl/point_cloud.h>

#include <cstddef>
#include <cstdint>

namespace fuse_flow::stream {

/** \brief Where the fields of a cloud's points lie in memory, so that code which is compiled once reads points of every type. It points into
 *  the cloud, which must stay as it is. */
struct CloudView {
  const unsigned char* points{nullptr};  ///< the first point
  std::size_t size{0};                   ///< points
  std::size_t stride{0};                 ///< bytes from one point to the next
  // Bytes from the beginning of a point; negative: it has no such field.
  int color{-1};        ///< 4 bytes b, g, r, a, as in PCL's rgba
  int confidence{-1};   ///< float, 0 to 1
  int view_count{-1};   ///< 32-bit integer
  int normal{-1};       ///< 3 × float
  int camera_mask{-1};  ///< 2 × std::uint32_t, see PointFusedCameras

  /** \brief x, y, z in metres. */
  FUSE_FLOW_HD const float* position(std::size_t point) const {
    return reinterpret_cast<const float*>(points + point * stride);
  }
  template <typename T>
  FUSE_FLOW_HD const T* field(int offset, std::size_t point) const {
    return reinterpret_cast<const T*>(points + point * stride + offset);
  }
};

/** \brief The fields that PointT has, of those that a stream carries. \tparam PointT a point type of PCL, with x, y, z
 *  \param points in any memory */
template <typename PointT>
CloudView viewOf(const PointT* points, std::size_t size) {
  namespace fields = pcl::fields;
  static_assert(pcl::traits::offset<PointT, fields::x>::value == 0, "x, y and z come first, as in all of PCL's types");
  CloudView view;
  view.points = reinterpret_cast<const unsigned char*>(points);
  view.size = size;
  view.stride = sizeof(PointT);
  if constexpr (point::has_color<PointT>)
    view.color = static_cast<int>(pcl::traits::offset<PointT, point::ColorField<PointT>>::value);
  if constexpr (point::has_confidence<PointT>)
    view.confidence = static_cast<int>(pcl::traits::offset<PointT, fields::confidence>::value);
  if constexpr (point::has_view_count<PointT>)
    view.view_count = static_cast<int>(pcl::traits::offset<PointT, fields::view_count>::value);
  if constexpr (point::has_normal<PointT>)
    view.normal = static_cast<int>(pcl::traits::offset<PointT, fields::normal_x>::value);
  if constexpr (point::has_camera_mask<PointT>)
    view.camera_mask = static_cast<int>(pcl::traits::offset<PointT, fields::camera_mask>::value);
  return view;
}
template <typename PointT>
CloudView viewOf(const pcl::PointCloud<PointT>& cloud) {
  return viewOf(cloud.points.data(), cloud.size());
}

}  // namespace fuse_flow::stream
