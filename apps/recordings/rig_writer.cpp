#include <fuse_flow/recordings/rig_writer.h>

#include "recordings/files/file_io.h"
#include "recordings/files/image_io.h"
#include "recordings/readers/view_files.h"

#include <utility>

namespace fs = std::filesystem;

namespace fuse_flow::io {

RigWriter::RigWriter(const std::string& folder, RigDescription rig, bool color)
    : folder_(folder), rig_(std::move(rig)) {
  for (const RigCamera& entry : rig_.cameras) {
    makeFolder(folder_ / entry.camera.name / "depth");
    if (color) makeFolder(folder_ / entry.camera.name / "color");
  }
}

void RigWriter::write(std::size_t frame, const LoadedFrame& images) const {
  const std::string file = frameStem(frame) + ".png";
  for (std::size_t k = 0; k < rig_.cameras.size(); ++k) {
    if (images.rig.views[k].missing()) continue;
    const fs::path camera = folder_ / rig_.cameras[k].camera.name;
    if (images.images[k].depth16.empty())
      throw OutputError((camera / "depth" / file).string() +
                        ": its depth is in float, must be in 16-bit units to be written as PNG");
    writeDepthPng((camera / "depth" / file).string(), images.images[k].depth16);
    if (images.rig.views[k].color) writeColorPng((camera / "color" / file).string(), images.images[k].color);
  }
}

void RigWriter::finish() const { writeRigJson((folder_ / "rig.json").string(), rig_); }

}  // namespace fuse_flow::io
