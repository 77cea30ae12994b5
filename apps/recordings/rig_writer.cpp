#include <fuse_flow/recordings/rig_writer.h>

#include "recordings/files/file_io.h"
#include "recordings/images/float_image.h"
#include "recordings/images/image_io.h"
#include "recordings/readers/view_files.h"

#include <utility>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

/** \param stem path without an extension */
void writeDepth(const fs::path& stem, const RigCamera& camera, const DepthView& view, const LoadedView& images) {
  const std::string png = stem.string() + ".png", npy = stem.string() + ".npy";
  if (!camera.has_depth_scale)
    throw OutputError(png + ": its camera has no depth_scale, and so no depth, must have one");
  if (view.depth16) {
    writeDepthPng(png, images.depth16);
  } else if (camera.camera.depth_scale == 1.0f) {
    writeNpy(npy, images.depth32);
  } else {
    throw OutputError(npy + ": its depth is in float, in metres, and its depth_scale " +
                      std::to_string(camera.camera.depth_scale) + ", must be 1");
  }
}

/** \brief In steps of the camera's confidence_scale, by which a reader multiplies. */
void writeConfidence(const std::string& path, const RigCamera& camera, FloatImage confidence) {
  makeFolderOf(path);
  if (camera.confidence_scale)
    for (float& c : confidence.data) c /= *camera.confidence_scale;
  writeNpy(path, confidence);
}

}  // namespace

RigWriter::RigWriter(const std::string& folder, RigDescription rig, bool color)
    : folder_(folder), rig_(std::move(rig)) {
  for (const RigCamera& entry : rig_.cameras) {
    if (entry.has_depth_scale) makeFolder(folder_ / entry.camera.name / "depth");
    if (color) makeFolder(folder_ / entry.camera.name / "color");
  }
}

void RigWriter::write(std::size_t frame, const LoadedFrame& images) const {
  const std::string stem = frameStem(frame);
  for (std::size_t k = 0; k < rig_.cameras.size(); ++k) {
    const DepthView& view = images.rig.views[k];
    const RigCamera& camera = rig_.cameras[k];
    if (camera.has_depth_scale && view.missing()) continue;
    const fs::path folder = folder_ / camera.camera.name;
    const auto file = [&](const char* kind, const char* extension) {
      return (folder / kind / (stem + extension)).string();
    };
    if (!view.missing()) writeDepth(folder / "depth" / stem, camera, view, images.images[k]);
    if (view.color) writeColorPng(file("color", ".png"), images.images[k].color);
    if (view.confidence) writeConfidence(file("confidence", ".npy"), camera, images.images[k].confidence);
  }
}

void RigWriter::finish() const { writeRigJson((folder_ / "rig.json").string(), rig_); }

}  // namespace fuse_flow::io
