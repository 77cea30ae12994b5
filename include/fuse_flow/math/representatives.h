#pragma once

#include <fuse_flow/math/adaptive_hash.h>
#include <fuse_flow/math/vec3.h>

#include <cfloat>
#include <cstdint>

namespace fuse_flow {

constexpr int kRepresentatives = 3;  // "the top three points"

/** \brief A point in the world frame and its measurement confidence; C = 0: gated, or no measurement. */
struct alignas(16) WeightedPoint {
  Vec3 p{};    ///< metres
  float C{0};  ///< eq. 9; [0, 1]
};

/** \brief One fused point and the measurements it came from. Aligned so that a GPU writes it in three pieces. */
struct alignas(16) FusedPoint {
  Vec3 p{};  ///< world frame, metres
  /** \brief The mean ω of the representatives, weighted with ω itself. */
  float weight{0};
  std::uint32_t source[kRepresentatives]{};  ///< numbers of the representatives' points
  float share[kRepresentatives]{};           ///< of each in eq. 11; they add up to 1
  std::uint32_t count{0};                    ///< of representatives
  /** \brief Different cameras that it is from, see PointCameras; set when the point is written. */
  std::uint32_t views{0};
};

/** \brief The bit of a camera in a mask of 64; cameras from number 64 on have none. */
FUSE_FLOW_HD std::uint64_t cameraBit(std::uint32_t camera) { return camera < 64 ? std::uint64_t{1} << camera : 0; }

/** \brief The cameras that a fused point is from, each once: those of its representatives, and those that measured the surface within σ of
 *  it, see agrees(). \tparam kWithMask whether mask() is asked for, too */
template <bool kWithMask>
class CamerasOfPoint {
 public:
  /** \brief Before the agreeing ones; of up to kRepresentatives, in any order, repeated or not. */
  FUSE_FLOW_HD void addRepresentative(std::uint32_t camera) {
    if (isRepresentative(camera)) return;
    for (std::uint32_t k = 0; k < kRepresentatives; ++k)  // only constants index them: registers on a GPU
      if (k == count_) camera_[k] = camera;
    add(camera);
  }
  /** \brief Each camera at most once; it may be one of the representatives'. */
  FUSE_FLOW_HD void addAgreeing(std::uint32_t camera) {
    if (!isRepresentative(camera)) add(camera);
  }

  /** \brief How many there are. */
  FUSE_FLOW_HD std::uint32_t count() const { return count_; }
  /** \brief A cameraBit() each. */
  FUSE_FLOW_HD std::uint64_t mask() const { return mask_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  FUSE_FLOW_HD bool isRepresentative(std::uint32_t camera) const {
    return (camera == camera_[0]) | (camera == camera_[1]) | (camera == camera_[2]);
  }
  FUSE_FLOW_HD void add(std::uint32_t camera) {
    ++count_;
    if (kWithMask) mask_ |= cameraBit(camera);
  }

  static_assert(kRepresentatives == 3, "as many are compared with");
  std::uint32_t camera_[kRepresentatives] = {kNone, kNone, kNone};
  std::uint32_t count_{0};
  std::uint64_t mask_{0};
};
using PointCameras = CamerasOfPoint<true>;
using PointCameraCount = CamerasOfPoint<false>;

/** \brief A measurement, or the measurements of one camera, that may represent a cell. Left uninitialised: there are hundreds of thousands,
 *  and zeroing them costs more than filling them. */
struct Candidate {
  Vec3 sum;              ///< Σ C p, metres, from the coarse cell's corner; of one point unless CameraMeans
  float sum_C;           ///< Σ C
  float n;               ///< points in the sums
  float best_C;          ///< of the most confident point
  std::uint32_t best;    ///< its number
  std::uint32_t camera;  ///< that they are from
};

/** \brief Highest C first; ties by camera and pixel, which is the order of the indices. */
FUSE_FLOW_HD bool outranks(const Candidate& a, const Candidate& b) {
  return a.sum_C != b.sum_C ? a.sum_C > b.sum_C : a.best < b.best;
}

/** \brief Section 5 (2) a: the representatives of one child cell, while its points come in. Only constants index the
 *  candidates, so that a GPU can hold them in registers. */
class RepresentativeSelection {
 public:
  /** \brief Points come in the order of their indices, camera after camera. */
  FUSE_FLOW_HD void add(Representatives mode, const Vec3& relative, float C, std::uint32_t index,
                        std::uint32_t camera) {
    if (mode != Representatives::HighestConfidence && started_ && last_.camera == camera) {
      if (mode == Representatives::CameraMeans) {
        last_.sum = last_.sum + C * relative;
        last_.sum_C += C;
        last_.n += 1.0f;
        if (C > last_.best_C) {
          last_.best_C = C;
          last_.best = index;
        }
      } else if (C > last_.best_C) {
        last_ = {C * relative, C, 1.0f, C, index, camera};
      }
      return;
    }
    if (started_) keepLast();
    started_ = true;
    last_ = {C * relative, C, 1.0f, C, index, camera};
  }

  /** \brief After the last point. */
  FUSE_FLOW_HD void finish() { keepLast(); }

  /** \brief How many representatives there are; up to kRepresentatives. */
  FUSE_FLOW_HD int count() const { return count_; }
  /** \brief One of them, in no order. */
  FUSE_FLOW_HD Candidate operator[](int k) const {
    Candidate candidate = kept_[0];
    if (k == 1) candidate = kept_[1];
    if (k == 2) candidate = kept_[2];
    return candidate;
  }

