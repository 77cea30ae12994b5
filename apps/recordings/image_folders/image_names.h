#pragma once

#include "recordings/streams/frame_sets.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief An image of a folder, and what is known of it: the number of its frame, when it was taken, or both. */
struct NamedImage {
  std::string name;  ///< of its file
  std::optional<std::size_t> number;
  std::optional<Nanoseconds> stamp;
};

/** \brief The images of one sensor. All of them have a number, or none; and so with times. */
struct NamedImages {
  std::string folder;
  std::vector<NamedImage> images;  ///< in the order of their numbers; without numbers, of their times
  bool plain{false};               ///< the names are the numbers of the frames alone, as RigWriter writes them
  std::string times_from;          ///< where the times come from, and their unit, for messages

  bool numbered() const { return !images.empty() && images.front().number.has_value(); }
  bool timed() const { return !images.empty() && images.front().stamp.has_value(); }
};

/** \brief Finds the number of the frame, the time, or both in the names of a folder's images.
 *
 *  A name without its extension is taken apart into numbers and what is between. A number is a time if it has decimals (seconds), or if
 *  it is kLeastStamp or more and so are those at its place in all names (their unit by stampUnit()); else it is that of a frame.
 *  - If some names are a frame's number alone ("000000.png"), only these are images.
 *  - Else those count that are alike but for their numbers ("frame_0001.png"), the most of them. Numbers that are the same in all names
 *    say nothing. Of the others, one may be that of the frame and one a time. Of a single image it is the longest number.
 *
 *  Throws InputError where two images have the same number or time, and where names do not tell which number is the frame's.
 *  \param kind "depth" or "colour", for messages  \param isImage of a file's name  \param warnings gets a line of images that are not among those */
NamedImages namedImages(const std::string& folder, const std::string& kind,
                        const std::function<bool(const std::string&)>& isImage, std::vector<std::string>& warnings);

}  // namespace fuse_flow::io
