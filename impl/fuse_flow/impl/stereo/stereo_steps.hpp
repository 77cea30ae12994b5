#pragma once

#include <fuse_flow/depth_view.h>
#include <fuse_flow/math/stereo/matching_cost.h>
#include <fuse_flow/math/stereo/propagation.h>
#include <fuse_flow/stereo/parameters.h>

/** \file
 *  \brief The steps of multi-view stereo, each for one pixel of one view: what the CPU and the GPU both run. */

namespace fuse_flow {
namespace detail {

/** \brief Another view that a view is matched with. */
struct StereoSource {
  std::uint32_t view;                 ///< its number
  ViewWarp warp;                      ///< rays of the view → its pixels
  RigidTransform T_reference_source;  ///< its frame → the view's frame, metres
};

/** \brief One view at one size of its image. */
struct StereoLevel {
  Intrinsics K;            ///< of an ideal lens
  float pixel_x, pixel_y;  ///< 1/fx, 1/fy
  GreyImage image;
  int sources;  ///< 0: the view has no image, or none sees the same
  StereoSource source[kMaxStereoSources];
  float min_inverse_depth;         ///< 1/m
  float max_inverse_depth;         ///< 1/m
  float pixels_per_inverse_depth;  ///< by which the image in the farthest source moves, pixels · m
  int planes;                      ///< of the sweep
  InversePlane* plane;             ///< of each pixel
  InversePlane* before;            ///< before this pass: what other views compare with
  float* cost;                     ///< of `plane`
  std::uint8_t*
      repeated;  ///< of each block of kRepetitionBlock² pixels of the largest images: whether its pattern repeats itself

  FUSE_FLOW_HD Ray ray(int u, int v) const {
    return {(static_cast<float>(u) - K.cx) / K.fx, (static_cast<float>(v) - K.cy) / K.fy};
  }
  FUSE_FLOW_HD std::size_t indexOf(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(K.width) + static_cast<std::size_t>(u);
  }
};

/** \brief Side of the blocks of the largest images that are looked at for repetition, pixels: a little more than a window. */
constexpr int kRepetitionBlock = 12;
FUSE_FLOW_HD constexpr std::uint32_t repetitionBlocks(int pixels) {
  return static_cast<std::uint32_t>((pixels + kRepetitionBlock - 1) / kRepetitionBlock);
}

/** \brief A pixel of a view. */
struct StereoPixel {
  std::uint32_t view;
  int u, v;
};

/** \brief The pixels of all views in one row, one number for each. */
struct StereoGrid {
  const StereoLevel* levels;   ///< of the views
  const std::uint32_t* first;  ///< number of the first pixel of each view, and of all
  std::uint32_t views;

  FUSE_FLOW_HD std::uint32_t viewOf(std::uint32_t index) const {
    std::uint32_t low = 0, high = views;
    while (low + 1 < high) {
      const std::uint32_t middle = (low + high) / 2;
      if (first[middle] <= index) {
        low = middle;
      } else {
        high = middle;
      }
    }
    return low;
  }
  FUSE_FLOW_HD StereoPixel pixel(std::uint32_t index) const {
    const std::uint32_t view = viewOf(index);
    const std::uint32_t inside = index - first[view], width = static_cast<std::uint32_t>(levels[view].K.width);
    return {view, static_cast<int>(inside % width), static_cast<int>(inside / width)};
  }
};

/** \brief What the cost of a plane depends on. */
struct StereoForm {
  WindowForm window;
  int best_sources;
  float geometric_weight;  ///< 0: other views' depth is not asked
  float geometric_limit;
  float min_incidence;
};

/** \brief Within what two views say the same. */
struct AgreementLimits {
  float pixels{1.0f};     ///< there and back
  float relative{0.01f};  ///< of the depth …
  /** \brief … or this many pixels of the widest baseline, where that is more: cameras that stand near each other cannot tell depth better. */
  float disparity{0.5f};
  float most{0.05f};  ///< of the depth, whatever the baseline
};

/** \brief A pixel whose planes are compared. */
struct StereoCandidate {
  const StereoLevel* levels;  ///< of all views
  const StereoLevel& level;   ///< of the pixel's view
  Ray ray;
  ReferenceWindow window;
  const StereoForm& form;

