#pragma once

#include "recordings/readers/view_files.h"

#include <fuse_flow/recordings/recording.h>

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief One photograph with its camera. */
struct Photo {
  /** \brief Lengths are in the format's unit. Width 0: the format does not say whether its intrinsics are those of the photograph or of the depth
   *  map; the one whose middle is nearer to the principal point is taken. */
  Camera camera;
  ViewFiles files;
};

/** \brief Photographs of one instant, or of what does not move, for which a program has estimated depth. The formats differ in how they list
 *  their cameras and name their depth; this is what they share. */
struct Photos {
  std::string kind;
  std::string path;
  std::vector<std::string> inputs;    ///< see Recording::inputs()
  std::vector<Photo> photos;          ///< those with depth
  std::size_t without_depth{0};       ///< how many have none, and are left out
  std::vector<std::string> warnings;  ///< a line each
};

/** \brief Depth and colour may have other sizes than the camera's: then its intrinsics are scaled. RecordingOptions::depth_scale is metres for one
 *  unit of depth and of positions alike. Throws InputError where there is no depth, OptionError for options that do not fit. */
std::unique_ptr<Recording> openPhotos(Photos photos, const RecordingOptions& options);

}  // namespace fuse_flow::io
