#include "simulation/true_view.h"

#include "simulation/portable_math.h"
#include "simulation/random.h"

#include <fuse_flow/impl/host/parallel.hpp>

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

}  // namespace

TrueView renderTrueView(const RayScene& scene, const Intrinsics& K, const Eigen::Isometry3d& T_world_camera,
                        const Eigen::Vector3f& second_eye, int threads) {
  TrueView view;
  for (io::FloatImage* image : {&view.depth, &view.cosine, &view.infrared, &view.seen_twice})
    image->resize(K.width, K.height);
  const PixelRays rays(K, T_world_camera);
  const Eigen::Vector3f eye = rays.toWorld(second_eye);
  const bool has_eye = second_eye.norm() > 0;
  parallelFor(threads, static_cast<std::size_t>(K.height), [&](std::size_t row, int) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < K.width; ++u) {
      const Eigen::Vector3f direction = rays.direction(static_cast<float>(u), static_cast<float>(v));
      const RayHit hit = scene.intersect(rays.origin(), direction);
      view.depth.at(u, v) = hit ? hit.t : 0.0f;
      if (!hit) continue;
      view.cosine.at(u, v) = std::fabs(hit.normal.dot(direction.normalized()));
      view.infrared.at(u, v) = scene.object(hit.object).material.infrared;
      view.seen_twice.at(u, v) = has_eye && scene.occluded(eye, hit.position, 2e-3f) ? 0.0f : 1.0f;
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
