#pragma once

#include <fuse_flow/math/noise_model.h>

#include <cstdint>
#include <cstring>

namespace fuse_flow {

// The noise of a view divided by the noise that axialNoise() expects: the median of the second differences of its inverse depth, which
// vanish on planes, at a spacing at which neighbours are independent. The median comes from a histogram, not from sorting, because sums of
// integers do not depend on the order of the threads.

/** \brief Spacing of the second differences, pixels. Sensors match blocks of this size, so nearer pixels are not independent. */
constexpr int kNoiseSpacing = 8;
/** \brief Every n-th pixel in both directions is used. */
constexpr int kNoiseStride = 4;
/** \brief With fewer second differences than this, the noise scale of the view is 1. */
constexpr std::uint32_t kMinNoiseSamples = 100;
constexpr float kMinNoiseScale = 0.25f;
constexpr float kMaxNoiseScale = 8.0f;

/** \brief 32 bins an octave, from 2⁻⁶ to 2⁶. */
constexpr int kNoiseBins = 12 * 32;

/** \brief The second difference of three inverse depths divided by its expected standard deviation. \param before depth, metres, > 0; the
 *  others likewise */
FUSE_FLOW_HD float noiseRatio(const NoiseModel& model, float before, float z, float after) {
  const float q = 1.0f / z;
  const float r = 1.0f / before - 2 * q + 1.0f / after;
  return (r < 0 ? -r : r) / (2.449490f * inverseDepthNoise(model, q));
}

/** \brief The bin of a ratio; values out of range go to the first or the last bin. */
FUSE_FLOW_HD int noiseBin(float ratio) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &ratio, sizeof bits);
  constexpr int first = (127 - 6) << 5;  // exponent and five bits of the mantissa of 2⁻⁶
  const int bin = static_cast<int>(bits >> 18) - first;
  return bin < 0 ? 0 : (bin < kNoiseBins ? bin : kNoiseBins - 1);
}

/** \brief Where a bin begins. */
FUSE_FLOW_HD float noiseBinBegin(int bin) {
  const std::uint32_t bits = static_cast<std::uint32_t>(bin + ((127 - 6) << 5)) << 18;
  float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

/** \brief The view's noise over axialNoise(), kMinNoiseScale … kMaxNoiseScale, where the median lies in a bin: of a normal
 *  distribution it is 0.6745 σ. \param half of all counts  \param before counts of the bins before  \param count its own */
FUSE_FLOW_HD float noiseScaleInBin(int bin, float half, std::uint32_t before, std::uint32_t count) {
  const float begin = noiseBinBegin(bin), end = noiseBinBegin(bin + 1);
  const float inside = (half - static_cast<float>(before)) / static_cast<float>(count > 0 ? count : 1u);
  const float scale = (begin + inside * (end - begin)) / 0.6745f;
  return scale < kMinNoiseScale ? kMinNoiseScale : (scale > kMaxNoiseScale ? kMaxNoiseScale : scale);
}

/** \brief The same from the counts of kNoiseBins bins. */
FUSE_FLOW_HD float noiseScale(const std::uint32_t* counts) {
  std::uint32_t total = 0;
  for (int bin = 0; bin < kNoiseBins; ++bin) total += counts[bin];
  if (total < kMinNoiseSamples) return 1.0f;
  const float half = 0.5f * static_cast<float>(total);
  std::uint32_t before = 0;
  int bin = 0;
  while (bin < kNoiseBins - 1 && static_cast<float>(before + counts[bin]) < half) before += counts[bin++];
  return noiseScaleInBin(bin, half, before, counts[bin]);
}

}  // namespace fuse_flow