  /** \brief How far from its pixel a point comes back from a source, by way of the source's depth, pixels; at most the limit. */
  FUSE_FLOW_HD float geometricError(const StereoSource& source, const LocalWarp& warp) const {
    const StereoLevel& other = levels[source.view];
    const float limit = form.geometric_limit;
    if (!warp.in_front) return limit;
    const float x = warp.u + 0.5f, y = warp.v + 0.5f;
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(other.K.width) && y < static_cast<float>(other.K.height)))
      return limit;
    const InversePlane& plane = other.before[other.indexOf(static_cast<int>(x), static_cast<int>(y))];
    const Ray there{(warp.u - other.K.cx) / other.K.fx, (warp.v - other.K.cy) / other.K.fy};
    const float inverse_depth = inverseDepth(plane, there);
    if (!(inverse_depth > 0)) return limit;
    const Vec3 p = source.T_reference_source * pointOnRay(there, 1.0f / inverse_depth);
    if (!(p.z > 0)) return limit;
    const float du = (p.x / p.z - ray.x) * level.K.fx, dv = (p.y / p.z - ray.y) * level.K.fy;
    const float error = std::sqrt(du * du + dv * dv);
    return error < limit ? error : limit;
  }

  /** \brief Whether anything on the ray, at a depth of the range, falls into a source's image. */
  FUSE_FLOW_HD bool couldBeSeenBy(const StereoSource& source) const {
    // In homogeneous pixels of the source the ray is a + w t, of inverse depth w: each border of the image bounds w.
    const ViewWarp& m = source.warp;
    const Intrinsics& K = levels[source.view].K;
    const Vec3 a{ray.x * m.u.x + ray.y * m.u.y + m.u.z, ray.x * m.v.x + ray.y * m.v.y + m.v.z,
                 ray.x * m.z.x + ray.y * m.z.y + m.z.z};
    const Vec3 t = m.t;
    const float right = static_cast<float>(K.width) - 0.5f, bottom = static_cast<float>(K.height) - 0.5f;
    float low = level.min_inverse_depth, high = level.max_inverse_depth;
    return keepPositive(a.z, t.z, low, high) && keepPositive(a.x + 0.5f * a.z, t.x + 0.5f * t.z, low, high) &&
           keepPositive(a.y + 0.5f * a.z, t.y + 0.5f * t.z, low, high) &&
           keepPositive(right * a.z - a.x, right * t.z - t.x, low, high) &&
           keepPositive(bottom * a.z - a.y, bottom * t.z - t.y, low, high);
  }

  /** \brief Whether no other source than one could see what lies on the ray: cameras that look outward overlap in pairs. */
  FUSE_FLOW_HD bool isSeenByAlone(int one) const {
    for (int k = 0; k < level.sources; ++k)
      if (k != one && couldBeSeenBy(level.source[k])) return false;
    return true;
  }

  /** \brief Whether a source's depth agrees with a plane, whose inverse depth at the pixel is w. */
  FUSE_FLOW_HD bool agrees(const StereoSource& source, const LocalWarp& warp, float w,
                           const AgreementLimits& agreement) const {
    if (!(geometricError(source, warp) <= agreement.pixels)) return false;
    const StereoLevel& other = levels[source.view];
    const Ray there{(warp.u - other.K.cx) / other.K.fx, (warp.v - other.K.cy) / other.K.fy};
    const InversePlane& plane =
        other.before[other.indexOf(static_cast<int>(warp.u + 0.5f), static_cast<int>(warp.v + 0.5f))];
    const Vec3 p = source.T_reference_source * pointOnRay(there, 1.0f / inverseDepth(plane, there));
    const float of_disparity = agreement.disparity / (level.pixels_per_inverse_depth * w);
    const float share = of_disparity < agreement.most ? of_disparity : agreement.most;
    return std::fabs(p.z * w - 1) <= (agreement.relative > share ? agreement.relative : share);
  }
  /** \brief Leaves of an interval the part in which begin + slope · w is not negative; whether any is left. */
  FUSE_FLOW_HD static bool keepPositive(float begin, float slope, float& low, float& high) {
    if (slope == 0) return begin >= 0;
    const float zero = -begin / slope;
    if (slope > 0) {
      low = zero > low ? zero : low;
    } else {
      high = zero < high ? zero : high;
    }
    return low <= high;
  }

