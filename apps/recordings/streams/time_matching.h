#pragma once

#include "recordings/streams/frame_sets.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief The stamps that are later than all before them, and of the others how many there are, in a line for the user; none if all are.
 *  \param kept the numbers of the stamps that stay */
std::vector<Nanoseconds> ascendingStamps(const std::string& track, const std::vector<Nanoseconds>& stamps,
                                         std::vector<std::size_t>& kept, std::vector<std::string>& warnings);

/** \brief When a camera took the images that make its frames. */
struct CameraTimes {
  std::string camera;
  std::string file;                 ///< for messages
  std::vector<Nanoseconds> stamps;  ///< strictly ascending
  Nanoseconds begins{0};            ///< its first stamp as the file has it; for messages
};

/** \brief groupByTime(), and in lines for the user what images have no partner, that no two cameras share a time, and that the images of a frame are
 *  far apart. */
FrameSets framesByTime(const std::vector<CameraTimes>& cameras, std::vector<std::string>& warnings);

/** \brief How many images a set has. */
std::size_t countImages(const FrameSet& set);

/** \brief For each depth image the number of the colour image that is nearest in time, within half of the slower one's period; none where there is none. What has none, and
 *  that they are far apart, is said in lines for the user.
 *  \param delay from a colour image to the depth image that belongs to it */
std::vector<std::optional<std::size_t>> colorByTime(const std::string& camera, const std::vector<Nanoseconds>& depth,
                                                    const std::vector<Nanoseconds>& color, Nanoseconds delay,
                                                    std::vector<std::string>& warnings);

}  // namespace fuse_flow::io
