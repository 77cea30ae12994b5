#pragma once

#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/recordings/rig_json.h>

#include <cstddef>
#include <filesystem>

namespace fuse_flow::io {

/** \brief Writes a rig recording: NAME/{depth,color}/NNNNNN.png, and rig.json. Depth in float, and confidence, become NNNNNN.npy. A
 *  camera without RigCamera::has_depth_scale is one without depth: of its views colour is written alone. Only one thread at a time may
 *  use an object. */
class RigWriter {
 public:
  /** \brief Creates the folders of the cameras, with folders for colour images if there will be some. Throws OutputError. */
  RigWriter(const std::string& folder, RigDescription rig, bool color);

  /** \brief Writes the images of one frame. For a missing view, no file is written. Depth in float must be of a camera whose depth_scale is 1, as
   *  it is in metres. A camera without depth must have none. Throws OutputError. */
  void write(std::size_t frame, const LoadedFrame& images) const;

  /** \brief Writes rig.json. Without it, the folder is not yet a recording. Throws OutputError. */
  void finish() const;

 private:
  std::filesystem::path folder_;
  RigDescription rig_;
};

}  // namespace fuse_flow::io
