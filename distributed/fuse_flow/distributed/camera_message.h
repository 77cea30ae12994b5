#pragma once

#include <fuse_flow/camera.h>
#include <fuse_flow/distributed/pose_message.h>

#include <cstdint>
#include <cstring>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Cameras as a message carries them: every number as it is in memory, so that FrameDigest sees no difference. Every part is taken
 *  apart by name, so that one that is added later does not compile until it is here. */
class CameraMessage {
 public:
  static void put(MessageWriter& out, const std::vector<Camera>& cameras) {
    out.put(static_cast<std::uint32_t>(cameras.size()));
    for (const Camera& camera : cameras) put(out, camera);
  }

  /** \brief Throws RankError for what cannot be. */
  static std::vector<Camera> get(MessageReader& in) {
    const auto count = in.get<std::uint32_t>();
    std::vector<Camera> cameras;  // grows as they come: the number may be wrong
    for (std::uint32_t k = 0; k < count; ++k) cameras.push_back(getCamera(in));
    return cameras;
  }

 private:
  static void put(MessageWriter& out, const Intrinsics& K) {
    const auto& [width, height, fx, fy, cx, cy, distortion] = K;
    const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = distortion;
    out.put(width);
    out.put(height);
    for (const float value : {fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6}) out.put(value);
  }
  static Intrinsics getIntrinsics(MessageReader& in) {
    Intrinsics K;
    auto& [width, height, fx, fy, cx, cy, distortion] = K;
    auto& [k1, k2, p1, p2, k3, k4, k5, k6] = distortion;
    width = in.get<int>();
    height = in.get<int>();
    for (float* value : {&fx, &fy, &cx, &cy, &k1, &k2, &p1, &p2, &k3, &k4, &k5, &k6}) *value = in.get<float>();
    return K;
  }

  static void put(MessageWriter& out, const std::vector<float>& values) {
    out.put(static_cast<std::uint32_t>(values.size()));
    out.put(values.data(), values.size());
  }
  static std::vector<float> getFloats(MessageReader& in) {
    const std::size_t count = in.get<std::uint32_t>();
    const char* bytes = in.take(count, sizeof(float));  // before so much is reserved
    std::vector<float> values(count);
    if (count > 0) std::memcpy(values.data(), bytes, count * sizeof(float));
    return values;
  }

  static void put(MessageWriter& out, const Camera& camera) {
    const auto& [name, intrinsics, depth_scale, pose, color, correction, multipath, noise] = camera;
    out.put(name);
    put(out, intrinsics);
    out.put(depth_scale);
    PoseMessage::put(out, pose);
    out.put(static_cast<std::uint8_t>(color.has_value()));
    if (color) {
      put(out, color->intrinsics);
      PoseMessage::put(out, color->T_depth_color);
    }
    const auto& [columns, rows, relative, per_metre] = correction;
    out.put(columns);
    out.put(rows);
    put(out, relative);
    put(out, per_metre);
    const auto& [frequency, reflectance] = multipath;
    out.put(frequency);
    out.put(reflectance);
    out.put(static_cast<std::uint8_t>(noise.has_value()));
    if (!noise) return;
    const auto& [floor, linear, quadratic] = *noise;
    for (const float value : {floor, linear, quadratic}) out.put(value);
  }
  static Camera getCamera(MessageReader& in) {
    Camera camera;
    auto& [name, intrinsics, depth_scale, pose, color, correction, multipath, noise] = camera;
    name = in.getText();
    intrinsics = getIntrinsics(in);
    depth_scale = in.get<float>();
    pose = PoseMessage::get(in);
    if (in.get<std::uint8_t>() != 0) {
      color.emplace();
      color->intrinsics = getIntrinsics(in);
      color->T_depth_color = PoseMessage::get(in);
    }
    auto& [columns, rows, relative, per_metre] = correction;
    columns = in.get<int>();
    rows = in.get<int>();
    relative = getFloats(in);
    per_metre = getFloats(in);
    auto& [frequency, reflectance] = multipath;
    frequency = in.get<float>();
    reflectance = in.get<float>();
    if (in.get<std::uint8_t>() != 0) {
      noise.emplace();
      auto& [floor, linear, quadratic] = *noise;
      for (float* value : {&floor, &linear, &quadratic}) *value = in.get<float>();
    }
    try {
      checkCamera(camera);
    } catch (const pcl::BadArgumentException&) {
      in.fail("a camera that cannot be");
    }
    return camera;
  }
};

}  // namespace distributed
}  // namespace fuse_flow
