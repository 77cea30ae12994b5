#pragma once

#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/stereo/multi_view_stereo.h>

#include <nlohmann/json.hpp>

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief How views without depth get one. */
struct StereoOptions {
  bool estimate{true};  ///< false: they stay missing
  StereoParameters parameters;
  unsigned int threads{0};  ///< 0: one per core
  /** \brief So much depth is kept, for frames that are read again; bytes. */
  std::size_t keep_bytes{0};
  /** \brief Called if no view has depth of its own, with the number of those that get it. What it returns is added to the line that says so. */
  std::function<std::string(std::size_t views)> all_estimated;
  /** \brief Called with a line where the images of a frame do not fit; once for each thing. */
  std::function<void(const std::string&)> warn;
};

/** \brief A recording whose views without depth get depth and confidence from the colour images of all views. The camera of such a view is that of
 *  its colour images, with the noise of estimated depth, see StereoFrame::rig. */
class StereoRecording : public Recording {
 public:
  /** \brief Throws InputError if no depth can be estimated though no view has one. \param path of messages */
  StereoRecording(std::unique_ptr<Recording> recording, std::string path, StereoOptions options);

  std::string kind() const override { return recording_->kind(); }
  std::size_t frameCount() const override { return recording_->frameCount(); }
  std::vector<std::size_t> frames() const override { return recording_->frames(); }
  std::optional<double> framesPerSecond() const override { return recording_->framesPerSecond(); }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  /** \brief Of a view whose depth is estimated: whether another view sees the same. */
  bool hasDepth(std::size_t camera) const override;
  bool hasColor(std::size_t camera) const override { return recording_->hasColor(camera); }
  std::optional<float> confidenceScale(std::size_t camera) const override;
  DepthMeaning depthMeaning(std::size_t camera) const override { return recording_->depthMeaning(camera); }
  std::size_t imagesWithoutPartner(std::size_t camera) const override {
    return recording_->imagesWithoutPartner(camera);
  }
  std::vector<std::string> inputs() const override { return recording_->inputs(); }
  void read(std::size_t frame, LoadedFrame& out) override;

  /** \brief Whether a view has no depth of its own, and gets one. */
  bool estimates(std::size_t camera) const { return lacks_depth_[camera] && hasDepth(camera); }
  /** \brief How many do. */
  std::size_t estimatedViews() const;
  /** \brief Of the frame that was read last: share of the pixels of the views without depth on whose depth another view agrees. */
  double agreeing() const { return agreeing_; }
  /** \brief Of the same: how long it took to estimate, seconds. */
  double seconds() const { return seconds_; }
  /** \brief How long the frames so far took, and how much of their depth another view agrees on; one line. */
  std::string summary() const;
  /** \brief What was done, for a report: views, range of depth, agreement and time of the frames so far. */
  nlohmann::json json() const;

 private:
  struct Kept {
    std::vector<FloatImage> depth, confidence;  ///< of the views; empty: not estimated
    double agreeing{0};
  };

  void look();
  void estimate(std::size_t frame, LoadedFrame& out);
  void give(const Kept& kept, LoadedFrame& out) const;
  void keep(std::size_t frame, const LoadedFrame& out);
  void checkImages(std::size_t frame, const RigFrame& rig);
  void checkCalibration(std::size_t frame, const RigFrame& rig);
  void warnOnce(const std::string& thing, const std::string& line);

  std::unique_ptr<Recording> recording_;
  std::string path_;
  StereoOptions options_;
  std::vector<bool> lacks_depth_;
  bool all_{false};
  std::vector<StereoGeometry> geometry_;
  std::vector<Camera>
      cameras_;  ///< of views without depth those of their colour images, with the noise of what is estimated
  MultiViewStereo<> stereo_;
  StereoFrame found_;
  double agreeing_{0}, seconds_{0};
  std::size_t frames_{0}, pixels_{0}, agreeing_pixels_{0};
  double all_seconds_{0};
  std::set<std::string> warned_;
  std::map<std::size_t, Kept> kept_;
  std::size_t kept_bytes_{0};
};

/** \brief A recording with depth of all views that can get one; itself if every view has depth, or none shall be estimated. Its warnings say
 *  which. \param path of messages */
std::unique_ptr<Recording> withStereo(std::unique_ptr<Recording> recording, const std::string& path,
                                      const StereoOptions& options);

/** \brief A recording as one some of whose views get their depth here; null: it is none. */
StereoRecording* stereoOf(Recording* recording);

}  // namespace fuse_flow::io
