#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief "3", "0,60,120" or "A:B:STEP" with Python's meaning (B exclusive; 0, the end and 1 where left out) as the
 *  numbers it names. \param count how many there are: a range stops there, a single number at or past it is an error, as is
 *  one that is there twice.
 *  \param option named in messages, e.g. "--frames". Throws OptionError. */
std::vector<std::size_t> parseRange(const std::string& spec, std::size_t count, const std::string& option = "--frames");

/** \brief The same of numbers that need not follow each other, such as those of a recording's frames.
 *  \param numbers ascending  Throws OptionError for one that is not among them, and for a range that names none of them. */
std::vector<std::size_t> parseRangeOf(const std::string& spec, const std::vector<std::size_t>& numbers,
                                      const std::string& option = "--frames");

/** \brief "40 frames: 0, 5, 10 ... 195", for messages. */
std::string listFrames(const std::vector<std::size_t>& numbers);

}  // namespace fuse_flow::io
