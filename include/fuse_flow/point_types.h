#pragma once

#include <pcl/pcl_macros.h>
#include <pcl/point_types.h>
#include <pcl/register_point_struct.h>

#include <cstdint>

namespace fuse_flow {

/** \brief A fused point: position, colour, ω and the number of cameras that contributed. */
struct EIGEN_ALIGN16 PointFused {
  PCL_ADD_POINT4D
  PCL_ADD_RGB
  /** \brief ω of eq. 10, in (0, 1]. */
  float confidence{0};
  /** \brief Cameras that it is from, see PointCameras. */
  std::uint32_t view_count{0};
  /** \brief Not a PCL field. It fills the padding, so that equal points have equal bytes. */
  std::uint32_t unused{0};

  PointFused() {
    x = y = z = 0.0f;
    data[3] = 1.0f;
    rgba = 0xff000000u;
  }
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

/** \brief A PointFused that also stores which cameras contributed to it. */
struct EIGEN_ALIGN16 PointFusedCameras {
  PCL_ADD_POINT4D
  PCL_ADD_RGB
  /** \brief ω of eq. 10, in (0, 1]. */
  float confidence{0};
  /** \brief Cameras that it is from, see PointCameras. */
  std::uint32_t view_count{0};
  /** \brief No field, as in PointFused. */
  std::uint32_t unused{0};
  /** \brief One bit for each contributing camera: cameras 0 to 31, then 32 to 63. Cameras from 64 on have no bit. */
  std::uint32_t camera_mask[2]{0, 0};
  /** \brief No field. */
  std::uint32_t unused_too[2]{0, 0};

  PointFusedCameras() {
    x = y = z = 0.0f;
    data[3] = 1.0f;
    rgba = 0xff000000u;
  }
  /** \brief Whether the camera contributed to the point. \param camera its number in the frame, below 64 */
  bool isFrom(std::uint32_t camera) const { return (camera_mask[camera / 32] >> camera % 32 & 1u) != 0; }
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

}  // namespace fuse_flow

POINT_CLOUD_REGISTER_POINT_STRUCT(fuse_flow::PointFused,
                                  (float, x, x)(float, y, y)(float, z, z)(std::uint32_t, rgba, rgba)(
                                      float, confidence, confidence)(std::uint32_t, view_count, view_count))

POINT_CLOUD_REGISTER_POINT_STRUCT(fuse_flow::PointFusedCameras,
                                  (float, x, x)(float, y, y)(float, z, z)(std::uint32_t, rgba, rgba)(
                                      float, confidence, confidence)(std::uint32_t, view_count,
                                                                     view_count)(std::uint32_t[2], camera_mask,
                                                                                 camera_mask))
