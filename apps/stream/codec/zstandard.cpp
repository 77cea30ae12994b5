#include "stream/codec/zstandard.h"

#include <fuse_flow/stream/streamed_cloud.h>

#include <zstd.h>

#include <new>
#include <stdexcept>
#include <string>

namespace fuse_flow::stream {

namespace {

void check(std::size_t result) {
  if (ZSTD_isError(result)) throw std::runtime_error(std::string("Zstandard: ") + ZSTD_getErrorName(result));
}

}  // namespace

void Compressor::Free::operator()(ZSTD_CCtx_s* context) const { ZSTD_freeCCtx(context); }
void Decompressor::Free::operator()(ZSTD_DCtx_s* context) const { ZSTD_freeDCtx(context); }

Compressor::Compressor() : context_(ZSTD_createCCtx()) {
  if (!context_) throw std::bad_alloc();
  // There is next to nothing that repeats: what is gained is gained by Huffman's codes, so that matches are looked for as little as can be.
  check(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, 1));
  check(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_windowLog, 17));
  check(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_hashLog, 8));
  check(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_minMatch, 7));
  check(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_checksumFlag, 1));
}

std::vector<std::uint8_t>& Compressor::begin() {
  bytes_.clear();
  return bytes_;
}

void Compressor::append(const std::uint8_t* data, const std::vector<std::size_t>& ends) {
  const std::size_t before = bytes_.size();
  // A block has a header of 3 bytes, a frame of at most 18 and a checksum; what does not shrink stays as it is.
  bytes_.resize(before + ZSTD_compressBound(ends.back()) + 16 * ends.size() + 32);
  ZSTD_outBuffer out{bytes_.data() + before, bytes_.size() - before, 0};
  std::size_t begin = 0;
  for (std::size_t k = 0; k < ends.size(); ++k) {
    ZSTD_inBuffer in{data + begin, ends[k] - begin, 0};
    const std::size_t left =
        ZSTD_compressStream2(context_.get(), &out, &in, k + 1 == ends.size() ? ZSTD_e_end : ZSTD_e_flush);
    check(left);
    if (left > 0) throw std::logic_error("Zstandard: a layer needs more bytes than it may");
    begin = ends[k];
  }
  bytes_.resize(before + out.pos);
}

Decompressor::Decompressor() : context_(ZSTD_createDCtx()) {
  if (!context_) throw std::bad_alloc();
}

std::size_t Decompressor::unpack(const std::uint8_t* data, std::size_t size, std::vector<std::uint8_t>& to) {
  const std::size_t written = ZSTD_decompressDCtx(context_.get(), to.data(), to.size(), data, size);
  if (ZSTD_isError(written))
    throw FormatError(std::string("a frame of points: a layer is damaged: ") + ZSTD_getErrorName(written));
  return written;
}

}  // namespace fuse_flow::stream
