#pragma once

/** \file
 *  \brief The point types for which filters and fusion are tested: PCL's, the library's own and a user's. */

#include <fuse_flow/point_types.h>

#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <string>
#include <type_traits>

namespace conformance {

/** \brief What a user of the library may bring: members named otherwise than fields, and a field nobody else knows. */
struct EIGEN_ALIGN16 OddPoint {
  double preamble{0};  // moves the offsets
  double preamble_too{0};
  PCL_ADD_POINT4D
  float m_trust{0};
  float m_warmth{0};
  std::uint32_t m_serial{0};
  OddPoint() { x = y = z = 0, data[3] = 1; }
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

}  // namespace conformance

POINT_CLOUD_REGISTER_POINT_STRUCT(conformance::OddPoint,
                                  (float, x, x)(float, y, y)(float, z, z)(float, m_trust, confidence)(
                                      float, m_warmth, temperature)(std::uint32_t, m_serial, serial_number))

namespace conformance {

// Under sanitizers a few: what differs between the others is found without.
#if defined(FUSE_FLOW_TEST_FEW_POINT_TYPES)
using PointTypes = ::testing::Types<pcl::PointXYZ, fuse_flow::PointFused, OddPoint>;
#else
using PointTypes = ::testing::Types<pcl::PointXYZ, pcl::PointXYZI, pcl::PointXYZRGB, pcl::PointXYZRGBNormal,
                                    pcl::PointSurfel, fuse_flow::PointFused, OddPoint>;
#endif

template <typename P>
std::string pointName() {
  if (std::is_same_v<P, pcl::PointXYZ>) return "PointXYZ";
  if (std::is_same_v<P, pcl::PointXYZI>) return "PointXYZI";
  if (std::is_same_v<P, pcl::PointXYZRGB>) return "PointXYZRGB";
  if (std::is_same_v<P, pcl::PointXYZRGBNormal>) return "PointXYZRGBNormal";
  if (std::is_same_v<P, pcl::PointSurfel>) return "PointSurfel";
  if (std::is_same_v<P, fuse_flow::PointFused>) return "PointFused";
  return "OddPoint";
}

struct PointName {
  template <typename P>
  static std::string GetName(int) {
    return pointName<P>();
  }
};

}  // namespace conformance