  FUSE_FLOW_HD LocalWarp warpOf(const StereoSource& source, const InversePlane& plane) const {
    return localWarp(source.warp, plane, ray, level.pixel_x, level.pixel_y);
  }

  FUSE_FLOW_HD float costIn(const StereoSource& source, const InversePlane& plane) const {
    return matchingCost(window, form.window, warpOf(source, plane), levels[source.view].image);
  }

  FUSE_FLOW_HD float costOf(const InversePlane& plane, float geometric_weight) const {
    BestCosts best;
    for (int k = 0; k < level.sources; ++k) {
      const StereoSource& source = level.source[k];
      const LocalWarp warp = warpOf(source, plane);
      float cost = matchingCost(window, form.window, warp, levels[source.view].image);
      if (geometric_weight > 0 && cost < kWorstCost) {
        cost += geometric_weight * geometricError(source, warp);
        cost = cost < kWorstCost ? cost : kWorstCost;
      }
      best.add(cost);
    }
    return best.mean(form.best_sources < level.sources ? form.best_sources : level.sources);
  }
  FUSE_FLOW_HD float costOf(const InversePlane& plane) const { return costOf(plane, form.geometric_weight); }

  /** \brief Whether a plane is in the range of depth, and is not seen too much from the side. */
  FUSE_FLOW_HD bool possible(const InversePlane& plane) const {
    const float w = inverseDepth(plane, ray);
    return w >= level.min_inverse_depth && w <= level.max_inverse_depth &&
           incidenceCosine(plane, ray, w) >= form.min_incidence;
  }
};

FUSE_FLOW_HD StereoCandidate candidateAt(const StereoGrid& grid, const StereoForm& form, const StereoPixel& at) {
  const StereoLevel& level = grid.levels[at.view];
  return {grid.levels, level, level.ray(at.u, at.v), referenceWindow(level.image, at.u, at.v, form.window), form};
}

/** \brief Grey levels of the image without distortion. */
struct MakeGreyImage {
  StereoGrid grid;
  const ImageView<Rgb8>* colors;  ///< of the views
  const Intrinsics* lenses;       ///< of the colour images
  std::uint8_t* const* grey;      ///< to fill, of the views

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const StereoPixel at = grid.pixel(index);
    const StereoLevel& level = grid.levels[at.view];
    const ImageView<Rgb8>& color = colors[at.view];
    std::uint8_t& to = grey[at.view][level.indexOf(at.u, at.v)];
    if (!color) {
      to = 0;
      return;
    }
    const Intrinsics& lens = lenses[at.view];
    const auto level_at = [&](int u, int v) {
      const Rgb8 c = color.row(v)[u];
      return greyOf(c.r, c.g, c.b);
    };
    if (isIdeal(lens.distortion)) {
      to = level_at(at.u, at.v);
      return;
    }
    const Ray ray = distort(lens.distortion, level.ray(at.u, at.v));
    const float u = lens.fx * ray.x + lens.cx, v = lens.fy * ray.y + lens.cy;
    const float right = static_cast<float>(lens.width - 1), low = static_cast<float>(lens.height - 1);
    if (!(u >= 0 && v >= 0 && u <= right && v <= low)) {
      to = 0;
      return;
    }
    const int a = static_cast<int>(u), b = static_cast<int>(v);
    const int a1 = a + 1 < lens.width ? a + 1 : a, b1 = b + 1 < lens.height ? b + 1 : b;
    const float across = u - static_cast<float>(a), along = v - static_cast<float>(b);
    const auto mix = [](float x, float y, float t) { return x + t * (y - x); };
    const auto f = [&](int x, int y) { return static_cast<float>(static_cast<int>(level_at(x, y))); };
    to = static_cast<std::uint8_t>(
        static_cast<int>(mix(mix(f(a, b), f(a1, b), across), mix(f(a, b1), f(a1, b1), across), along) + 0.5f));
  }
};

/** \brief An image of half the width and height: the means of 2 × 2 pixels. */
struct HalveGreyImage {
  StereoGrid grid;            ///< of the smaller images
  const StereoLevel* larger;  ///< of the views
  std::uint8_t* const* grey;  ///< to fill, of the views

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const StereoPixel at = grid.pixel(index);
    const GreyImage& from = larger[at.view].image;
    const std::uint8_t* row = from.pixels + static_cast<std::size_t>(2 * at.v) * static_cast<std::size_t>(from.width) +
                              static_cast<std::size_t>(2 * at.u);
    const int sum = row[0] + row[1] + row[from.width] + row[from.width + 1];
    grey[at.view][grid.levels[at.view].indexOf(at.u, at.v)] = static_cast<std::uint8_t>((sum + 2) / 4);
  }
};

