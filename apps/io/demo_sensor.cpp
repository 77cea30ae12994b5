#include "io/demo_sensor.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::io {
namespace {

constexpr double disparity_metres = 525 * 0.075;  // focal length · baseline: disparity in pixels = this / z
constexpr double disparity_step = 0.125;          // pixels
constexpr double disparity_sigma = 0.0015 * disparity_metres;  // 1.5 mm at 1 m
constexpr double max_range = 4.5;                              // metres
constexpr double edge_step = 0.06;                             // metres between neighbours that make a depth edge
constexpr double mixed_share = 0.35, edge_hole_share = 0.15;

/** \brief The nearest and the farthest of a pixel and its eight neighbours. */
std::pair<float, float> depthSpan(const FloatImage& depth, int u, int v) {
  float low = depth.at(u, v), high = low;
  for (int b = std::max(0, v - 1); b <= std::min(depth.height - 1, v + 1); ++b)
    for (int a = std::max(0, u - 1); a <= std::min(depth.width - 1, u + 1); ++a) {
      const float z = depth.at(a, b);
      if (z <= 0) continue;
      low = std::min(low, z);
      high = std::max(high, z);
    }
  return {low, high};
}

double quantise(double z, double noise) {
  const double disparity = disparity_metres / z + disparity_sigma * noise;
  return disparity_metres / (std::round(disparity / disparity_step) * disparity_step);
}

std::uint16_t toMillimetres(double z) {
  return z > 0 && z < max_range ? static_cast<std::uint16_t>(std::lround(1000 * z)) : std::uint16_t{0};
}

void punchBlobs(PortableRandom& random, DepthImage& depth) {
  const int blobs = depth.width * depth.height / 10000;
  for (int i = 0; i < blobs; ++i) {
    const int centre_u = static_cast<int>(random.uniform() * depth.width);
    const int centre_v = static_cast<int>(random.uniform() * depth.height);
    const double radius = 1 + 3 * random.uniform();  // pixels
    const int reach = static_cast<int>(radius);
    for (int dv = -reach; dv <= reach; ++dv)
      for (int du = -reach; du <= reach; ++du) {
        const int u = centre_u + du, v = centre_v + dv;
        if (u >= 0 && v >= 0 && u < depth.width && v < depth.height && du * du + dv * dv <= radius * radius)
          depth.at(u, v) = 0;
      }
  }
}

}  // namespace

void senseDepth(const TrueView& truth, PortableRandom& random, DepthImage& depth) {
  depth.resize(truth.depth.width, truth.depth.height);
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u) {
      // Drawn for every pixel, so that a change in one does not shift the noise of all that follow.
      const double noise = random.gaussian(), fate = random.uniform(), mix = random.uniform();
      double z = truth.depth.at(u, v);
      const auto [low, high] = depthSpan(truth.depth, u, v);
      const double grazing_loss = (0.3 - truth.cosine.at(u, v)) / 0.2;  // all is lost below a cosine of 0.1
      const bool edge = high - low > edge_step;
      const bool hole = z <= 0 || truth.lit.at(u, v) == 0 || mix < grazing_loss || (edge && fate > 1 - edge_hole_share);
      if (edge && fate < mixed_share) z = low + mix * (high - low);
      depth.at(u, v) = hole ? std::uint16_t{0} : toMillimetres(quantise(z, noise));
    }
  punchBlobs(random, depth);
}

void roundDepth(const TrueView& truth, DepthImage& depth) {
  depth.resize(truth.depth.width, truth.depth.height);
  std::transform(truth.depth.data.begin(), truth.depth.data.end(), depth.data.begin(),
                 [](float z) { return toMillimetres(z); });
}

}  // namespace fuse_flow::io
