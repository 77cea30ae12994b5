#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace io_test {

/** \brief A baseline JPEG of 8×8 blocks of one value each, put together without the library under test. Of such blocks
 *  the cosine transform leaves the mean alone, so that the values come back exactly.
 *  \param blocks_wide blocks in a row
 *  \param planes for each component, a value for each block, row by row: one plane is grey, three are Y, Cb, Cr, four
 *  are for printers */
std::string jpeg(int blocks_wide, const std::vector<std::vector<std::uint8_t>>& planes);

}  // namespace io_test
