#pragma once

/** \file
 *  \brief A made-up room for the benchmarks: any number of cameras of any size, Kinect-like noise, the same on every machine. */

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/rig_frame.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace bench {

/** \brief Images of one instant and the frame that points at them. The images lie in one piece of memory that the caller
 *  provides, camera by camera: depth of all, then colour of all. */
class Room {
 public:
  /** \brief Cameras all around the room; or on an arc, 6° apart at two heights, as multi-view stereo needs them. */
  Room(int cameras, int width, int height, bool on_arc = false) : width_(width), height_(height) {
    for (int i = 0; i < cameras; ++i) {
      const double angle = on_arc ? 0.3 + i * M_PI / 30 : 2 * M_PI * (i + 0.37) / cameras;
      const double height_of_camera = on_arc ? 1.3 + 0.3 * (i % 2) : 1.3 + 0.9 * ((i * 5) % 8) / 7.0;
      const Eigen::Vector3d eye(2.6 * std::cos(angle), 2.1 * std::sin(angle), height_of_camera);
      const Eigen::Vector3d target(-0.6 * std::cos(angle), -0.5 * std::sin(angle), 0.9);
      fuse_flow::Camera camera;
      camera.name = "bench " + std::to_string(i);
      camera.intrinsics.width = width;
      camera.intrinsics.height = height;
      camera.intrinsics.fx = camera.intrinsics.fy = 0.82f * static_cast<float>(width);  // Kinect v1's field of view
      camera.intrinsics.cx = 0.5f * static_cast<float>(width - 1);
      camera.intrinsics.cy = 0.5f * static_cast<float>(height - 1);
      const Eigen::Vector3d forward = (target - eye).normalized();
      const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
      camera.T_world_camera.linear() << right, forward.cross(right), forward;
      camera.T_world_camera.translation() = eye;
      cameras_.push_back(camera);
    }
  }

  std::size_t pixelsOfCamera() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_); }
  std::size_t pixels() const { return cameras_.size() * pixelsOfCamera(); }
  std::size_t bytes() const { return 5 * pixels(); }

  /** \brief Fills memory of bytes() and points a frame at it. */
  fuse_flow::RigFrame render(char* memory, std::uint32_t seed) const {
    auto* depth = reinterpret_cast<std::uint16_t*>(memory);
    auto* color = reinterpret_cast<fuse_flow::Rgb8*>(memory + 2 * pixels());
    const std::size_t rows = static_cast<std::size_t>(height_);
    fuse_flow::host::parallelFor(
        fuse_flow::host::resolveThreads(0), cameras_.size() * rows, [&](std::size_t task, int) {
          const std::size_t i = task / rows, v = task % rows;
          renderRow(i, static_cast<int>(v), seed, depth + task * static_cast<std::size_t>(width_),
                    color + task * static_cast<std::size_t>(width_));
        });
    return frameAt(memory);
  }

  /** \brief A frame that points at memory of bytes() that has been filled. */
  fuse_flow::RigFrame frameAt(const char* memory) const {
    const auto* depth = reinterpret_cast<const std::uint16_t*>(memory);
    const auto* color = reinterpret_cast<const fuse_flow::Rgb8*>(memory + 2 * pixels());
    fuse_flow::RigFrame frame;
    frame.cameras = cameras_;
    frame.views.resize(cameras_.size());
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      frame.views[i].depth16 = {depth + i * pixelsOfCamera(), width_, height_};
      frame.views[i].color = {color + i * pixelsOfCamera(), width_, height_};
    }
    return frame;
  }

 private:
  /** \brief 6 × 5 × 3 m with furniture of spheres and boxes: the nearest of all surfaces. */
  static double cast(const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
    const Eigen::Vector3d low(-3, -2.5, 0), high(3, 2.5, 3);
    double nearest = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
      const double wall = d[axis] > 0 ? high[axis] : low[axis];
      if (d[axis] != 0) nearest = std::min(nearest, (wall - o[axis]) / d[axis]);
    }
    static const double spheres[6][4] = {{0, 0, 0.9, 0.45},      {1.2, 0.8, 0.5, 0.5},   {-1.1, 0.9, 1.2, 0.3},
                                         {-0.9, -1.1, 0.4, 0.4}, {0.9, -1.0, 1.5, 0.25}, {0.1, 1.5, 0.3, 0.3}};
    for (const auto& s : spheres) {
      const Eigen::Vector3d c(s[0], s[1], s[2]);
      const double a = d.squaredNorm(), b = d.dot(o - c), e = (o - c).squaredNorm() - s[3] * s[3];
      const double discriminant = b * b - a * e;
      if (discriminant <= 0) continue;
      const double t = (-b - std::sqrt(discriminant)) / a;
      if (t > 0) nearest = std::min(nearest, t);
    }
    static const double boxes[4][6] = {{-2.4, -0.6, 0, -1.8, 0.6, 0.8},
                                       {0.4, -2.2, 0, 1.6, -1.6, 1.1},
                                       {1.6, 1.2, 0, 2.3, 2.0, 0.6},
                                       {-0.3, -0.3, 0, 0.3, 0.3, 0.45}};
    for (const auto& b : boxes) {
      double enter = 0, leave = nearest;
      for (int axis = 0; axis < 3; ++axis) {
        double t0 = (b[axis] - o[axis]) / d[axis], t1 = (b[axis + 3] - o[axis]) / d[axis];
        if (t0 > t1) std::swap(t0, t1);
        enter = std::max(enter, t0);
        leave = std::min(leave, t1);
      }
      if (enter > 0 && enter < leave) nearest = std::min(nearest, enter);
    }
    return nearest;
  }

  static std::uint32_t scramble(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
  }

  void renderRow(std::size_t i, int v, std::uint32_t seed, std::uint16_t* depth, fuse_flow::Rgb8* color) const {
    const fuse_flow::Camera& camera = cameras_[i];
    const fuse_flow::Intrinsics& K = camera.intrinsics;
    for (int u = 0; u < width_; ++u) {
      const Eigen::Vector3d ray((u - static_cast<double>(K.cx)) / static_cast<double>(K.fx),
                                (v - static_cast<double>(K.cy)) / static_cast<double>(K.fy), 1);
      const Eigen::Vector3d d = camera.T_world_camera.linear() * ray;
      const double z = cast(camera.T_world_camera.translation(), d);
      const std::uint32_t r =
          scramble(scramble(scramble(seed + 77u * static_cast<std::uint32_t>(i)) + static_cast<std::uint32_t>(v)) +
                   static_cast<std::uint32_t>(u));
      // The sum of four uniform numbers: nearly normal, of variance 1/3 before scaling.
      const double normal = 1.7320508 * ((r & 255u) + (r >> 8 & 255u) + (r >> 16 & 255u) + (r >> 24) - 510.0) / 255.0;
      const double sigma = 0.0005 + 0.001425 * z * z;
      const bool hole = scramble(r) % 50 == 0;
      depth[u] = hole ? 0 : static_cast<std::uint16_t>(std::clamp(1000 * (z + sigma * normal) + 0.5, 1.0, 65534.0));
      const Eigen::Vector3d p = camera.T_world_camera.translation() + z * d;
      const auto channel = [](double x) { return static_cast<std::uint8_t>(127.5 + 127 * std::sin(7 * x)); };
      color[u] = {channel(p.x()), channel(p.y()), channel(p.z())};
    }
  }

  int width_, height_;
  std::vector<fuse_flow::Camera> cameras_;
};

}  // namespace bench
