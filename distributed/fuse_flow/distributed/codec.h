#pragma once

#include <fuse_flow/distributed/communicator.h>

#include <cstddef>
#include <cstdint>

namespace fuse_flow {
namespace distributed {

/** \brief Makes bytes fewer without loss, for ranks whose network is slower than that: see FuseFlow::setCodec(). Many threads use one object
 *  at a time. ZstdCodec is one. */
class Codec {
 public:
  virtual ~Codec() = default;

  /** \brief A number of its format: ranks whose numbers differ do not understand each other, and say so. Not 0. */
  virtual std::uint32_t format() const = 0;

  /** \brief Appends to \p coded what decompress() makes n bytes of again. */
  virtual void compress(const char* data, std::size_t n, Message& coded) const = 0;

  /** \brief Writes exactly n bytes. \returns false if \p coded is not what compress() made of so many; it may be any bytes */
  virtual bool decompress(const char* coded, std::size_t size, char* to, std::size_t n) const = 0;
};

}  // namespace distributed
}  // namespace fuse_flow
