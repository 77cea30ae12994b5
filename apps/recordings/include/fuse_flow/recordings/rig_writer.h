#pragma once

#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/recordings/rig_json.h>

#include <cstddef>
#include <filesystem>

namespace fuse_flow::io {

/** \brief Writes a rig recording: NAME/{depth,color}/NNNNNN.png, and rig.json. */
class RigWriter {
 public:
  /** \brief Makes the cameras' folders, of colour images too where there will be some. Throws OutputError. */
  RigWriter(const std::string& folder, RigDescription rig, bool color);

  /** \brief The images of one frame; a view that is missing is a missing file. Throws OutputError. */
  void write(std::size_t frame, const LoadedFrame& images) const;

  /** \brief Writes rig.json, without which the folder is no recording yet. Throws OutputError. */
  void finish() const;

 private:
  std::filesystem::path folder_;
  RigDescription rig_;
};

}  // namespace fuse_flow::io
