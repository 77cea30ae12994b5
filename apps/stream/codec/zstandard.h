#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace fuse_flow::stream {

/** \brief Packs arrays by Zstandard: each array into blocks of its own, since what is common in one is not in the next. */
class Compressor {
 public:
  Compressor();

  /** \brief Memory to which append() appends, empty. */
  std::vector<std::uint8_t>& begin();
  /** \brief One frame of Zstandard, with its checksum. \param ends where each array ends; the last ends the data */
  void append(const std::uint8_t* data, const std::vector<std::size_t>& ends);

 private:
  struct Free {
    void operator()(ZSTD_CCtx_s* context) const;
  };
  std::unique_ptr<ZSTD_CCtx_s, Free> context_;
  std::vector<std::uint8_t> bytes_;
};

/** \brief Unpacks them. */
class Decompressor {
 public:
  Decompressor();

  /** \param to memory for the most that may come out \returns how much did \throws FormatError if it is not one whole frame, or damaged */
  std::size_t unpack(const std::uint8_t* data, std::size_t size, std::vector<std::uint8_t>& to);

 private:
  struct Free {
    void operator()(ZSTD_DCtx_s* context) const;
  };
  std::unique_ptr<ZSTD_DCtx_s, Free> context_;
};

}  // namespace fuse_flow::stream