/** \brief GreyImage::quads. */
struct MakeQuads {
  StereoGrid grid;
  std::uint32_t* const* quads;  ///< to fill, of the views

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const StereoPixel at = grid.pixel(index);
    const GreyImage& image = grid.levels[at.view].image;
    quads[at.view][grid.levels[at.view].indexOf(at.u, at.v)] =
        quadOf(image.pixels, image.width, image.height, at.u, at.v);
  }
};

/** \brief Of planes that face the camera, evenly spaced in inverse depth, the one that matches best; for one of 2 × 2 pixels, which all get
 *  it. */
struct SweepPlanes {
  StereoGrid grid;  ///< of blocks of 2 × 2 pixels
  StereoForm form;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const std::uint32_t view = grid.viewOf(index);
    const StereoLevel& level = grid.levels[view];
    if (level.sources == 0) return;
    const std::uint32_t columns = static_cast<std::uint32_t>(level.K.width + 1) / 2, inside = index - grid.first[view];
    const int u = 2 * static_cast<int>(inside % columns), v = 2 * static_cast<int>(inside / columns);
    const InversePlane best = bestOf(candidateAt(grid, form, {view, u, v}));
    for (int b = v; b < v + 2 && b < level.K.height; ++b)
      for (int a = u; a < u + 2 && a < level.K.width; ++a) level.plane[level.indexOf(a, b)] = best;
  }

 private:
  FUSE_FLOW_HD static InversePlane bestOf(const StereoCandidate& candidate) {
    const StereoLevel& level = candidate.level;
    const float range = level.max_inverse_depth - level.min_inverse_depth;
    InversePlane best{0, 0, level.min_inverse_depth};
    float best_cost = 2 * kWorstCost;
    for (int k = 0; k < level.planes; ++k) {
      const float share = (static_cast<float>(k) + 0.5f) / static_cast<float>(level.planes);
      const InversePlane plane{0, 0, level.min_inverse_depth + share * range};
      const float cost = candidate.costOf(plane, 0);
      if (cost < best_cost) {
        best_cost = cost;
        best = plane;
      }
    }
    return best;
  }
};

/** \brief Slopes of what the sweep has found, before the first pass: of each pixel the plane through its depth that fits its neighbours best
 *  which lie within a step and a half of the sweep for each pixel that they are away. */
struct FitSlopes {
  StereoGrid grid;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const StereoPixel at = grid.pixel(index);
    const StereoLevel& level = grid.levels[at.view];
    if (level.sources == 0) return;
    constexpr int reach = 3;
    const float step = 1.5f * (level.max_inverse_depth - level.min_inverse_depth) / static_cast<float>(level.planes);
    const std::size_t place = level.indexOf(at.u, at.v);
    const float here = level.before[place].w;
    float by_column = 0, by_row = 0, columns = 0, rows = 0;
    for (int b = -reach; b <= reach; ++b)
      for (int a = -reach; a <= reach; ++a) {
        const int u = at.u + a, v = at.v + b;
        if (u < 0 || v < 0 || u >= level.K.width || v >= level.K.height) continue;
        const float rise = level.before[level.indexOf(u, v)].w - here;
        const int away = (a < 0 ? -a : a) > (b < 0 ? -b : b) ? (a < 0 ? -a : a) : (b < 0 ? -b : b);
        if (std::fabs(rise) > step * static_cast<float>(away)) continue;
        const float column = static_cast<float>(a), row = static_cast<float>(b);
        by_column += column * rise;
        by_row += row * rise;
        columns += column * column;
        rows += row * row;
      }
    const Ray ray = level.ray(at.u, at.v);
    const InversePlane plane = planeThrough(ray, here, columns > 0 ? by_column / columns * level.K.fx : 0.0f,
                                            rows > 0 ? by_row / rows * level.K.fy : 0.0f);
    if (incidenceCosine(plane, ray, here) >= min_incidence) level.plane[place] = plane;
  }

  float min_incidence;
};

