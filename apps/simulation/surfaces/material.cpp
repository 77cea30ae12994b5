#include "simulation/surfaces/mesh.h"

#include "simulation/portable_math.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3f;

/** \brief A number in [0, 1) for a cell of a grid; integers alone, so that every platform gives the same. */
float cellValue(int x, int y, int z) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 73856093u ^ static_cast<std::uint32_t>(y) * 19349663u ^
                    static_cast<std::uint32_t>(z) * 83492791u;
  h = (h ^ h >> 16) * 0x45d9f3bu;
  h = (h ^ h >> 16) * 0x45d9f3bu;
  return static_cast<float>((h ^ h >> 16) >> 8) * 0x1p-24f;
}

/** \brief Value noise: cellValue() at the corners of unit cells, blended smoothly; [0, 1). */
float valueNoise(const Vector3f& p) {
  const Vector3f low = p.array().floor();
  Vector3f w = p - low;
  w = (w.array() * w.array() * (3 - 2 * w.array())).matrix();
  const int x = static_cast<int>(low.x()), y = static_cast<int>(low.y()), z = static_cast<int>(low.z());
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    sum += (i ? w.x() : 1 - w.x()) * (j ? w.y() : 1 - w.y()) * (k ? w.z() : 1 - w.z()) * cellValue(x + i, y + j, z + k);
  }
  return sum;
}

/** \brief Three octaves, from size down to a quarter of it, contrast stretched to about [0, 1]. */
float fractalNoise(const Vector3f& p) {
  const float sum = (valueNoise(p) + 0.5f * valueNoise(2.03f * p) + 0.25f * valueNoise(4.01f * p)) / 1.75f;
  return std::clamp(0.5f + 1.8f * (sum - 0.5f), 0.0f, 1.0f);
}

/** \brief Growth rings of a trunk along x, in boards of ten rings' width, with a fine grain. */
float wood(const Vector3f& p) {
  const float board = std::floor(p.y() / 10);
  const Vector3f stretched(0.15f * p.x() + 7.3f * board, p.y(), p.z());
  const float from_pith = portable::hypot(p.y() - 10 * board - 14, p.z() + 3.7f) + 1.6f * valueNoise(0.4f * stretched);
  const float ring = from_pith - std::floor(from_pith);
  const float grain = valueNoise(Vector3f(0.3f * p.x(), 6 * p.y(), 6 * p.z()));
  return std::clamp(0.75f * ring * ring + 0.3f * grain + 0.3f * (cellValue(static_cast<int>(board), 1, 2) - 0.5f), 0.0f,
                    1.0f);
}

/** \brief Where AprilTag 0 of the family 36h11 is black, seen from z > 0: x to the right, y up, in cells from its middle. There is
 *  a white rim around it, and it has a white back. */
float marker(const Vector3f& p) {
  static constexpr const char* rows[] = {"          ", " ######## ", " #  # # # ", " ##   # # ", " ##  #### ",
                                         " # # #### ", " ## #  ## ", " #### ### ", " ######## ", "          "};
  constexpr int cells = 10;
  const int row = static_cast<int>(std::floor(0.5f * cells - p.y())),
            column = static_cast<int>(std::floor(0.5f * cells + p.x()));
  if (p.z() < -0.01f || row < 0 || column < 0 || row >= cells || column >= cells) return 0;
  return rows[row][column] == '#' ? 1 : 0;
}

/** \brief Share of the second colour. */
float share(const Material& material, const Vector3f& rest) {
  // Moved by odd parts of the size: no border of the pattern lies in a wall at a round number.
  const Vector3f p = rest / material.size + Vector3f(0.371f, 0.413f, 0.457f);
  switch (material.pattern) {
    case Material::Plain:
      return 0;
    case Material::Checker: {
      const Vector3f cell = p.array().floor();
      return static_cast<float>(static_cast<int>(cell.sum()) & 1);
    }
    case Material::Stripes: {
      const float across = p.dot(Vector3f(0.48f, 0.36f, 0.8f));  // crosses every wall, floor and sleeve
      return across - std::floor(across) < 0.5f ? 0.0f : 1.0f;
    }
    case Material::Wood:
      return wood(p);
    case Material::Noise:
      return fractalNoise(p);
    case Material::Marker:
      return marker(rest / material.size);
  }
  return 0;
}

Vector3f channels(const Rgb8& c) { return Eigen::Matrix<std::uint8_t, 3, 1>(c.r, c.g, c.b).cast<float>(); }

}  // namespace

Vector3f albedo(const Material& material, const Vector3f& rest) {
  const float second = share(material, rest);
  return (1 - second) * channels(material.first) + second * channels(material.second);
}

}  // namespace fuse_flow::simulation
