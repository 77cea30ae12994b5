#pragma once

#include "stereo/view_stereo.h"

#include <fuse_flow/recordings/recording.h>

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A recording whose views without depth get one, see ViewStereo. */
class StereoRecording : public Recording {
 public:
  /** \brief Throws InputError if no depth can be estimated though no view has one. \param path of messages */
  StereoRecording(std::unique_ptr<Recording> recording, const std::string& path, const StereoOptions& options);

  std::string kind() const override { return recording_->kind(); }
  std::size_t frameCount() const override { return recording_->frameCount(); }
  std::vector<std::size_t> frames() const override { return recording_->frames(); }
  std::optional<double> framesPerSecond() const override { return recording_->framesPerSecond(); }
  const std::vector<Camera>& cameras() const override { return stereo_.cameras(); }
  /** \brief Of a view whose depth is estimated: whether another view sees the same. */
  bool hasDepth(std::size_t camera) const override { return !stereo_.lacksDepth(camera) || estimates(camera); }
  bool hasColor(std::size_t camera) const override { return recording_->hasColor(camera); }
  std::optional<float> confidenceScale(std::size_t camera) const override;
  DepthMeaning depthMeaning(std::size_t camera) const override { return recording_->depthMeaning(camera); }
  std::size_t imagesWithoutPartner(std::size_t camera) const override {
    return recording_->imagesWithoutPartner(camera);
  }
  std::vector<std::string> inputs() const override { return recording_->inputs(); }
  void read(std::size_t frame, LoadedFrame& out) override;

  /** \copydoc ViewStereo::estimates */
  bool estimates(std::size_t camera) const { return stereo_.estimates(camera); }
  /** \copydoc ViewStereo::estimatedViews */
  std::size_t estimatedViews() const { return stereo_.estimatedViews(); }
  /** \brief Of the frame that was read last, see ViewStereo::agreeing(). */
  double agreeing() const { return agreeing_; }
  /** \brief Of the same: how long it took to estimate, seconds; 0 where it was kept. */
  double seconds() const { return seconds_; }
  /** \copydoc ViewStereo::summary */
  std::string summary() const { return stereo_.summary(); }
  /** \copydoc ViewStereo::json */
  nlohmann::json json() const { return stereo_.json(); }

 private:
  struct Kept {
    std::vector<FloatImage> depth, confidence;  ///< of the views; empty: not estimated
    double agreeing{0};
  };

  void give(const Kept& kept, LoadedFrame& out) const;
  void keep(std::size_t frame, const LoadedFrame& out);

  std::unique_ptr<Recording> recording_;
  ViewStereo stereo_;
  std::size_t keep_bytes_;
  double agreeing_{0}, seconds_{0};
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
