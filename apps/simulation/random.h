#pragma once

#include <cstdint>

namespace fuse_flow::simulation {

/** \brief Random numbers by number, not by turn: whichever thread asks for pixel 17 of camera 3, it gets the same. Made
 *  from integers alone, so that every platform gives the same bits. */
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t frame, std::uint64_t camera, std::uint64_t item) {
    state_ = mix(mix(mix(mix(seed) + frame) + camera) + item);
  }

  /** \brief In [0, 1). */
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }

  /** \brief Normal, mean 0, variance 1, within ±6: the sum of twelve uniform numbers. */
  double gaussian() {
    std::uint64_t sum = 0;
    for (int i = 0; i < 3; ++i) {
      const std::uint64_t draw = next();
      sum += (draw >> 48) + (draw >> 32 & 0xffff) + (draw >> 16 & 0xffff) + (draw & 0xffff);
    }
    return static_cast<double>(sum) * 0x1p-16 - 6.0 + 6.0 * 0x1p-16;
  }

 private:
  /** \brief The finaliser of SplitMix64. */
  static std::uint64_t mix(std::uint64_t z) {
    z += 0x9e3779b97f4a7c15ull;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ z >> 27) * 0x94d049bb133111ebull;
    return z ^ z >> 31;
  }
  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15ull;
    return mix(state_);
  }

  std::uint64_t state_;
};

}  // namespace fuse_flow::simulation
