#pragma once

#include <fuse_flow/point_types.h>

namespace fuse_flow::python {

/** \brief PointFusedCameras with the normal of the surface. */
struct EIGEN_ALIGN16 PointFusedNormalCameras {
  PCL_ADD_POINT4D
  PCL_ADD_NORMAL4D
  PCL_ADD_RGB
  float confidence{0};
  std::uint32_t view_count{0};
  std::uint32_t unused{0};
  std::uint32_t camera_mask[2]{0, 0};
  std::uint32_t unused_too[2]{0, 0};

  PointFusedNormalCameras() {
    x = y = z = normal_x = normal_y = normal_z = data_n[3] = 0.0f;
    data[3] = 1.0f;
    rgba = 0xff000000u;
  }
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

}  // namespace fuse_flow::python

POINT_CLOUD_REGISTER_POINT_STRUCT(fuse_flow::python::PointFusedNormalCameras,
                                  (float, x, x)(float, y, y)(float, z, z)(float, normal_x, normal_x)(
                                      float, normal_y, normal_y)(float, normal_z, normal_z)(std::uint32_t, rgba, rgba)(
                                      float, confidence, confidence)(std::uint32_t, view_count,
                                                                     view_count)(std::uint32_t[2], camera_mask,
                                                                                 camera_mask))
