#pragma once

/** \file
 *  \brief Two cameras with a view each, at a rank each: the smallest rig whose poses ranks search for together. */

#include <fuse_flow/distributed/calibration/extrinsic_estimation.h>

#include <cmath>
#include <vector>

namespace fuse_flow_fuzz {

class SmallPoseRig {
 public:
  SmallPoseRig() {
    frame_.cameras.resize(2);
    frame_.views.resize(2);
    for (std::size_t i = 0; i < 2; ++i) {
      fuse_flow::Camera& camera = frame_.cameras[i];
      camera.name = std::string(1, static_cast<char>('a' + i));
      camera.intrinsics.width = kWidth;
      camera.intrinsics.height = kHeight;
      camera.intrinsics.fx = camera.intrinsics.fy = 50;
      camera.intrinsics.cx = kWidth / 2.0f;
      camera.intrinsics.cy = kHeight / 2.0f;
      camera.T_world_camera.translation().x() = 0.01 * static_cast<double>(i);
      for (int v = 0; v < kHeight; ++v)
        for (int u = 0; u < kWidth; ++u) {
          const float x = static_cast<float>(u) / 9.0f, y = static_cast<float>(v) / 7.0f;
          depth_[i].push_back(1.0f + 0.1f * std::sin(x) + 0.1f * std::cos(y));
          color_[i].push_back(fuse_flow::Rgb8{static_cast<std::uint8_t>(128.0f + 99.0f * std::sin(x * y)), 0, 0});
        }
    }
  }

  /** \brief All cameras, and the view of the camera of that number. */
  fuse_flow::RigFrame part(std::size_t rank) const {
    fuse_flow::RigFrame part = frame_;
    part.views[rank].depth32 = {depth_[rank].data(), kWidth, kHeight};
    part.views[rank].color = {color_[rank].data(), kWidth, kHeight};
    return part;
  }

  /** \brief What one rank finds, or throws. */
  fuse_flow::ExtrinsicResult estimate(fuse_flow::distributed::Communicator& communicator) const {
    fuse_flow::ExtrinsicParameters parameters;
    parameters.samples = 100;
    parameters.max_iterations = 4;
    fuse_flow::distributed::ExtrinsicEstimation estimation(communicator);
    estimation.setParameters(parameters);
    estimation.setNumberOfThreads(1);
    estimation.addFrame(part(static_cast<std::size_t>(communicator.rank())));
    return estimation.estimate();
  }

 private:
  static constexpr int kWidth = 48, kHeight = 36;
  fuse_flow::RigFrame frame_;
  std::vector<float> depth_[2];
  std::vector<fuse_flow::Rgb8> color_[2];
};

}  // namespace fuse_flow_fuzz
