#pragma once

#include <fuse_flow/math/host_device.h>

#include <cstdint>
#include <cstring>

namespace fuse_flow {

/** \brief e^x for x ≤ 0, the same bits on the CPU and on a GPU: weights decide which points stay, and two libraries' exp() differ in
 *  the last bit. Sums and products alone, which must not be contracted. At most one unit in the last place off, 1 at 0, never larger
 *  for a smaller x; 0 below −87, where floats lose digits, and for NaN. */
FUSE_FLOW_HD float expOfNegative(float x) {
  if (!(x >= -87.0f)) return 0.0f;
  // x = k ln 2 + r: adding 1.5 · 2^23 leaves the nearest integer in the lowest bits. k times the first part of ln 2 is exact.
  constexpr float shift = 12582912.0f;
  const float shifted = x * 1.44269504f + shift;
  const float k = shifted - shift;
  const float r = (x - k * 0.693359375f) - k * -2.12194440e-4f;
  // The polynomial of Cephes' expf() for |r| ≤ ln 2 / 2.
  float p = 1.9875691500e-4f;
  p = p * r + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  const float fraction = (p * (r * r) + r) + 1.0f;
  std::uint32_t bits;
  memcpy(&bits, &shifted, sizeof(bits));
  bits = (bits - 0x4b400000u + 127u) << 23;  // of 2^k
  float power;
  memcpy(&power, &bits, sizeof(power));
  return fraction * power;
}

}  // namespace fuse_flow
