#pragma once

#include <cstdint>
#include <string_view>

namespace fuse_flow::io {

/** \brief The CRC-32 of zlib, PNG and MCAP. \param before that of the bytes before these; 0: there are none */
std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace fuse_flow::io
