#pragma once

#include <pcl/pcl_macros.h>
#include <pcl/point_types.h>
#include <pcl/register_point_struct.h>

#include <cstdint>

namespace fuse_flow::io {

/** \brief PointFused with the normal of the surface, and the cameras that it is from. */
struct EIGEN_ALIGN16 PointFusedNormal {
  PCL_ADD_POINT4D
  PCL_ADD_NORMAL4D
  PCL_ADD_RGB
  float confidence{0};
  std::uint32_t view_count{0};
  /** \brief No field. */
  std::uint32_t unused{0};
  /** \brief As PointFusedCameras::camera_mask. */
  std::uint32_t camera_mask[2]{0, 0};
  /** \brief No field. */
  std::uint32_t unused_too[2]{0, 0};

  PointFusedNormal() {
    x = y = z = normal_x = normal_y = normal_z = data_n[3] = 0.0f;
    data[3] = 1.0f;
    rgba = 0xff000000u;
  }
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

}  // namespace fuse_flow::io

POINT_CLOUD_REGISTER_POINT_STRUCT(fuse_flow::io::PointFusedNormal,
                                  (float, x, x)(float, y, y)(float, z, z)(float, normal_x, normal_x)(
                                      float, normal_y, normal_y)(float, normal_z, normal_z)(std::uint32_t, rgba, rgba)(
                                      float, confidence, confidence)(std::uint32_t, view_count,
                                                                     view_count)(std::uint32_t[2], camera_mask,
                                                                                 camera_mask))
