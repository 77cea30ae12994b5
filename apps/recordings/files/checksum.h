#pragma once

#include <cstdint>
#include <string_view>

namespace fuse_flow::io {

/** \brief The CRC-32 of zlib, PNG and MCAP. */
std::uint32_t crc32(std::string_view bytes);

}  // namespace fuse_flow::io
