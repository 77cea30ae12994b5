#pragma once

#include <fuse_flow/impl/parameters.hpp>
#include <fuse_flow/impl/quality/local_frame.hpp>
#include <fuse_flow/impl/quality/local_plane.hpp>
#include <fuse_flow/impl/sensors/frame_views.hpp>
#include <fuse_flow/quality/surface_quality.h>

namespace fuse_flow {

inline void checkParameters(const SurfaceQualityParameters& p) {
  constexpr const char* owner = "fuse_flow::surfaceQuality";
  detail::checkPositive(owner, "neighborhood", p.neighborhood);
  detail::checkRange(owner, "neighborhood", p.neighborhood, 0.0f, 1.0f);
  detail::checkPositive(owner, "visibility", p.visibility);
  constexpr int most = 8;
  static_assert(most <= host::DepthMap::kBorder, "windows reach into the border");
  detail::checkRange(owner, "silhouette", p.silhouette, 0, most);
  detail::checkPositive(owner, "min_separation", p.min_separation);
  detail::checkPositive(owner, "max_separation", p.max_separation);
  if (p.max_separation <= p.min_separation)
    detail::throwBadArgument(owner, ": max_separation is ", p.max_separation, ", must exceed min_separation, ",
                             p.min_separation);
  detail::checkPositive(owner, "coverage_radius", p.coverage_radius);
  detail::checkNonNegative(owner, "coverage_deviations", p.coverage_deviations);
  detail::checkPositive(owner, "max_coverage_radius", p.max_coverage_radius);
  if (p.max_coverage_radius < p.coverage_radius)
    detail::throwBadArgument(owner, ": max_coverage_radius is ", p.max_coverage_radius,
                             ", must not be below coverage_radius, ", p.coverage_radius);
  detail::checkRange(owner, "coverage_step", p.coverage_step, 1, 1 << 16);
  detail::checkNonNegative(owner, "max_motion", p.max_motion);
  detail::checkMeasuringRange(owner, p.min_range, p.max_range);
  detail::checkNoise(owner, p.noise);
}

inline SurfaceQuality& SurfaceQuality::operator+=(const SurfaceQuality& more) {
  points += more.points;
  sampled_points += more.sampled_points;
  surface_points += more.surface_points;
  judged_points += more.judged_points;
  double_points += more.double_points;
  violating_points += more.violating_points;
  pixels += more.pixels;
  covered_pixels += more.covered_pixels;
  noise_sum += more.noise_sum;
  flicker.points += more.flicker.points;
  flicker.sum += more.flicker.sum;
  return *this;
}

namespace detail {

/** \brief Every how many points one is looked at. */
inline std::size_t samplingStep(std::size_t points, std::size_t samples) {
  return samples == 0 ? 1 : std::max<std::size_t>(1, (points + samples - 1) / samples);
}

inline host::FrameViews viewsOf(const RigFrame& frame, const SurfaceQualityParameters& parameters, int threads) {
  PreprocessingParameters raw;
  raw.min_range = parameters.min_range;
  raw.max_range = parameters.max_range;
  host::FrameViews views;
  views.assign(frame, raw, threads);
  return views;
}

/** \brief What the views say about a point. */
struct PointSight {
  Vec3 towards{};  ///< from the point to the camera that sees it best, metres; zero: none sees it
  bool violates{false};
};

inline PointSight sightOf(const Vec3& p, const host::FrameViews& views, float visibility, int silhouette) {
  PointSight sight;
  float nearest = visibility;
  for (std::size_t j = 0; j < views.depths.size(); ++j) {
    const host::DepthMap& depth = views.depths[j];
    int u = 0, v = 0;
    float z = 0;
    if (depth.empty() || !views.rig[j].locate(p, u, v, z)) continue;
    const float D = depth.row(v)[u];
    if (!(D > 0)) continue;
    if (std::fabs(z - D) < nearest) {
      nearest = std::fabs(z - D);
      sight.towards = views.rig[j].T_world_camera.t - p;
    }
    if (!(z < D - visibility) || sight.violates) continue;
    bool free = true;
    for (int b = -silhouette; b <= silhouette && free; ++b)
      for (int a = -silhouette; a <= silhouette && free; ++a) {
        const float around = depth.row(v + b)[u + a];  // the map has a border
        free = !(around > 0) || z < around - visibility;
      }
    sight.violates = free;
  }
  return sight;
}

/** \brief Result of the test for one sheet or two. */
struct SheetTest {
  bool judged{false};
  bool doubled{false};
};

inline SheetTest testSheets(const PointIndex& index, const Vec3& p, const LocalPlane& plane, const Vec3& towards,
                            const std::vector<PointSight>& sights, const SurfaceQualityParameters& parameters) {
  constexpr std::size_t fewest = 16;
  const float lateral = 0.8f * parameters.neighborhood, height = parameters.max_separation;
  const float facing = dot(plane.normal, towards);
  std::vector<double> heights;
  index.visit(p, std::sqrt(lateral * lateral + height * height), [&](std::uint32_t k, const Vec3& q) {
    const Vec3 by = q - p;
    const float h = dot(plane.normal, by);
    if (std::fabs(h) > height || squaredNorm(by) - h * h > lateral * lateral) return false;
    if (dot(plane.normal, sights[k].towards) * facing > 0) heights.push_back(static_cast<double>(h));
    return false;
  });
  if (heights.size() < fewest) return {};
  return {true, cutInTwo(heights).apart(static_cast<double>(parameters.min_separation),
                                        static_cast<double>(parameters.max_separation))};
}

inline void measurePoints(const std::vector<Vec3>& points, const PointIndex& index, const host::FrameViews& views,
                          const SurfaceQualityParameters& parameters, int threads, SurfaceQuality& quality) {
  std::vector<PointSight> sights(points.size());
  host::parallelForEach(threads, points.size(), [&](std::size_t k) {
    sights[k] = sightOf(points[k], views, parameters.visibility, parameters.silhouette);
  });
  quality.points = points.size();
  for (const PointSight& sight : sights) quality.violating_points += sight.violates ? 1 : 0;

  struct Sample {
    LocalPlane plane;
    SheetTest sheets;
  };
  const std::size_t step = samplingStep(points.size(), parameters.samples);
  std::vector<Sample> samples((points.size() + step - 1) / step);
  host::parallelForEach(threads, samples.size(), [&](std::size_t s) {
    const std::size_t k = s * step;
    samples[s].plane = localPlane(index, points[k], parameters.neighborhood);
    if (samples[s].plane && squaredNorm(sights[k].towards) > 0)
      samples[s].sheets = testSheets(index, points[k], samples[s].plane, sights[k].towards, sights, parameters);
  });
  quality.sampled_points = samples.size();
  for (const Sample& sample : samples) {
    if (!sample.plane) continue;
    ++quality.surface_points;
    quality.noise_sum += sample.plane.deviation;
    quality.judged_points += sample.sheets.judged ? 1 : 0;
    quality.double_points += sample.sheets.doubled ? 1 : 0;
  }
}

inline void measureCoverage(const PointIndex& index, const host::FrameViews& views,
                            const SurfaceQualityParameters& parameters, int threads, SurfaceQuality& quality) {
  struct Counts {
    std::size_t pixels{0}, covered{0};
  };
  std::vector<Counts> per_view(views.depths.size());
  const int step = parameters.coverage_step;
  host::parallelFor(threads, views.depths.size(), [&](std::size_t j, int) {
    const host::DepthMap& depth = views.depths[j];
    const NoiseModel noise = views.rig[j].noise.value_or(parameters.noise);
    const float scale = depth.empty() ? 1.0f : host::measureNoiseScale(noise, depth);
    for (int v = 0; v < depth.height(); v += step)
      for (int u = 0; u < depth.width(); u += step) {
        const float z = depth.row(v)[u];
        if (!(z > 0)) continue;
        ++per_view[j].pixels;
        const float noisy = parameters.coverage_deviations * scale * axialNoise(noise, z);
        const float radius = clampTo(noisy, parameters.coverage_radius, parameters.max_coverage_radius);
        const Vec3 p = views.rig[j].T_world_camera * pointOnRay(views.rig[j].ray(u, v), z);
        per_view[j].covered += index.anyWithin(p, radius) ? 1 : 0;
      }
  });
  for (const Counts& counts : per_view) {
    quality.pixels += counts.pixels;
    quality.covered_pixels += counts.covered;
  }
}

/** \brief Whether what a view measures around a pixel has changed from one frame to the next: 1 yes, 0 no, −1 cannot be said. */
inline int changedAround(const host::DepthMap& here, const host::DepthMap& other, int u, int v, float visibility,
                         float max_motion) {
  constexpr int reach = 3, fewest = 10;
  double sum = 0, squares = 0;
  int n = 0, appeared = 0;
  for (int b = -reach; b <= reach; ++b)
    for (int a = -reach; a <= reach; ++a) {
      const float z = here.row(v + b)[u + a], w = other.row(v + b)[u + a];
      if (!(z > 0) || !(w > 0)) continue;
      const auto d = static_cast<double>(w - z);
      if (std::fabs(d) > static_cast<double>(visibility)) {
        ++appeared;
        continue;
      }
      sum += d;
      squares += d * d;
      ++n;
    }
  if (n + appeared < fewest) return -1;
  if (appeared > n) return 1;
  const double mean = sum / n, deviation = std::sqrt(std::max(squares / n - mean * mean, 0.0));
  return std::fabs(mean) > std::max(static_cast<double>(max_motion), deviation) ? 1 : 0;
}

inline bool standsStill(const Vec3& p, const host::FrameViews& here, const host::FrameViews& other,
                        const SurfaceQualityParameters& parameters) {
  bool still = false;
  for (std::size_t j = 0; j < here.depths.size(); ++j) {
    int u = 0, v = 0;
    float z = 0;
    if (here.depths[j].empty() || other.depths[j].empty() || !here.rig[j].locate(p, u, v, z)) continue;
    const float D = here.depths[j].row(v)[u];
    if (!(D > 0) || !(std::fabs(z - D) < parameters.visibility)) continue;
    const int changed =
        changedAround(here.depths[j], other.depths[j], u, v, parameters.visibility, parameters.max_motion);
    if (changed == 1) return false;
    still = still || changed == 0;
  }
  return still;
}

/** \brief The jumps of one cloud's points to the other's. */
inline void addFlicker(const std::vector<Vec3>& points, const PointIndex& own, const host::FrameViews& here,
                       const PointIndex& others, const host::FrameViews& there,
                       const SurfaceQualityParameters& parameters, int threads, TemporalFlicker& flicker) {
  const std::size_t step = samplingStep(points.size(), parameters.samples);
  std::vector<float> jumps((points.size() + step - 1) / step, -1.0f);
  host::parallelForEach(threads, jumps.size(), [&](std::size_t s) {
    const Vec3& p = points[s * step];
    if (!standsStill(p, here, there, parameters)) return;
    const LocalPlane plane = localPlane(own, p, parameters.neighborhood);
    if (!plane) return;
    // Beside it on the surface: the nearest point in space would be one of much the same height.
    float nearest = parameters.neighborhood * parameters.neighborhood, jump = parameters.neighborhood;
    others.visit(p, parameters.neighborhood, [&](std::uint32_t, const Vec3& q) {
      const Vec3 by = q - p;
      const float h = dot(plane.normal, by), beside = squaredNorm(by) - h * h;
      if (beside < nearest) {
        nearest = beside;
        jump = std::fabs(h);
      }
      return false;
    });
    jumps[s] = jump;
  });
  for (const float jump : jumps) {
    if (jump < 0) continue;
    ++flicker.points;
    flicker.sum += static_cast<double>(jump);
  }
}

}  // namespace detail

template <typename PointT>
SurfaceQuality surfaceQuality(const pcl::PointCloud<PointT>& cloud, const RigFrame& frame,
                              const SurfaceQualityParameters& parameters, unsigned int threads) {
  checkRigFrame(frame);
  checkParameters(parameters);
  const int resolved = host::resolveThreads(static_cast<int>(threads));
  const Eigen::Vector3d origin = detail::middleOf(frame);
  const host::FrameViews views = detail::viewsOf(detail::movedTo(origin, frame), parameters, resolved);
  const std::vector<Vec3> points = detail::pointsFrom(origin, cloud);
  const detail::PointIndex index(points, parameters.neighborhood);
  SurfaceQuality quality;
  detail::measurePoints(points, index, views, parameters, resolved, quality);
  detail::measureCoverage(index, views, parameters, resolved, quality);
  return quality;
}

template <typename PointT>
TemporalFlicker temporalFlicker(const pcl::PointCloud<PointT>& before, const RigFrame& before_frame,
                                const pcl::PointCloud<PointT>& after, const RigFrame& after_frame,
                                const SurfaceQualityParameters& parameters, unsigned int threads) {
  checkRigFrame(before_frame);
  checkRigFrame(after_frame);
  checkParameters(parameters);
  if (before_frame.cameras.size() != after_frame.cameras.size())
    detail::throwBadArgument("fuse_flow::temporalFlicker: the frames have ", before_frame.cameras.size(), " and ",
                             after_frame.cameras.size(), " cameras, must have the same");
  const int resolved = host::resolveThreads(static_cast<int>(threads));
  const Eigen::Vector3d origin = detail::middleOf(after_frame);
  const host::FrameViews views[2] = {detail::viewsOf(detail::movedTo(origin, before_frame), parameters, resolved),
                                     detail::viewsOf(detail::movedTo(origin, after_frame), parameters, resolved)};
  const std::vector<Vec3> points[2] = {detail::pointsFrom(origin, before), detail::pointsFrom(origin, after)};
  const detail::PointIndex indices[2] = {{points[0], parameters.neighborhood}, {points[1], parameters.neighborhood}};
  TemporalFlicker flicker;
  for (const std::size_t k : {0u, 1u})
    detail::addFlicker(points[k], indices[k], views[k], indices[1 - k], views[1 - k], parameters, resolved, flicker);
  return flicker;
}

}  // namespace fuse_flow
