#pragma once

#include <fuse_flow/math/pinhole.h>
#include <fuse_flow/recordings/image.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace fuse_flow::io {

/** \brief Copies an image whose rows begin every stride bytes. */
template <typename Pixel>
void copyRows(const void* rows, std::size_t stride, int width, int height, Image<Pixel>& into) {
  into.resize(width, height);
  const auto* from = static_cast<const std::uint8_t*>(rows);
  const std::size_t bytes = static_cast<std::size_t>(width) * sizeof(Pixel);
  for (int v = 0; v < height; ++v, from += stride) std::memcpy(&into.at(0, v), from, bytes);
}

/** \brief A lens without distortion whose optical axis goes through the middle of the image. \param focal_length pixels */
inline Intrinsics centredLens(int width, int height, float focal_length) {
  const auto middle = [](int size) { return 0.5f * static_cast<float>(size - 1); };
  return {width, height, focal_length, focal_length, middle(width), middle(height), {}};
}

/** \brief A pose as librealsense2 gives it. \param rotation column by column  \param translation metres */
inline Eigen::Isometry3d columnMajorPose(const float (&rotation)[9], const float (&translation)[3]) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Matrix3d printed = Eigen::Map<const Eigen::Matrix3f>(rotation).cast<double>();
  pose.linear() = Eigen::Quaterniond(printed).normalized().toRotationMatrix();  // rigid to the last digit of a double
  pose.translation() = Eigen::Map<const Eigen::Vector3f>(translation).cast<double>();
  return pose;
}

/** \brief A pose as OrbbecSDK gives it. \param rotation row by row  \param translation millimetres */
inline Eigen::Isometry3d rowMajorPose(const float (&rotation)[9], const float (&translation)[3]) {
  constexpr float metres = 0.001f;
  const float columns[9] = {rotation[0], rotation[3], rotation[6], rotation[1], rotation[4],
                            rotation[7], rotation[2], rotation[5], rotation[8]};
  return columnMajorPose(columns, {metres * translation[0], metres * translation[1], metres * translation[2]});
}

/** \brief Depth in another unit. What is then more than 16 bits hold is a hole. \param factor new units that an old one is */
inline void rescaleDepth(DepthImage& depth, float factor) {
  constexpr float most = 65535;
  for (std::uint16_t& value : depth.data) {
    const float scaled = factor * static_cast<float>(value) + 0.5f;
    value = scaled < most + 1 ? static_cast<std::uint16_t>(scaled) : std::uint16_t{0};
  }
}

/** \brief The stamps of a counter of microseconds with 32 bits, which begins again at 0 after 71.6 minutes, as one that does not. Stamps that go back by
 *  less than half of that are those of a camera that was started again, and stay as they are. */
class UnwrappedStamp {
 public:
  std::uint64_t operator()(std::uint64_t stamp) {
    constexpr std::uint64_t period = std::uint64_t{1} << 32;
    if (stamp < period && last_ < period && last_ > stamp && last_ - stamp > period / 2) wraps_ += period;
    last_ = stamp;
    return stamp + wraps_;
  }

 private:
  std::uint64_t last_{0};
  std::uint64_t wraps_{0};
};

}  // namespace fuse_flow::io
