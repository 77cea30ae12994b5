#pragma once

#include "stereo/depth_estimation.h"

#include <fuse_flow/recordings/recording.h>

#include <nlohmann/json.hpp>

#include <cstddef>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief How views without depth get one. */
struct StereoOptions {
  bool estimate{true};  ///< false: they stay missing
  StereoParameters parameters;
  unsigned int threads{0};     ///< 0: one per core
  std::string device{"auto"};  ///< as MethodOptions::device
  /** \brief So much depth is kept, for frames that are read again; bytes. */
  std::size_t keep_bytes{0};
  /** \brief Called if no view has depth of its own, with the number of those that get it. What it returns is added to the line that says so. */
  std::function<std::string(std::size_t views)> all_estimated;
  /** \brief Called with a line where the images of a frame do not fit; once for each thing. */
  std::function<void(const std::string&)> warn;
};

/** \brief The views of a rig that have no depth get depth and confidence from the colour images of all. The camera of such a view is that of its
 *  colour images, with the noise of estimated depth, see StereoFrame::rig. */
class ViewStereo {
 public:
  /** \brief Throws InputError if no depth can be estimated though no view has one.
   *  \param lacks_depth of each camera \param has_color of each camera \param path of messages */
  ViewStereo(std::vector<Camera> cameras, std::vector<bool> lacks_depth, const std::vector<bool>& has_color,
             std::string path, StereoOptions options);

  /** \brief Of views without depth those of their colour images. */
  const std::vector<Camera>& cameras() const { return cameras_; }
  /** \brief What was assumed, one line each. */
  const std::vector<std::string>& warnings() const { return warnings_; }
  /** \brief Whether a view has no depth of its own, and another view sees the same, so that it gets one. */
  bool estimates(std::size_t camera) const { return lacks_depth_[camera] && !geometry_[camera].sources.empty(); }
  /** \brief Whether a view has no depth of its own. */
  bool lacksDepth(std::size_t camera) const { return lacks_depth_[camera]; }
  /** \brief How many views get depth. */
  std::size_t estimatedViews() const;

  /** \brief Estimates depth and confidence into out.images, and has out.rig's views point there. \param of_frame for messages: "frame 000003" */
  void complete(const std::string& of_frame, LoadedFrame& out);
  /** \brief Of the frame that was completed last: share of the pixels of the views without depth on whose depth another view agrees. */
  double agreeing() const { return agreeing_; }
  /** \brief Of the same: how long it took to estimate, seconds. */
  double seconds() const { return seconds_; }
  /** \brief How long the frames so far took, and how much of their depth another view agrees on; one line. */
  std::string summary() const;
  /** \brief What was done, for a report: views, range of depth, agreement and time of the frames so far. */
  nlohmann::json json() const;

 private:
  void look(const std::vector<bool>& has_color);
  void estimate(const std::string& of_frame, LoadedFrame& out);
  void checkImages(const std::string& of_frame, const RigFrame& rig);
  void checkCalibration(const std::string& of_frame, const RigFrame& rig);
  void warnOnce(const std::string& thing, const std::string& line);

  std::vector<Camera> cameras_;
  std::vector<bool> lacks_depth_;
  std::string path_;
  StereoOptions options_;
  bool all_;
  std::vector<StereoGeometry> geometry_;
  std::vector<std::string> warnings_;
  std::unique_ptr<DepthEstimation> stereo_;  ///< where a view gets depth
  StereoFrame found_;
  double agreeing_{0}, seconds_{0};
  std::size_t frames_{0}, pixels_{0}, agreeing_pixels_{0};
  double all_seconds_{0};
  std::set<std::string> warned_;
};

}  // namespace fuse_flow::io
