#include "recordings/messages/ros_messages.h"

namespace fuse_flow::io {
namespace {

Nanoseconds readTime(WireReader& in) {
  const Nanoseconds seconds = in.u32();  // of ROS 2 an int32, which no date of now makes negative
  return seconds * 1'000'000'000 + in.u32();
}

}  // namespace

HeaderMessage readHeader(WireReader& in) {
  HeaderMessage header;
  if (in.headersAreNumbered()) in.u32();
  header.stamp = readTime(in);
  header.frame = in.text();
  if (!header.frame.empty() && header.frame[0] == '/') header.frame.erase(0, 1);  // as tf wrote it before tf2
  return header;
}

ImageMessage readImage(WireReader& in) {
  ImageMessage image;
  image.header = readHeader(in);
  image.height = in.u32();
  image.width = in.u32();
  image.encoding = in.text();
  image.big_endian = in.u8() != 0;
  image.step = in.u32();
  image.data = in.bytes();
  return image;
}

CompressedImageMessage readCompressedImage(WireReader& in) {
  CompressedImageMessage image;
  image.header = readHeader(in);
  image.format = in.text();
  image.data = in.bytes();
  return image;
}

CameraInfoMessage readCameraInfo(WireReader& in) {
  CameraInfoMessage info;
  info.header = readHeader(in);
  info.height = in.u32();
  info.width = in.u32();
  info.distortion_model = in.text();
  constexpr std::uint32_t most = 64;  // OpenCV has 14
  const std::uint32_t coefficients = in.u32();
  for (std::uint32_t k = 0; k < coefficients; ++k) {
    const double value = in.f64();
    if (k < most) info.D.push_back(value);
  }
  for (double& k : info.K) k = in.f64();
  for (int k = 0; k < 9; ++k) in.f64();  // R
  for (double& p : info.P) p = in.f64();
  info.binning_x = in.u32();
  info.binning_y = in.u32();
  info.roi_x = in.u32();
  info.roi_y = in.u32();
  info.roi_height = in.u32();
  info.roi_width = in.u32();
  return info;
}

Eigen::Isometry3d readTransform(WireReader& in) {
  double t[3], q[4];
  for (double& value : t) value = in.f64();
  for (double& value : q) value = in.f64();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << t[0], t[1], t[2];
  T.linear() = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
  return T;
}

std::vector<TransformMessage> readTransforms(WireReader& in) {
  const std::uint32_t count = in.u32();
  std::vector<TransformMessage> transforms;
  for (std::uint32_t k = 0; k < count; ++k) {
    TransformMessage transform;
    transform.header = readHeader(in);
    transform.child = in.text();
    if (!transform.child.empty() && transform.child[0] == '/') transform.child.erase(0, 1);
    transform.T_parent_child = readTransform(in);
    transforms.push_back(std::move(transform));
  }
  return transforms;
}

}  // namespace fuse_flow::io
