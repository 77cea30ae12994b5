#pragma once

#include "io/image_io.h"

#include <cstdint>
#include <random>

namespace fuse_flow::io {

/** \brief Random numbers that are the same with every standard library: std::mt19937 is specified to the bit, the
 *  standard distributions are not. */
class PortableRandom {
 public:
  PortableRandom(std::uint32_t seed, std::uint32_t frame, std::uint32_t camera) {
    std::seed_seq sequence{seed, frame, camera};
    generator_.seed(sequence);
  }
  /** \brief In [0, 1). */
  double uniform() { return generator_() * 0x1p-32; }
  /** \brief Normal, mean 0, variance 1, within ±6: the sum of twelve uniform numbers, which needs no function whose
   *  last digit differs between machines. */
  double gaussian() {
    std::uint32_t sum = 0;
    for (int i = 0; i < 6; ++i) {
      const std::uint32_t draw = static_cast<std::uint32_t>(generator_());
      sum += (draw >> 16) + (draw & 0xffff);
    }
    return sum * 0x1p-16 - 6;
  }

 private:
  std::mt19937 generator_;
};

/** \brief What the sensor would see without faults; the depth image's size, 0 where there is nothing. */
struct TrueView {
  /** \brief Along the optical axis, metres. */
  FloatImage depth;
  /** \brief Cosine between the ray and the surface normal. */
  FloatImage cosine;
  /** \brief 0 where the projector's light does not reach, 1 elsewhere. */
  FloatImage lit;
};

/** \brief A structured-light camera with a 75 mm baseline (Kinect v1): axial noise of 1.5 mm at 1 m that grows with z²,
 *  depth quantised in disparity (3 mm at 1 m, 13 mm at 2 m), mixed pixels at depth edges, holes in the projector's
 *  shadow, at grazing angles and in small blobs, nothing past 4.5 m. Millimetres. */
void senseDepth(const TrueView& truth, PortableRandom& random, DepthImage& depth);

/** \brief The true depth, rounded to a millimetre. */
void roundDepth(const TrueView& truth, DepthImage& depth);

}  // namespace fuse_flow::io
