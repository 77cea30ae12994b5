#pragma once

#include "../../bundles.h"
#include "../../fuzz_target.h"
#include "../../good_frame.h"
#include "../../scratch.h"

namespace fuse_flow_fuzz {

/** \brief Bounds of a recording in a folder: some files that are small, and images, whose decoders make up to 1100 bytes of one (deflate), hold those and the
 *  pixels made of them at a time, and take some hundred KiB whatever an image is. */
constexpr std::size_t kOfFolder = 4 << 20, kOfFolderByte = 1 << 16;

inline void readFolder(const std::vector<std::string>& files, std::string_view input,
                       const fuse_flow::io::RecordingOptions& options = {}) {
  const std::string folder = emptyScratchFolder();
  scratchFiles(files, input);
  readRecording({folder}, options);
}

}  // namespace fuse_flow_fuzz
