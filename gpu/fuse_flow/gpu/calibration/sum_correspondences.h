#pragma once

#include <fuse_flow/gpu/runtime/system.h>
#include <fuse_flow/math/calibration/correspondence.h>

namespace fuse_flow {
namespace gpu {

/** \brief Samples that are neighbours in one view, and another camera's view of the same instant. Views are numbered instant by
 *  instant, within them camera by camera. */
struct ClusterPair {
  std::uint32_t view;
  std::uint32_t other;
  std::uint32_t begin, end;  ///< of the samples
  std::uint32_t pair;        ///< of cameras
};

/** \brief What the correspondences of one cluster with one other view add up to, in the order of the samples. */
struct SumCorrespondences {
  const ClusterPair* clusters;
  const BlockImage* images;  // view by view
  const AlignmentSample* samples;
  const CameraPlace* places;  // camera by camera
  const float* offsets;       // of grey levels, pair by pair
  std::uint32_t cameras;
  AlignmentGates gates;
  float per_radius;
  AlignmentSums* sums;       // of each cluster: geometry, then colour
  std::uint32_t* residuals;  // kNoiseBins

  /** \brief What one sample adds. */
  struct Found {
    bool matches{false}, colored{false};
    int bin{0};
    Correspondence geometry, color;
  };
  FUSE_FLOW_HD Found find(const ClusterPair& cluster, const AlignmentSample& sample) const {
    Found found;
    const BlockImage& other = images[cluster.other];
    const CameraPlace &i = places[cluster.view % cameras], &j = places[cluster.other % cameras];
    Match match;
    found.matches = findMatch(i, j, other, sample, gates, match);
    if (!found.matches) return found;
    found.bin = residualBin(match.r, match.per_sigma);
    found.geometry = geometryOf(match, gates, per_radius);
    found.colored = gates.color && found.geometry.w > 0 &&
                    colorOf(i, j, other, sample, match, found.geometry.x, offsets[cluster.pair], gates, found.color);
    return found;
  }

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const ClusterPair& cluster = clusters[k];
    AlignmentSums geometry{}, color{};
    const auto stride = static_cast<std::uint32_t>(gates.stride);
    for (std::uint32_t s = cluster.begin; s < cluster.end; s += stride) {
      const Found found = find(cluster, samples[s]);
      if (!found.matches) continue;
      atomicAddTo(residuals + found.bin, 1u);
      addCorrespondence(geometry, found.geometry.x, found.geometry.n, found.geometry.r, found.geometry.w);
      if (found.colored)
        addCorrespondence(color, found.color.x, found.color.n, found.color.own, found.color.r, found.color.w);
    }
    sums[2 * k] = geometry;
    sums[2 * k + 1] = color;
  }
};

/** \brief AlignmentSums as an array. */
constexpr std::uint32_t kAlignmentSums = 88;
static_assert(sizeof(AlignmentSums) == kAlignmentSums * sizeof(double), "sums and nothing else");

/** \brief What clusters add up to: one sum of one pair of cameras, always in the same order; and the histogram of residuals, handed
 *  on. */
struct SumPairs {
  const std::uint32_t* begins;  // of each pair's clusters, and the end
  const AlignmentSums* sums;
  std::uint32_t pairs;
  const std::uint32_t* residuals;
  AlignmentSums* pair_sums;  // of each pair: geometry, then colour; in memory that the host reads
  std::uint32_t* pair_residuals;

  FUSE_FLOW_HD std::uint32_t steps() const { return pairs * 2 * kAlignmentSums + kNoiseBins; }

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t pair = k / (2 * kAlignmentSums), number = k - pair * 2 * kAlignmentSums;
    if (pair >= pairs) {
      const std::uint32_t bin = k - pairs * 2 * kAlignmentSums;
      pair_residuals[bin] = residuals[bin];
      return;
    }
    double sum = 0;
    for (std::uint32_t c = begins[pair]; c < begins[pair + 1]; ++c)
      sum += reinterpret_cast<const double*>(sums + 2 * c)[number];
    reinterpret_cast<double*>(pair_sums + 2 * pair)[number] = sum;
  }
};

/** \brief How many of a camera's samples another one sees; one sample and one other camera a step. */
struct CountSeen {
  const BlockImage* images;
  const AlignmentSample* samples;
  const std::uint32_t* begins;  // of each view's samples, and the end
  const CameraPlace* places;
  AlignmentGates gates;
  std::uint32_t first_view;  // of the instant
  std::uint32_t cameras;
  std::uint32_t asked;  // of a view, at most
  std::uint32_t stride;
  std::uint32_t* counts;  // by camera, then other camera

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t pair = k / asked, i = pair / cameras, j = pair - i * cameras;
    const std::uint32_t sample = begins[first_view + i] + (k - pair * asked) * stride;
    if (i == j || sample >= begins[first_view + i + 1]) return;
    Match match;
    if (findMatch(places[i], places[j], images[first_view + j], samples[sample], gates, match))
      atomicAddTo(counts + pair, 1u);
  }
};

}  // namespace gpu
}  // namespace fuse_flow
