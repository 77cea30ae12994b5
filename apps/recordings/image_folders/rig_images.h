#pragma once

#include "recordings/streams/frame_sets.h"

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Where a camera of a rig recording has its images. */
struct CameraFolders {
  std::string camera;      ///< its name
  std::string own;         ///< its folder, which may have a timestamps.txt
  std::string depth;       ///< of depth images; empty: it has no depth, and colour makes its frames
  std::string color;       ///< of colour images; empty: it has none, or they are not wanted
  std::string confidence;  ///< of confidence images, which need not exist
};

/** \brief Files by the number of their frame. */
using FilesByFrame = std::map<std::size_t, std::string>;

/** \brief A camera's images. */
struct CameraImages {
  FilesByFrame images;  ///< names of what makes its frames: depth, or, without depth, colour
  /** \brief Paths, of a camera with depth. Absent: those with the name of the depth image, or with its number. */
  std::optional<FilesByFrame> color;
  /** \brief Paths, of a camera with depth. Absent: those with the name of the depth image. */
  std::optional<FilesByFrame> confidence;
};

/** \brief The images of a rig recording, put together into frames. */
struct RigImages {
  std::vector<CameraImages> cameras;
  bool by_time{false};  ///< frames are counted from 0 in the order of time; false: they have the numbers in the names
  std::vector<std::size_t> without_partner;   ///< of each camera, how many images are in no frame; empty unless by_time
  std::map<std::size_t, Nanoseconds> stamps;  ///< of the frames; empty: nothing says them
};

/** \brief Finds the images of all cameras, and puts them into frames.
 *
 *  By number, if the images have numbers (namedImages()) and no times. If all have times, in their names or in a timestamps.txt (in the
 *  camera's folder, or in that of its images), by time, with the rules of groupByTime(). Images that have both are put together by
 *  number if that gives the same frames, or if by time no two cameras share a frame; else by time. Colour goes with depth by time where both have times, else by number.
 *  What was assumed, and what is left out, is said in lines for the user. Throws InputError. */
RigImages rigImages(const std::string& recording, const std::vector<CameraFolders>& cameras,
                    std::vector<std::string>& warnings);

}  // namespace fuse_flow::io