/** \brief The planes of the level before: four pixels take over that of the one they have become. */
struct TakePlanesOver {
  StereoGrid grid;
  const StereoLevel* smaller;  ///< of the views

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const StereoPixel at = grid.pixel(index);
    const StereoLevel& level = grid.levels[at.view];
    const StereoLevel& from = smaller[at.view];
    if (level.sources == 0) return;
    const int u = at.u / 2 < from.K.width ? at.u / 2 : from.K.width - 1;
    const int v = at.v / 2 < from.K.height ? at.v / 2 : from.K.height - 1;
    level.plane[level.indexOf(at.u, at.v)] = from.plane[from.indexOf(u, v)];
  }
};

/** \brief Keeps the planes before a pass, and what they cost now: other views' depth has changed. */
struct BeginPass {
  StereoGrid grid;
  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const StereoPixel at = grid.pixel(index);
    const StereoLevel& level = grid.levels[at.view];
    if (level.sources == 0) return;
    const std::size_t place = level.indexOf(at.u, at.v);
    level.before[place] = level.plane[place];
  }
};

/** \brief What the planes cost. */
struct CostPlanes {
  StereoGrid grid;
  StereoForm form;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const StereoPixel at = grid.pixel(index);
    const StereoLevel& level = grid.levels[at.view];
    if (level.sources == 0) return;
    const std::size_t place = level.indexOf(at.u, at.v);
    level.cost[place] = candidateAt(grid, form, at).costOf(level.plane[place]);
  }
};

/** \brief Pixels of one colour of a checkerboard try the planes of pixels of the other colour, and changes of their own. */
struct PropagatePlanes {
  StereoGrid grid;  ///< of half the columns: pixels of one colour
  StereoForm form;
  int color;
  std::uint32_t seed;
  std::uint32_t pass;  ///< number of the pass over all levels
  float reach;         ///< largest random change of depth, pixels in the farthest source
  int areas;           ///< whose planes are tried, see candidateOffset(): kNearAreas or kPropagationAreas

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const std::uint32_t view = grid.viewOf(index);
    const StereoLevel& level = grid.levels[view];
    if (level.sources == 0) return;
    const std::uint32_t columns = static_cast<std::uint32_t>(level.K.width + 1) / 2, inside = index - grid.first[view];
    const int v = static_cast<int>(inside / columns);
    const int u = 2 * static_cast<int>(inside % columns) + ((v + color) & 1);
    if (u >= level.K.width) return;
    improve({view, u, v}, level);
  }

 private:
  /** \brief Of an area the plane that costs its own pixel least. \returns whether the area is in the image */
  FUSE_FLOW_HD static bool cheapestOf(const StereoLevel& level, int area, int u, int v, InversePlane& plane) {
    const int n = area < kNearAreas ? kNearOffsets : kFarOffsets;
    std::size_t place = 0;
    float cheapest = 2 * kWorstCost;
    for (int k = 0; k < n; ++k) {
      const PixelOffset offset = candidateOffset(area, k);
      const int a = u + offset.u, b = v + offset.v;
      if (a < 0 || b < 0 || a >= level.K.width || b >= level.K.height) continue;
      const std::size_t there = level.indexOf(a, b);
      const float cost = level.cost[there];
      if (cost < cheapest) {
        cheapest = cost;
        place = there;
      }
    }
    if (cheapest > kWorstCost) return false;
    plane = level.plane[place];
    return true;
  }

  FUSE_FLOW_HD void improve(const StereoPixel& at, const StereoLevel& level) const {
    const StereoCandidate candidate = candidateAt(grid, form, at);
    const Ray ray = candidate.ray;
    const std::size_t place = level.indexOf(at.u, at.v);
    InversePlane best = level.plane[place];
    float best_cost = level.cost[place];
    PixelRandom random(seed, at.view, static_cast<std::uint32_t>(place), pass);
    const float step = 1.0f / level.pixels_per_inverse_depth;  // of inverse depth, one pixel
    // One after the other: the planes of eight areas; four random changes, each half as large as the one before; and the depths a quarter
    // of a pixel nearer and farther, through whose costs a parabola goes, to its lowest point.
    constexpr int changes = 4;
    const int attempts = areas + changes + 3;
    constexpr float quarter = 0.25f;
    float nearer_cost = 0, farther_cost = 0, change = reach;
    for (int attempt = 0; attempt < attempts; ++attempt) {
      const float w = inverseDepth(best, ray);
      InversePlane plane;
      if (attempt < areas) {
        if (!cheapestOf(level, attempt, at.u, at.v, plane)) continue;
      } else if (attempt < areas + changes) {
        const int k = attempt - areas;
        const float dw = k == 1 ? 0.0f : change * step * random.next();
        const float slope = k == 0 ? 0.0f : 0.5f * change * w;
        const float x = best.x + slope * random.next(), y = best.y + slope * random.next();
        plane = planeThrough(ray, w + dw, x, y);
        change *= 0.5f;
      } else {
        const int k = attempt - areas - changes;
        float shift = k == 0 ? quarter : -quarter;
        if (k == 2) {
          const float bend = nearer_cost - 2 * best_cost + farther_cost;
          if (!(bend > 1e-6f)) break;
          shift = clampTo(0.5f * (farther_cost - nearer_cost) / bend, -1.0f, 1.0f) * quarter;
        }
        plane = planeThrough(ray, w + shift * step, best.x, best.y);
        if (k < 2) {  // to measure, not to keep
          const float cost = candidate.costOf(plane);
          if (k == 0) {
            nearer_cost = cost;
          } else {
            farther_cost = cost;
          }
          continue;
        }
      }
      if (!candidate.possible(plane)) continue;
      const float cost = candidate.costOf(plane);
      if (cost < best_cost) {
        best_cost = cost;
        best = plane;
      }
    }
    level.plane[place] = best;
    level.cost[place] = best_cost;
  }
};

