#include "simulation/true_view.h"

#include "simulation/portable_math.h"
#include "simulation/random.h"

#include <fuse_flow/impl/host/parallel.hpp>

#include <array>
#include <limits>
#include <vector>

namespace fuse_flow::simulation {
namespace {

using host::parallelFor;

/** \brief One pass of a separable filter; at the border the weights that reach outside fall away. Returns a row or
 *  column's value times the square root of what keeps the variance of white noise at 1. */
float filtered(const std::vector<float>& kernel, int radius, const float* row, std::ptrdiff_t step, int at, int size) {
  float sum = 0, squares = 0;
  for (int k = -radius; k <= radius; ++k) {
    if (at + k < 0 || at + k >= size) continue;
    const float weight = kernel[static_cast<std::size_t>(k + radius)];
    sum += weight * row[step * k];
    squares += weight * weight;
  }
  return sum / std::sqrt(squares);
}

constexpr float kNowhere = std::numeric_limits<float>::infinity();

/** \brief What a pixel sees in each part of an exposure. */
using Sightings = std::array<RayHit, Exposure::kParts>;

/** \brief The surface that is seen the longest. */
struct Longest {
  int part{0};  ///< in which it is seen
  int count{1};
  float depth{0};
};

/** \brief Depths within a twentieth of each other are of one surface, as at the edges of the sensors. */
Longest longestSeen(const Sightings& seen, int parts) {
  const auto same = [&](int a, int b) {
    const float s = seen[static_cast<std::size_t>(a)].t, t = seen[static_cast<std::size_t>(b)].t;
    return s == t || std::fabs(s - t) < 0.05f * std::min(s, t);
  };
  Longest longest;
  for (int part = 0; part < parts; ++part) {
    const float own = seen[static_cast<std::size_t>(part)].t;
    int count = 0;
    float further = 0;  // than it, of those together: 0 for what stands still
    for (int other = 0; other < parts; ++other) {
      if (!same(part, other)) continue;
      ++count;
      if (other != part) further += seen[static_cast<std::size_t>(other)].t - own;
    }
    const float depth = own < kNowhere ? own + further / static_cast<float>(count) : kNowhere;
    if (part == 0 || count > longest.count || (count == longest.count && depth < longest.depth))
      longest = {part, count, depth};
  }
  return longest;
}

}  // namespace

TrueView renderTrueView(const Exposure& exposure, const Intrinsics& K, const Eigen::Isometry3d& T_world_camera,
                        const Eigen::Vector3f& second_eye, int threads) {
  TrueView view;
  for (io::FloatImage* image : {&view.depth, &view.cosine, &view.infrared, &view.seen_twice, &view.steadiness})
    image->resize(K.width, K.height);
  const RayScene& scene = exposure.scene();
  const PixelRays rays(K, T_world_camera);
  const Eigen::Vector3f eye = rays.toWorld(second_eye);
  const bool has_eye = second_eye.norm() > 0;
  const int parts = exposure.parts();
  parallelFor(threads, static_cast<std::size_t>(K.height), [&](std::size_t row, int) {
    const int v = static_cast<int>(row);
    const auto moment = [&](int part) { return exposure.moment(v, K.height, Exposure::middleOf(part, parts)); };
    for (int u = 0; u < K.width; ++u) {
      const Eigen::Vector3f direction = rays.direction(static_cast<float>(u), static_cast<float>(v));
      Sightings seen;
      for (int part = 0; part < parts; ++part)
        seen[static_cast<std::size_t>(part)] = scene.intersect(rays.origin(), direction, moment(part));
      const Longest longest = longestSeen(seen, parts);
      const RayHit& hit = seen[static_cast<std::size_t>(longest.part)];
      view.depth.at(u, v) = hit ? longest.depth : 0.0f;
      view.steadiness.at(u, v) = static_cast<float>(longest.count) / static_cast<float>(parts);
      if (!hit) continue;
      view.cosine.at(u, v) = std::fabs(hit.normal.dot(direction.normalized()));
      view.infrared.at(u, v) = scene.object(hit.object).material.infrared;
      const bool hidden = has_eye && scene.occluded(eye, hit.position, 2e-3f, moment(longest.part));
      view.seen_twice.at(u, v) = hidden ? 0.0f : 1.0f;
    }
  });
  return view;
}

io::FloatImage correlatedNoise(int width, int height, float sigma, std::uint64_t seed, int threads) {
  io::FloatImage white, rows, out;
  for (io::FloatImage* image : {&white, &rows, &out}) image->resize(width, height);
  const int radius = std::max(1, static_cast<int>(std::ceil(3 * sigma)));
  std::vector<float> kernel;
  for (int k = -radius; k <= radius; ++k)
    kernel.push_back(portable::exp(-0.5f * static_cast<float>(k * k) / (sigma * sigma)));
  const auto eachRow = [&](const auto& body) {
    parallelFor(threads, static_cast<std::size_t>(height), [&](std::size_t row, int) { body(static_cast<int>(row)); });
  };
  eachRow([&](int v) {
    for (int u = 0; u < width; ++u)
      white.at(u, v) =
          static_cast<float>(Random(seed, static_cast<std::uint64_t>(v), static_cast<std::uint64_t>(u), 77).gaussian());
  });
  eachRow([&](int v) {
    for (int u = 0; u < width; ++u) rows.at(u, v) = filtered(kernel, radius, &white.at(u, v), 1, u, width);
  });
  eachRow([&](int v) {
    for (int u = 0; u < width; ++u) out.at(u, v) = filtered(kernel, radius, &rows.at(u, v), width, v, height);
  });
  return out;
}

}  // namespace fuse_flow::simulation
