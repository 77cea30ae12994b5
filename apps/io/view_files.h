#pragma once

#include "io/recording.h"

#include <string>

namespace fuse_flow::io {

/** \brief Where one camera's images of one instant are; a path may be empty, and its file may not exist. */
struct ViewFiles {
  std::string depth;
  std::string color;
  std::string confidence;
};

/** \brief How a rig recording names the files of a frame, without the extension: "000042". */
std::string frameStem(std::size_t frame);

/** \brief folder/stem.png, .jpg or .jpeg, whichever exists; else "". */
std::string findImage(const std::string& folder, const std::string& stem);

/** \brief Reads what is there into images and points view at it. Without a depth file the view is missing, whatever
 *  else exists. Throws InputError on a damaged file and on an image whose size is not its camera's. */
void loadView(const ViewFiles& files, const Camera& camera, float depth_scale, LoadedView& images, DepthView& view);

}  // namespace fuse_flow::io