/** \brief Whether the pattern in the middle of a block repeats itself: whether another depth matches as well in the mean of all views that agree
 *  with the one found, and between both lies one that does not. Without the second, a surface without texture would count. */
struct MarkRepetition {
  StereoGrid grid;  ///< of blocks of kRepetitionBlock² pixels
  StereoForm form;
  int reach;  ///< how far other depths are looked for, pixels in the farthest source
  AgreementLimits agreement{};

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const std::uint32_t view = grid.viewOf(index);
    const StereoLevel& level = grid.levels[view];
    const std::uint32_t block = index - grid.first[view], columns = repetitionBlocks(level.K.width);
    if (level.sources == 0) return;
    const int u = middleOf(block % columns, level.K.width), v = middleOf(block / columns, level.K.height);
    const StereoCandidate candidate = candidateAt(grid, form, {view, u, v});
    level.repeated[block] = isRepeated(candidate, level.plane[level.indexOf(u, v)]) ? 1 : 0;
  }

 private:
  static constexpr float kAsGood = 0.1f;  ///< of the cost: no worse by more …
  /** \brief … of a place that one other view sees: that matches a wrong depth by chance more often than the mean of several. */
  static constexpr float kAsGoodOfOne = 0.03f;
  static constexpr float kAlike = 0.3f;    ///< cost below which windows are alike: others resemble each other by chance
  static constexpr float kBetween = 0.5f;  ///< by how much worse depths between both are

  FUSE_FLOW_HD static int middleOf(std::uint32_t block, int pixels) {
    const int middle = static_cast<int>(block) * kRepetitionBlock + kRepetitionBlock / 2;
    return middle < pixels ? middle : pixels - 1;
  }

  FUSE_FLOW_HD bool isRepeated(const StereoCandidate& candidate, const InversePlane& plane) const {
    const StereoLevel& level = candidate.level;
    const float w = inverseDepth(plane, candidate.ray);
    if (!(w >= level.min_inverse_depth && w <= level.max_inverse_depth)) return false;
    std::uint32_t agreeing = 0;  // a bit for each source
    int count = 0, last = 0;
    for (int k = 0; k < level.sources; ++k)
      if (candidate.agrees(level.source[k], candidate.warpOf(level.source[k], plane), w, agreement)) {
        agreeing |= 1u << static_cast<unsigned int>(k);
        ++count;
        last = k;
      }
    if (agreeing == 0) return false;
    const float found = costOver(candidate, agreeing, plane, 2 * kWorstCost);
    const float as_good = count == 1 && candidate.isSeenByAlone(last) ? kAsGoodOfOne : kAsGood;
    const float alike = found + as_good < kAlike ? found + as_good : kAlike, different = found + kBetween;
    const float step = 1.0f / level.pixels_per_inverse_depth;
    for (const float direction : {step, -step}) {
      bool between = false;
      for (int k = 1; k <= reach; ++k) {
        const float other = w + static_cast<float>(k) * direction;
        if (!(other >= level.min_inverse_depth && other <= level.max_inverse_depth)) break;
        const InversePlane there = planeThrough(candidate.ray, other, plane.x, plane.y);
        const float cost = costOver(candidate, agreeing, there, between ? alike : different);
        if (between && cost < alike) return true;
        between = between || cost > different;
      }
    }
    return false;
  }

  /** \brief Mean over some of the sources. \param limit it may end early with less than the mean if that is over the limit */
  FUSE_FLOW_HD float costOver(const StereoCandidate& candidate, std::uint32_t sources, const InversePlane& plane,
                              float limit) const {
    const StereoLevel& level = candidate.level;
    float sum = 0, count = 0;
    for (int k = 0; k < level.sources; ++k) count += static_cast<float>(sources >> static_cast<unsigned int>(k) & 1u);
    for (int k = 0; k < level.sources && !(sum > limit * count); ++k) {
      if ((sources >> static_cast<unsigned int>(k) & 1u) == 0) continue;
      const StereoSource& source = level.source[k];
      sum += candidate.costIn(source, plane);
    }
    return sum / count;
  }
};

