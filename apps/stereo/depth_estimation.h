#pragma once

#include <fuse_flow/stereo/multi_view_stereo.h>

#include <functional>
#include <memory>
#include <string>

namespace fuse_flow::io {

/** \brief Depth and confidence of the colour images of a frame, on the CPU or a GPU: the same bytes. */
class DepthEstimation {
 public:
  virtual ~DepthEstimation() = default;
  /** \brief As MultiViewStereo::estimate(). Throws DeviceError, too. */
  virtual void estimate(const RigFrame& frame, StereoFrame& result) = 0;
};

/** \brief By a MultiViewStereo. */
template <typename Device>
class DepthEstimationOn : public DepthEstimation {
 public:
  DepthEstimationOn(const StereoParameters& parameters, unsigned int threads) {
    stereo_.setParameters(parameters);
    stereo_.setNumberOfThreads(threads);
    stereo_.setNormals(false);  // nobody asks for them
  }
  void estimate(const RigFrame& frame, StereoFrame& result) override { stereo_.estimate(frame, result); }

 protected:
  MultiViewStereo<Device> stereo_;
};

/** \brief Where MethodOptions::device says. Throws OptionError where a GPU is asked for and there is none.
 *  \param warn may be empty; with "auto" it gets a line when the GPU has failed and the CPU goes on; else a DeviceError ends it */
std::unique_ptr<DepthEstimation> makeDepthEstimation(const StereoParameters& parameters, unsigned int threads,
                                                     const std::string& device,
                                                     const std::function<void(const std::string&)>& warn);

}  // namespace fuse_flow::io
