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
  /** \brief Cameras that contributed: those of the representatives, at most three. */
  std::uint32_t view_count{0};
  /** \brief No field: fills what would be padding, so that the same points are the same bytes. */
  std::uint32_t unused{0};

  PointFused() {
    x = y = z = 0.0f;
    data[3] = 1.0f;
    rgba = 0xff000000u;
  }
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

}  // namespace fuse_flow

POINT_CLOUD_REGISTER_POINT_STRUCT(fuse_flow::PointFused,
                                  (float, x, x)(float, y, y)(float, z, z)(std::uint32_t, rgba, rgba)(
                                      float, confidence, confidence)(std::uint32_t, view_count, view_count))
