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

/** \brief The same for one view of a frame, whose cameras must be there and whose views and images must be as many.
 *  \param skip_damaged what would be thrown is added to out.damaged, and the view is missing */
void loadView(const ViewFiles& files, float depth_scale, std::size_t number, bool skip_damaged, LoadedFrame& out);

}  // namespace fuse_flow::io
