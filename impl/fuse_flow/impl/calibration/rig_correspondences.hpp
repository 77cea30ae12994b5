#pragma once

#include <fuse_flow/calibration/extrinsic_parameters.h>
#include <fuse_flow/calibration/extrinsic_result.h>
#include <fuse_flow/math/calibration/correspondence.h>
#include <fuse_flow/precompiled.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief What one camera's points and another camera's images add up to, over all instants. */
struct PairSums {
  std::uint32_t i{0};
  std::uint32_t j{0};
  AlignmentSums geometry{};
  AlignmentSums color{};
  /** \brief Factor of what colour weighs: where grey levels differ by more than they should, for which there are many reasons, by so
   *  much less they tell. (0, 1] */
  double color_trust{1};
};

/** \brief Samples of a view whose correspondences are added up on their own: neighbours in its image. */
constexpr std::size_t kClusterSamples = 512;

/** \brief What the points of a part of one camera's image add up to, of one instant. */
struct AlignmentCluster {
  std::size_t camera{0};
  std::size_t part{0};                         ///< of the image; the same number is about the same part at all instants
  std::vector<AlignmentSums> geometry, color;  ///< neighbour by neighbour
};

/** \brief Where the samples of all views lie. */
struct SceneExtent {
  Eigen::Vector3d center{0, 0, 0};  ///< world, metres
  double radius{1};                 ///< root mean square distance from it, metres
};

/** \brief Of |r| over its standard deviation; 0 if there was none. \param counts of residualBin(), kNoiseBins of them */
inline float medianResidualOf(const std::vector<std::uint32_t>& counts) {
  std::uint64_t total = 0;
  for (const std::uint32_t n : counts) total += n;
  if (total == 0) return 0;
  std::uint64_t before = 0;
  int bin = 0;
  while (2 * (before + counts[static_cast<std::size_t>(bin)]) < total)
    before += counts[static_cast<std::size_t>(bin++)];
  return noiseBinBegin(bin + 1);
}

/** \brief The views of several instants of one rig, wherever they are kept, and what they say about its poses: all that
 *  alignRig() asks. Poses are those of the cameras, one each, camera → a frame that all share. */
class RigCorrespondences {
 public:
  virtual ~RigCorrespondences() = default;

  std::size_t cameras() const { return cameras_; }
  std::size_t instants() const { return instants_; }
  /** \brief Whether any view has colour that may be used. */
  virtual bool hasColor() const = 0;
  /** \brief Median sine of the angle between normals of two cameras, over all instants. */
  double normalNoise(std::size_t i, std::size_t j) const {
    double squares = 0, count = 0;
    for (std::size_t t = 0; t < instants_; ++t)
      for (const std::size_t camera : {i, j})
        if (!missing(t, camera)) {
          squares += std::pow(normalNoiseOf(t, camera), 2);
          ++count;
        }
    return count > 0 ? std::sqrt(squares / count) : 1.0;
  }

  /** \brief Samples of all views, even in their directions in the world. */
  virtual void sample(const std::vector<Eigen::Isometry3d>& poses, int count) = 0;
  /** \brief Of the samples. */
  virtual SceneExtent extent(const std::vector<Eigen::Isometry3d>& poses) = 0;

  /** \brief Of each camera those others that see most of its points, at most max_neighbours. */
  void findNeighbours(const std::vector<Eigen::Isometry3d>& poses, const AlignmentGates& gates, int max_neighbours) {
    std::vector<Seen> seen(cameras_ * cameras_);
    countSeen(poses, gates, seen);
    pairs_.clear();
    begin_.assign(1, 0);
    for (std::uint32_t i = 0; i < cameras_; ++i) {
      for (const std::uint32_t j : mostSeen(seen.data() + i * cameras_, i, max_neighbours))
        pairs_.push_back({i, j, {}, {}});
      begin_.push_back(pairs_.size());
    }
    offsets_.assign(pairs_.size(), 0.0f);
  }

  /** \brief All correspondences at the given poses, camera → scene centre. Levers are over radius. */
  void evaluate(const std::vector<Eigen::Isometry3d>& poses, double radius, const AlignmentGates& gates) {
    residuals_.assign(kNoiseBins, 0);
    for (PairSums& pair : pairs_) pair.geometry = pair.color = AlignmentSums{};
    addUp(poses, static_cast<float>(1 / radius), gates);
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const AlignmentSums& color = pairs_[k].color;
      if (color.w > 0) offsets_[k] += static_cast<float>(color.wr / color.w);
      pairs_[k].color_trust = color.wrr > color.count ? color.count / color.wrr : 1.0;
    }
    median_ = medianResidualOf(residuals_);
  }

  const std::vector<PairSums>& pairs() const { return pairs_; }
  /** \brief What the last evaluate() added up to pairs(), part by part of the images. */
  virtual const std::vector<AlignmentCluster>& clusters() = 0;
  /** \brief The pair that a camera's first neighbour makes with it; those of the others follow, up to that of the next camera. */
  std::size_t firstPair(std::size_t camera) const { return begin_[camera]; }
  /** \brief Of |r| over its standard deviation, in the last evaluate(); 0 if there was none. */
  float medianResidual() const { return median_; }

 protected:
  /** \brief Of one camera's points, those that another camera sees. */
  struct Seen {
    std::size_t count{0};
    std::size_t asked{0};
  };
  /** \brief Every so many-th sample is asked whether another camera sees it. */
  static constexpr std::size_t kSeenStride = 8;

  virtual bool missing(std::size_t instant, std::size_t camera) const = 0;
  virtual float normalNoiseOf(std::size_t instant, std::size_t camera) const = 0;
  /** \brief \param seen by camera i, then camera j */
  virtual void countSeen(const std::vector<Eigen::Isometry3d>& poses, const AlignmentGates& gates,
                         std::vector<Seen>& seen) = 0;
  /** \brief Adds all correspondences to pairs_ and residuals_, which are zero. */
  virtual void addUp(const std::vector<Eigen::Isometry3d>& poses, float per_radius, const AlignmentGates& gates) = 0;

  std::size_t cameras_{0};
  std::size_t instants_{0};
  std::vector<PairSums> pairs_;
  std::vector<std::size_t> begin_;        ///< of each camera's pairs, and the end
  std::vector<float> offsets_;            ///< how much brighter j's image is than i's, pair by pair, grey levels
  std::vector<std::uint32_t> residuals_;  ///< kNoiseBins: see residualBin()

 private:
  std::vector<std::uint32_t> mostSeen(const Seen* seen, std::uint32_t i, int max_neighbours) const {
    std::vector<std::pair<std::size_t, std::uint32_t>> sorted;
    for (std::uint32_t j = 0; j < cameras_; ++j)
      if (j != i && seen[j].count * 100 > seen[j].asked) sorted.emplace_back(seen[j].count, j);
    std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
      return a.first != b.first ? a.first > b.first : a.second < b.second;
    });
    if (sorted.size() > static_cast<std::size_t>(max_neighbours))
      sorted.resize(static_cast<std::size_t>(max_neighbours));
    std::vector<std::uint32_t> neighbours;
    for (const auto& [count, j] : sorted) neighbours.push_back(j);
    std::sort(neighbours.begin(), neighbours.end());
    return neighbours;
  }

  float median_{0};
};

/** \brief The search for the poses of a rig. \param initial where it begins, camera → world, one a camera */
FUSE_FLOW_INLINE ExtrinsicResult alignRig(RigCorrespondences& rig, const ExtrinsicParameters& parameters,
                                          const std::vector<Eigen::Isometry3d>& initial);

}  // namespace host
}  // namespace fuse_flow