/** \brief Where what was found goes, in the pixels of the colour image. */
struct StereoOutput {
  float* depth;
  float* confidence;
  Vec3* normals;
  RigidTransform T_world_camera;
};

/** \brief Depth, confidence and normal of each pixel of the colour images. */
struct WriteStereoDepth {
  StereoGrid grid;             ///< of the images without distortion
  const std::uint32_t* first;  ///< number of the first pixel of each view's colour image, and of all
  StereoForm form;
  const Intrinsics* lenses;  ///< of the colour images
  const StereoOutput* outputs;
  float edge_step;  ///< see StereoParameters
  bool repetition;  ///< whether MarkRepetition has run
  AgreementLimits agreement{};

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const StereoGrid colors{grid.levels, first, grid.views};
    const std::uint32_t view = colors.viewOf(index);
    const StereoLevel& level = grid.levels[view];
    const Intrinsics& lens = lenses[view];
    const StereoOutput& to = outputs[view];
    const std::uint32_t place = index - first[view], width = static_cast<std::uint32_t>(lens.width);
    const int u = static_cast<int>(place % width), v = static_cast<int>(place / width);
    to.depth[place] = 0;
    to.confidence[place] = 0;
    to.normals[place] = Vec3{};
    if (level.sources == 0) return;
    const Pixel pixel{static_cast<float>(u), static_cast<float>(v)};
    const Ray ray = unproject(lens, pixel);
    if (!reaches(lens, ray, pixel)) return;
    const float x = level.K.fx * ray.x + level.K.cx + 0.5f, y = level.K.fy * ray.y + level.K.cy + 0.5f;
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(level.K.width) && y < static_cast<float>(level.K.height))) return;
    const StereoPixel at{view, static_cast<int>(x), static_cast<int>(y)};
    const InversePlane plane = level.plane[level.indexOf(at.u, at.v)];
    const float w = inverseDepth(plane, ray);
    if (!(w >= level.min_inverse_depth && w <= level.max_inverse_depth)) return;
    StereoCandidate candidate = candidateAt(grid, form, at);
    candidate.ray = ray;
    to.depth[place] = 1.0f / w;
    to.normals[place] = rotate(to.T_world_camera, normalOf(plane));
    to.confidence[place] = confidenceOf(candidate, at, plane, w);
  }

 private:
  /** \brief So near to an end of the depths that are looked for, in pixels of the widest baseline, is found what lies beyond it, by all views
   *  alike: nobody knows its depth. */
  static constexpr float kEndOfRange = 0.5f;

  /** \brief The root of how alike the windows are, halved if only one of several other views that see the place agrees, if the surface ends beside the pixel, or if its
   *  pattern repeats itself; 0 if no view agrees, and at the ends of the range. The root, so that a threshold of a half takes what correlates by a quarter: where two other views agree, most of that is right. */
  FUSE_FLOW_HD float confidenceOf(const StereoCandidate& candidate, const StereoPixel& at, const InversePlane& plane,
                                  float w) const {
    const StereoLevel& level = candidate.level;
    const float end = kEndOfRange / level.pixels_per_inverse_depth;
    if (w - level.min_inverse_depth < end || level.max_inverse_depth - w < end) return 0;
    int agreeing = 0, last = 0;
    for (int k = 0; k < level.sources; ++k) {
      const StereoSource& source = level.source[k];
      if (!candidate.agrees(source, candidate.warpOf(source, plane), w, agreement)) continue;
      ++agreeing;
      last = k;
    }
    if (agreeing == 0) return 0;
    const bool alone = agreeing == 1 && candidate.isSeenByAlone(last);
    const float cost = alone ? candidate.costIn(level.source[last], plane) : candidate.costOf(plane, 0);
    const float likeness = 1.0f - cost;
    if (!(likeness > 0)) return 0;
    const float confidence = std::sqrt(likeness);
    const bool doubtful = (agreeing == 1 && !alone) || isBesideEdge(level, at) || isRepeated(level, at);
    return doubtful ? 0.5f * confidence : confidence;
  }

  FUSE_FLOW_HD bool isRepeated(const StereoLevel& level, const StereoPixel& at) const {
    if (!repetition) return false;
    const std::uint32_t columns = repetitionBlocks(level.K.width);
    return level.repeated[static_cast<std::uint32_t>(at.v / kRepetitionBlock) * columns +
                          static_cast<std::uint32_t>(at.u / kRepetitionBlock)] != 0;
  }

  /** \brief A step of fewer pixels of the widest baseline is noise of the matches: it is a sum of four depths of some 0.25 pixels. */
  static constexpr float kEdgeDisparity = 1.0f;
  static constexpr float kLargestNoise = 0.1f;  ///< of the depth: a larger step is an edge, whatever the baseline

  /** \brief Whether the surface of a pixel ends within half a window, and the pixel looks more as what lies beyond than as the surface. A window
   *  that shows the edge of a surface looks most alike at that surface's depth even where its middle lies beyond the edge: so surfaces grow, in all
   *  views alike, and these agree. */
  FUSE_FLOW_HD bool isBesideEdge(const StereoLevel& level, const StereoPixel& at) const {
    if (!(edge_step > 0)) return false;
    const int reach = kWindowRadius * form.window.spacing;
    const float here = inverseDepthAt(level, at.u, at.v);
    const float of_disparity = kEdgeDisparity / (level.pixels_per_inverse_depth * here);
    const float noise = of_disparity < kLargestNoise ? of_disparity : kLargestNoise;
    const float step = edge_step > noise ? edge_step : noise;
    bool edge = false;
    for (int k = 0; k < 4; ++k) {  // along the row, the column and both diagonals
      const int a = k == 1 ? 0 : reach, b = k == 0 ? 0 : k == 3 ? -reach : reach;
      if (!isInside(level, at.u + a, at.v + b) || !isInside(level, at.u - a, at.v - b)) continue;
      const float one = inverseDepthAt(level, at.u + a, at.v + b), other = inverseDepthAt(level, at.u - a, at.v - b);
      edge = edge || (surfaceEnds(here, one, other, step) && looksAsBeyond(level.image, at, a, b)) ||
             (surfaceEnds(here, other, one, step) && looksAsBeyond(level.image, at, -a, -b));
    }
    return edge;
  }

  /** \brief Whether the grey level of a pixel is nearer to that a columns and b rows away, beyond an edge, than to that of its surface, as far
   *  away on the other side; or as near: what has no texture does not tell. */
  FUSE_FLOW_HD static bool looksAsBeyond(const GreyImage& image, const StereoPixel& at, int a, int b) {
    const int grey = greyAround(image, at.u, at.v);
    const int from_beyond = grey - greyAround(image, at.u + a, at.v + b);
    const int from_surface = grey - greyAround(image, at.u - a, at.v - b);
    return (from_beyond < 0 ? -from_beyond : from_beyond) <= (from_surface < 0 ? -from_surface : from_surface);
  }

  FUSE_FLOW_HD static bool isInside(const StereoLevel& level, int u, int v) {
    return u >= 0 && v >= 0 && u < level.K.width && v < level.K.height;
  }
  FUSE_FLOW_HD static float inverseDepthAt(const StereoLevel& level, int u, int v) {
    return inverseDepth(level.plane[level.indexOf(u, v)], level.ray(u, v));
  }
};

}  // namespace detail
}  // namespace fuse_flow