  /** \brief Number of the highest-ranking one. */
  FUSE_FLOW_HD int main() const {
    int best = 0;
    if (count_ > 1 && outranks(kept_[1], kept_[0])) best = 1;
    if (count_ > 2 && outranks(kept_[2], (*this)[best])) best = 2;
    return best;
  }
  /** \brief Its camera. */
  FUSE_FLOW_HD std::uint32_t mainCamera() const { return (*this)[main()].camera; }

  /** \brief Their confidence-weighted mean, from the coarse cell's corner. */
  FUSE_FLOW_HD Vec3 mean() const {
    Vec3 sum{};
    float sum_C = 0;
    for (int k = 0; k < kRepresentatives; ++k) {
      if (k >= count_) continue;  // not break: compilers then unroll
      sum = sum + kept_[k].sum;
      sum_C += kept_[k].sum_C;
    }
    return (1.0f / sum_C) * sum;
  }

 private:
  /** \brief A camera's sum is only known when its last point is in: then it takes the place of the lowest-ranking one,
   *  unless it ranks lowest itself. */
  FUSE_FLOW_HD void keepLast() {
    if (count_ == 0) {
      kept_[0] = last_;
    } else if (count_ == 1) {
      kept_[1] = last_;
    } else if (count_ == 2) {
      kept_[2] = last_;
    } else if (outranks(kept_[0], kept_[1]) && outranks(kept_[2], kept_[1])) {
      if (outranks(last_, kept_[1])) kept_[1] = last_;
    } else if (outranks(kept_[1], kept_[0]) && outranks(kept_[2], kept_[0])) {
      if (outranks(last_, kept_[0])) kept_[0] = last_;
    } else {
      if (outranks(last_, kept_[2])) kept_[2] = last_;
    }
    if (count_ < kRepresentatives) ++count_;
  }

  Candidate kept_[kRepresentatives];
  Candidate last_;
  int count_{0};
  bool started_{false};
};

/** \brief Section 5 (2) c and (3) for one child. \param V its representatives' consistency; null: 1. If all have the same V, it does not
 *  change the position of the point; it then multiplies the weight of the point. */
FUSE_FLOW_HD FusedPoint fuseRepresentatives(const RepresentativeSelection& chosen, const Vec3& corner, const float* V) {
  // The values are copied into the point at the end, one by one: processors wait if memory is written in units of four bytes and read in
  // units of sixteen.
  Vec3 sum{};
  float total = 0, sum_weights = 0;
  std::uint32_t source[kRepresentatives]{};
  float share[kRepresentatives]{};
  for (int k = 0; k < kRepresentatives; ++k) {
    if (k >= chosen.count()) continue;  // not break: compilers then unroll
    const Candidate c = chosen[k];
    const float v = V == nullptr ? 1.0f : V[k];
    share[k] = c.sum_C * v;  // eq. 10; n measurements weigh n times one
    sum = sum + v * c.sum;   // eq. 11: share times the mean
    total += share[k];
    sum_weights += share[k] * (share[k] / c.n);
    source[k] = c.best;
  }
  const bool any = total > FLT_MIN;  // else every view contradicts: weight stays 0
  FusedPoint fused;
  if (any) fused.p = corner + (1.0f / total) * sum;
  fused.weight = any ? sum_weights / total : 0.0f;
  for (int k = 0; k < kRepresentatives; ++k) {
    fused.source[k] = source[k];
    fused.share[k] = any ? share[k] / total : share[k];
  }
  fused.count = static_cast<std::uint32_t>(chosen.count());
  return fused;
}

/** \brief Point-wise fusion, for the ablation: fuses one point with the points of other views at the same place. All of them contribute to
 *  its position and weight. The three with the most weight give its colour and normal. */
class PointWiseFusion {
 public:
  /** \param own the point, world frame, metres: what sums are relative to */
  FUSE_FLOW_HD explicit PointWiseFusion(const Vec3& own) : own_(own) {}

  /** \brief Adds a point; the own point must be added too. \param source its number  \param p world frame, metres
   *  \param weight ω of eq. 10 */
  FUSE_FLOW_HD void add(std::uint32_t source, const Vec3& p, float weight) {
    sum_ = sum_ + weight * (p - own_);
    total_ += weight;
    squares_ += weight * weight;
    ++fused_.views;
    if (fused_.count < kRepresentatives) {
      put(fused_.count++, source, weight);
      return;
    }
    std::uint32_t lightest = 0;
    float least = fused_.share[0];
    for (std::uint32_t k = 1; k < kRepresentatives; ++k) {
      if (!(fused_.share[k] < least)) continue;
      lightest = k;
      least = fused_.share[k];
    }
    if (weight > least) put(lightest, source, weight);
  }

  /** \brief Eq. 11 over all added points; the weight is 0 if all their weights are 0. */
  FUSE_FLOW_HD FusedPoint finish() const {
    FusedPoint fused = fused_;
    if (!(total_ > FLT_MIN)) return fused;
    fused.p = own_ + (1.0f / total_) * sum_;
    fused.weight = squares_ / total_;
    float kept = 0;
    for (int k = 0; k < kRepresentatives; ++k)
      if (k < static_cast<int>(fused.count)) kept += fused.share[k];
    for (float& share : fused.share) share /= kept;
    return fused;
  }

 private:
  /** \brief Only constants index the sources, as in RepresentativeSelection. */
  FUSE_FLOW_HD void put(std::uint32_t place, std::uint32_t source, float weight) {
    for (std::uint32_t k = 0; k < kRepresentatives; ++k) {
      if (k != place) continue;  // not break: compilers then unroll
      fused_.source[k] = source;
      fused_.share[k] = weight;
    }
  }

  Vec3 own_;
  Vec3 sum_{};
  float total_{0};
  float squares_{0};
  FusedPoint fused_;
};

}  // namespace fuse_flow
