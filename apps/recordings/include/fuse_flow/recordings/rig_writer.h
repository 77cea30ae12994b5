#pragma once

#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/recordings/rig_json.h>

#include <cstddef>
#include <filesystem>

namespace fuse_flow::io {

/** \brief Writes a rig recording: NAME/{depth,color}/NNNNNN.png, and rig.json. */
class RigWriter {
 public:
  /** \brief Creates the folders of the cameras, with folders for colour images if there will be some. Throws OutputError. */
  RigWriter(const std::string& folder, RigDescription rig, bool color);

  /** \brief Writes the images of one frame. For a missing view, no file is written. Throws OutputError. */
  void write(std::size_t frame, const LoadedFrame& images) const;

  /** \brief Writes rig.json. Without it, the folder is not yet a recording. Throws OutputError. */
  void finish() const;

 private:
  std::filesystem::path folder_;
  RigDescription rig_;
};

}  // namespace fuse_flow::io
