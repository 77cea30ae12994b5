#include "recordings/logs/decompress.h"

#include "recordings/files/cut_short.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>

#ifdef FUSE_FLOW_WITH_BZIP2
#include <bzlib.h>
#endif
#ifdef FUSE_FLOW_WITH_LZ4
#include <lz4frame.h>
#endif
#ifdef FUSE_FLOW_WITH_ZSTD
#include <zstd.h>
#endif

namespace fuse_flow::io {
namespace {

[[noreturn]] [[maybe_unused]] void throwNotBuilt(const std::string& name, const std::string& library,
                                                 const std::string& package) {
  throw InputError(name + ": cannot be used, since FUSE-Flow was built without " + library + "; install " + package +
                   ", and build it again");
}

/** \brief Whether all of it came out, and nothing else. */
bool decompressLz4([[maybe_unused]] const std::string& name, [[maybe_unused]] const std::string& bytes,
                   [[maybe_unused]] std::string& result) {
#ifdef FUSE_FLOW_WITH_LZ4
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return false;
  std::size_t in = 0, out = 0, hint = 1;
  while (hint != 0 && in < bytes.size()) {
    std::size_t read = bytes.size() - in, written = result.size() - out;
    hint = LZ4F_decompress(context, result.data() + out, &written, bytes.data() + in, &read, nullptr);
    if (LZ4F_isError(hint) || (read == 0 && written == 0)) break;
    in += read;
    out += written;
  }
  LZ4F_freeDecompressionContext(context);
  return hint == 0 && out == result.size();
#else
  throwNotBuilt(name, "LZ4", "liblz4-dev");
#endif
}

bool decompressBzip2([[maybe_unused]] const std::string& name, [[maybe_unused]] const std::string& bytes,
                     [[maybe_unused]] std::string& result) {
#ifdef FUSE_FLOW_WITH_BZIP2
  auto written = static_cast<unsigned int>(result.size());
  // It does not write to what it reads.
  return BZ2_bzBuffToBuffDecompress(result.data(), &written, const_cast<char*>(bytes.data()),
                                    static_cast<unsigned int>(bytes.size()), 0, 0) == BZ_OK &&
         written == result.size();
#else
  throwNotBuilt(name, "bzip2", "libbz2-dev");
#endif
}

bool decompressZstd([[maybe_unused]] const std::string& name, [[maybe_unused]] const std::string& bytes,
                    [[maybe_unused]] std::string& result) {
#ifdef FUSE_FLOW_WITH_ZSTD
  return ZSTD_decompress(result.data(), result.size(), bytes.data(), bytes.size()) == result.size();
#else
  throwNotBuilt(name, "Zstandard", "libzstd-dev");
#endif
}

}  // namespace

void decompress(const std::string& name, const std::string& compression, const std::string& bytes, std::uint64_t size,
                std::string& result) {
  constexpr std::uint64_t longest = 1ull << 31;  // of bzip2 unsigned int, twice that
  if (compression != "lz4" && compression != "zstd" && compression != "bz2")
    throw InputError(name + ": is compressed by '" + cutShort(compression) + "', must be by lz4, zstd or bz2");
  result.clear();
  const bool whole = size / kBestCompression <= bytes.size() &&
                     std::max<std::uint64_t>(size, bytes.size()) <= longest &&
                     (result.resize(size), compression == "lz4"   ? decompressLz4(name, bytes, result)
                                           : compression == "bz2" ? decompressBzip2(name, bytes, result)
                                                                  : decompressZstd(name, bytes, result));
  if (!whole) throw InputError(name + ": is damaged, and cannot be decompressed");
}

std::string compress([[maybe_unused]] const std::string& name, const std::string& compression,
                     [[maybe_unused]] const std::string& bytes) {
  std::string result;
  if (compression == "lz4") {
#ifdef FUSE_FLOW_WITH_LZ4
    result.resize(LZ4F_compressFrameBound(bytes.size(), nullptr));
    result.resize(LZ4F_compressFrame(result.data(), result.size(), bytes.data(), bytes.size(), nullptr));
#else
    throwNotBuilt(name, "LZ4", "liblz4-dev");
#endif
  } else {
#ifdef FUSE_FLOW_WITH_ZSTD
    result.resize(ZSTD_compressBound(bytes.size()));
    result.resize(ZSTD_compress(result.data(), result.size(), bytes.data(), bytes.size(), 1));
#else
    throwNotBuilt(name, "Zstandard", "libzstd-dev");
#endif
  }
  return result;
}

}  // namespace fuse_flow::io
