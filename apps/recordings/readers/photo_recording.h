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
   *  map; for all photographs together the one whose middle is nearer to the principal points is taken. */
  Camera camera;
  ViewFiles files;
};

/** \brief Photographs of one instant, or of what does not move; of them or of some a program may have estimated depth. The formats differ in how
 *  they list their cameras and name their depth; this is what they share. */
struct Photos {
  std::string kind;
  std::string path;
  std::vector<std::string> inputs;  ///< see Recording::inputs()
  std::string color_folder;         ///< where photographs should be; empty: nowhere
  std::string confidence_folder;    ///< the same of confidence
  std::vector<Photo> photos;        ///< those without depth, too
  /** \brief How the intrinsics of a smaller image follow: with all coordinates counted from the middle of the first pixel, as MVSNet does, or from
   *  its corner, so that both images show the same. */
  bool scaled_from_first_middle{false};
  std::vector<std::string> warnings;  ///< a line each
};

/** \brief Whether any of them has depth. */
bool haveDepth(const std::vector<Photo>& photos);

/** \brief If some have depth, those without are left out; if none has, all are photographs without depth. Depth and colour may have other sizes than
 *  the camera's: then its intrinsics are scaled. RecordingOptions::depth_scale is metres for one unit of depth and of positions alike. Throws
 *  InputError where there is neither depth nor a photograph, OptionError for options that do not fit. */
std::unique_ptr<Recording> openPhotos(Photos photos, const RecordingOptions& options);

}  // namespace fuse_flow::io
