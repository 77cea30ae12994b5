#include "sinks/quality_report.h"

#include "recordings/files/file_io.h"

#include <optional>
#include <utility>

namespace fuse_flow::io {

QualityReport::QualityReport(std::string method, std::vector<std::string> cameras, Options options)
    : options_(std::move(options)), report_(std::move(method), std::move(cameras)) {}

void QualityReport::take(const std::shared_ptr<const FusedFrame>& frame) {
  if (!options_.measure) {
    report_.addFrame(frame->number, frame->statistics, std::nullopt);
    return;
  }
  const RigFrame& rig = frame->input.rig;
  SurfaceQuality surface = surfaceQuality(frame->cloud, rig, options_.surface, options_.threads);
  if (before_ && before_->number + 1 == frame->number)
    surface.flicker =
        temporalFlicker(before_->cloud, before_->input.rig, frame->cloud, rig, options_.surface, options_.threads);
  before_ = frame;
  report_.addFrame(frame->number, frame->statistics,
                   reprojectionQuality(frame->cloud, rig, options_.reprojection, options_.threads), surface);
}

std::vector<std::string> QualityReport::finish() {
  if (options_.file.empty()) return {};
  makeFolderOf(options_.file);
  writeFile(options_.file, jsonText(report_.json()));
  return {};
}

}  // namespace fuse_flow::io
