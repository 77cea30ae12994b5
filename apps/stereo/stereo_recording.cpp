#include "stereo/stereo_recording.h"

#include "recordings/readers/view_files.h"

namespace fuse_flow::io {
namespace {

std::vector<bool> ofEachCamera(const Recording& recording, bool (Recording::*has)(std::size_t) const, bool value) {
  std::vector<bool> of;
  for (std::size_t k = 0; k < recording.cameras().size(); ++k) of.push_back((recording.*has)(k) == value);
  return of;
}

}  // namespace

StereoRecording::StereoRecording(std::unique_ptr<Recording> recording, const std::string& path,
                                 const StereoOptions& options)
    : recording_(std::move(recording)),
      stereo_(recording_->cameras(), ofEachCamera(*recording_, &Recording::hasDepth, false),
              ofEachCamera(*recording_, &Recording::hasColor, true), path, options),
      keep_bytes_(options.keep_bytes) {
  warnings_ = recording_->warnings();
  warnings_.insert(warnings_.end(), stereo_.warnings().begin(), stereo_.warnings().end());
}

std::optional<float> StereoRecording::confidenceScale(std::size_t camera) const {
  return stereo_.lacksDepth(camera) ? std::nullopt : recording_->confidenceScale(camera);
}

void StereoRecording::read(std::size_t frame, LoadedFrame& out) {
  recording_->read(frame, out);
  if (estimatedViews() == 0) return;
  const auto kept = kept_.find(frame);
  if (kept != kept_.end()) {
    give(kept->second, out);
    agreeing_ = kept->second.agreeing;
    seconds_ = 0;
  } else {
    stereo_.complete("frame " + frameStem(frame), out);
    agreeing_ = stereo_.agreeing();
    seconds_ = stereo_.seconds();
    keep(frame, out);
  }
}

void StereoRecording::give(const Kept& kept, LoadedFrame& out) const {
  for (std::size_t k = 0; k < kept.depth.size(); ++k) {
    if (kept.depth[k].empty() || !out.rig.views[k].color) continue;
    LoadedView& to = out.images[k];
    to.depth16.resize(0, 0);
    to.depth32 = kept.depth[k];
    to.confidence = kept.confidence[k];
    to.assumed_confidence_step = 0;
    out.rig.views[k].depth32 = to.depth32.view();
    out.rig.views[k].confidence = to.confidence.view();
  }
  for (std::size_t k = 0; k < cameras().size(); ++k)
    if (stereo_.lacksDepth(k)) out.rig.cameras[k] = cameras()[k];
}

/** \brief Frames that were read first stay: where a recording is played again and again, the oldest is the one that is needed next. */
void StereoRecording::keep(std::size_t frame, const LoadedFrame& out) {
  Kept kept;
  std::size_t bytes = 0;
  for (std::size_t k = 0; k < cameras().size(); ++k) {
    const bool estimated = stereo_.lacksDepth(k) && !out.rig.views[k].missing();
    if (estimated) bytes += 2 * sizeof(float) * out.images[k].depth32.data.size();
    if (kept_bytes_ + bytes > keep_bytes_) return;
    kept.depth.push_back(estimated ? out.images[k].depth32 : FloatImage());
    kept.confidence.push_back(estimated ? out.images[k].confidence : FloatImage());
  }
  kept.agreeing = agreeing_;
  kept_bytes_ += bytes;
  kept_.emplace(frame, std::move(kept));
}

std::unique_ptr<Recording> withStereo(std::unique_ptr<Recording> recording, const std::string& path,
                                      const StereoOptions& options) {
  bool complete = true;
  for (std::size_t k = 0; k < recording->cameras().size(); ++k) complete = complete && recording->hasDepth(k);
  if (complete || !options.estimate) return recording;
  return std::make_unique<StereoRecording>(std::move(recording), path, options);
}

StereoRecording* stereoOf(Recording* recording) {
  auto* stereo = dynamic_cast<StereoRecording*>(recording);
  return stereo && stereo->estimatedViews() > 0 ? stereo : nullptr;
}

}  // namespace fuse_flow::io
