#pragma once

#include <fuse_flow/impl/stereo/host_backend.hpp>
#include <fuse_flow/impl/stereo/stereo_pipeline.hpp>
#include <fuse_flow/stereo/epipolar_errors.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Looks for points of one view in another one, along and beside their epipolar lines. */
class EpipolarMatching {
  using StereoLevel = detail::StereoLevel;
  using StereoSource = detail::StereoSource;

 public:
  EpipolarMatching(const StereoLevel* levels, std::size_t view, const WindowForm& form)
      : levels_(levels), level_(levels[view]), form_(form) {
    choosePoints();
  }

  /** \brief Distances of the matches from their lines, pixels of these images. */
  std::vector<float> distancesIn(const StereoSource& source) const {
    std::vector<float> distances;
    for (const Point& point : points_) {
      const float distance = distanceOf(point, source);
      if (std::isfinite(distance)) distances.push_back(distance);
    }
    return distances;
  }

 private:
  struct Point {
    Ray ray;
    ReferenceWindow window;
  };

  static constexpr int kReach = 6;     // pixels beside a line
  static constexpr int kColumns = 24;  // cells of which each gives a point
  static constexpr int kRows = 18;
  static constexpr float kTexture = 40;  // squared grey levels: several times the noise of a camera
  static constexpr float kAlike = 0.4f, kUnalike = 0.1f;

  /** \brief Of each cell of the image the window with the most texture. */
  void choosePoints() {
    const int width = level_.K.width, height = level_.K.height;
    const int border = 2 * form_.spacing;
    for (int row = 0; row < kRows; ++row)
      for (int column = 0; column < kColumns; ++column) {
        Point best{};
        float most = kTexture;
        for (int v = std::max(border, row * height / kRows); v < std::min((row + 1) * height / kRows, height - border);
             v += 3)
          for (int u = std::max(border, column * width / kColumns);
               u < std::min((column + 1) * width / kColumns, width - border); u += 3) {
            const ReferenceWindow window = referenceWindow(level_.image, u, v, form_);
            if (window.variance <= most) continue;
            most = window.variance;
            best = {level_.ray(u, v), window};
          }
        if (most > kTexture) points_.push_back(best);
      }
  }

  /** \brief A place that was tried. */
  struct Trial {
    float u, v;  ///< in the other image, pixels
    float cost;
    float beside;  ///< from the line, pixels
  };

  /** \brief NaN: no place, or more than one, looks like the point. */
  float distanceOf(const Point& point, const StereoSource& source) const {
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    std::vector<Trial> trials;
    const GreyImage& other = levels_[source.view].image;
    const float range = level_.max_inverse_depth - level_.min_inverse_depth;
    const int steps = std::max(2, std::min(512, static_cast<int>(range * level_.pixels_per_inverse_depth)));
    for (int k = 0; k <= steps; ++k) {
      const float w = level_.min_inverse_depth + range * static_cast<float>(k) / static_cast<float>(steps);
      const auto at = [&](float inverse_depth) {
        return localWarp(source.warp, {0, 0, inverse_depth}, point.ray, level_.pixel_x, level_.pixel_y);
      };
      const LocalWarp warp = at(w), ahead = at(w + range / static_cast<float>(steps));
      const float du = ahead.u - warp.u, dv = ahead.v - warp.v, length = std::sqrt(du * du + dv * dv);
      if (!warp.in_front || !ahead.in_front || !(length > 1e-6f)) continue;
      for (int beside = -kReach; beside <= kReach; ++beside) {
        LocalWarp moved = warp;
        moved.u -= dv / length * static_cast<float>(beside);
        moved.v += du / length * static_cast<float>(beside);
        trials.push_back(
            {moved.u, moved.v, matchingCost(point.window, form_, moved, other), static_cast<float>(beside)});
      }
    }
    const auto best =
        std::min_element(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.cost < b.cost; });
    if (best == trials.end() || best->cost > kAlike || std::fabs(best->beside) >= kReach) return none;
    float sum = 0, weights = 0;
    for (const Trial& trial : trials) {
      const float du = trial.u - best->u, dv = trial.v - best->v, away = du * du + dv * dv;
      if (away > 3 * 3 && trial.cost < best->cost + kUnalike) return none;
      // Between the lines that were tried: the mean about the best place, by how much better than its surroundings it matches.
      const float weight = away <= 2 * 2 ? std::max(0.0f, best->cost + kUnalike - trial.cost) : 0.0f;
      sum += weight * trial.beside;
      weights += weight;
    }
    return std::fabs(weights > 0 ? sum / weights : best->beside);
  }

  const StereoLevel* levels_;
  const StereoLevel& level_;
  WindowForm form_;
  std::vector<Point> points_;
};

}  // namespace host

FUSE_FLOW_INLINE std::vector<EpipolarError> epipolarErrors(const RigFrame& frame, const StereoParameters& parameters,
                                                           unsigned int threads) {
  checkParameters(parameters);
  detail::StereoPipeline<host::StereoBackend> pipeline;
  pipeline.parameters = parameters;
  pipeline.backend.threads = static_cast<int>(threads);
  pipeline.prepareImages(frame);
  const std::size_t size = pipeline.sizes() > 1 ? 1 : 0;  // half of the images: as good, in a fourth of the time
  std::vector<std::vector<EpipolarError>> of_views(pipeline.views());
  host::parallelFor(host::resolveThreads(static_cast<int>(threads)), pipeline.views(), [&](std::size_t view, int) {
    const detail::StereoLevel& level = pipeline.levels(size)[view];
    if (level.sources == 0) return;
    host::inWideVectors([&] {
      const host::EpipolarMatching matching(
          pipeline.levels(size), view,
          {parameters.window_spacing + 1, 3 * parameters.level_sigma, parameters.min_variance});
      for (int s = 0; s < level.sources; ++s) {
        std::vector<float> distances = matching.distancesIn(level.source[s]);
        EpipolarError error{view, level.source[s].view, distances.size(), std::numeric_limits<float>::quiet_NaN()};
        if (!distances.empty()) {
          const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
          std::nth_element(distances.begin(), middle, distances.end());
          error.median = *middle * static_cast<float>(1 << size);
        }
        of_views[view].push_back(error);
      }
    });
  });
  std::vector<EpipolarError> all;
  for (const std::vector<EpipolarError>& some : of_views) all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace fuse_flow
