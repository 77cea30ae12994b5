#pragma once

#include <cstdint>
#include <string>

namespace fuse_flow::io {

/** \brief Bytes that one makes at most: neither LZ4 nor Zstandard shrinks a block of 128 KiB below some four bytes, nor bzip2 one of 900 KB below 40. A file that
 *  claims more would only take the memory. */
constexpr std::uint64_t kBestCompression = 40'000;

/** \brief Throws InputError, beginning with name, for damaged bytes, another size than is said, and a compression that the build has no library
 *  for. \param compression "lz4" (its frames), "zstd" or "bz2" \param size bytes when decompressed \param result its memory is reused */
void decompress(const std::string& name, const std::string& compression, const std::string& bytes, std::uint64_t size,
                std::string& result);

/** \brief Throws InputError where the build has no library for it. \param name for messages  \param compression "lz4" or "zstd", both as fast as they are */
std::string compress(const std::string& name, const std::string& compression, const std::string& bytes);

}  // namespace fuse_flow::io
