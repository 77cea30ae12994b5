#pragma once

#include <fuse_flow/distributed/codec.h>

#include <zstd.h>

#include <memory>
#include <new>

namespace fuse_flow {
namespace distributed {

/** \brief Zstandard, at its fastest of the ordinary levels: on messages of ranks, slower ones gain little. Link libzstd. */
class ZstdCodec : public Codec {
 public:
  /** \param level of libzstd; below 1 it is faster and compresses less */
  explicit ZstdCodec(int level = 1) : level_(level) {}

  std::uint32_t format() const override { return 0x64747a46; }  // "Fztd"

  void compress(const char* data, std::size_t n, Message& coded) const override {
    thread_local const std::unique_ptr<ZSTD_CCtx, std::size_t (*)(ZSTD_CCtx*)> context(ZSTD_createCCtx(),
                                                                                       ZSTD_freeCCtx);
    if (!context) throw std::bad_alloc();
    const std::size_t before = coded.size();
    coded.resize(before + ZSTD_compressBound(n));
    const std::size_t size =
        ZSTD_compressCCtx(context.get(), coded.data() + before, coded.size() - before, data, n, level_);
    if (ZSTD_isError(size)) throw std::bad_alloc();  // the only error there is where the room suffices
    coded.resize(before + size);
  }

  bool decompress(const char* coded, std::size_t size, char* to, std::size_t n) const override {
    thread_local const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(),
                                                                                       ZSTD_freeDCtx);
    if (!context) throw std::bad_alloc();
    return ZSTD_decompressDCtx(context.get(), to, n, coded, size) == n;
  }

 private:
  int level_;
};

}  // namespace distributed
}  // namespace fuse_flow
