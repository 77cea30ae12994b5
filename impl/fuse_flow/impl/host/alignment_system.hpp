#pragma once

#include <fuse_flow/impl/host/alignment_view.hpp>
#include <fuse_flow/impl/host/normal_space_sampling.hpp>
#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/math/alignment.h>

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief A point that looks for its counterparts in other views; its camera's frame. */
struct AlignmentSample {
  Vec3 p;
  Vec3 n;
  float noise;                                     ///< along the normal, metres
  std::array<float, AlignmentView::kScales> luma;  ///< the finest scale first; negative: none
};

/** \brief Which correspondences count, and how much. */
struct AlignmentGates {
  float distance;       ///< metres
  float normal_cosine;  ///< of the largest angle between normals
  float tukey;          ///< c of tukeyWeight(), in standard deviations …
  float reach;        ///< … but at least this, metres: what is well aligned already must not cast out what is not yet
  float color_tukey;  ///< the same for colour, grey levels
  bool color;         ///< whether colour is compared …
  std::size_t scale;  ///< … and at which of AlignmentView's scales
  std::size_t stride;  ///< every so many-th sample is asked
};

/** \brief What one camera's points and another camera's images add up to, over all instants. */
struct PairSums {
  std::uint32_t i{0};
  std::uint32_t j{0};
  AlignmentSums geometry{};
  AlignmentSums color{};
};

/** \brief What the points of a part of one camera's image add up to, of one instant. */
struct AlignmentCluster {
  std::size_t camera{0};
  std::size_t part{0};                         ///< of the image; the same number is about the same part at all instants
  std::vector<AlignmentSums> geometry, color;  ///< neighbour by neighbour
};

/** \brief The views of several instants of one rig, and what they say about its poses. */
class AlignmentSystem {
 public:
  explicit AlignmentSystem(int threads = 1) : threads_(threads) {}
  void setThreads(int threads) { threads_ = threads; }

  std::size_t cameras() const { return cameras_; }
  std::size_t instants() const { return instants_; }
  const AlignmentView& view(std::size_t instant, std::size_t camera) const {
    return views_[instant * cameras_ + camera];
  }

  /** \brief Whether any view has colour that may be used. */
  bool hasColor() const {
    for (std::size_t k = 0; k < instants_ * cameras_; ++k)
      if (!views_[k].missing() && views_[k].hasColor()) return true;
    return false;
  }

  void clear() { instants_ = cameras_ = 0; }

  /** \brief One instant more; the buffers of earlier ones are used again after clear(). */
  void add(const RigFrame& frame, const ExtrinsicParameters& p) {
    cameras_ = frame.cameras.size();
    rig_.update(frame.cameras);
    if (views_.size() < (instants_ + 1) * cameras_) views_.resize((instants_ + 1) * cameras_);
    AlignmentView* views = views_.data() + instants_ * cameras_;
    parallelFor(threads_, cameras_, [&](std::size_t i, int) {
      if (frame.views[i].missing()) {
        views[i].clear();
      } else {
        views[i].assign(rig_[i], frame.views[i], p);
      }
    });
    ++instants_;
  }

  /** \brief Samples of all views, even in their directions in the world. */
  void sample(const std::vector<Eigen::Isometry3d>& poses, int count) {
    samples_.resize(instants_ * cameras_);
    parallelFor(threads_, samples_.size(), [&](std::size_t k, int) {
      sampleView(views_[k], toRigidTransform(poses[k % cameras_]), count, samples_[k]);
    });
  }
  const std::vector<AlignmentSample>& samples(std::size_t instant, std::size_t camera) const {
    return samples_[instant * cameras_ + camera];
  }

  /** \brief Of each camera those others that see most of its points, at most max_neighbours; asked of every stride-th point. */
  void findNeighbours(const std::vector<Eigen::Isometry3d>& poses, const AlignmentGates& gates, int max_neighbours) {
    constexpr std::size_t stride = 8;
    place(poses);
    neighbours_.assign(cameras_, {});
    parallelFor(threads_, cameras_, [&](std::size_t i, int) {
      std::vector<std::pair<std::size_t, std::uint32_t>> seen;
      std::size_t asked = 0;
      for (std::uint32_t j = 0; j < cameras_; ++j) {
        if (j == i) continue;
        std::size_t count = 0;
        asked = 0;
        for (std::size_t t = 0; t < instants_; ++t) {
          const std::vector<AlignmentSample>& all = samples(t, i);
          if (view(t, j).missing()) continue;
          for (std::size_t k = 0; k < all.size(); k += stride) {
            ++asked;
            Match match;
            count += find(t, i, j, all[k], gates, match) ? 1 : 0;
          }
        }
        if (count * 100 > asked) seen.emplace_back(count, j);
      }
      std::sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) {
        return a.first != b.first ? a.first > b.first : a.second < b.second;
      });
      if (seen.size() > static_cast<std::size_t>(max_neighbours)) seen.resize(static_cast<std::size_t>(max_neighbours));
      for (const auto& [count, j] : seen) neighbours_[i].push_back(j);
      std::sort(neighbours_[i].begin(), neighbours_[i].end());
    });
    pairs_.clear();
    begin_.assign(1, 0);
    for (std::uint32_t i = 0; i < cameras_; ++i) {
      for (const std::uint32_t j : neighbours_[i]) pairs_.push_back({i, j, {}, {}});
      begin_.push_back(pairs_.size());
    }
    offsets_.assign(pairs_.size(), 0.0f);
  }

  /** \brief All correspondences at the given poses, camera → scene centre, and the median of their residuals in standard
   *  deviations. Levers are over radius. */
  void evaluate(const std::vector<Eigen::Isometry3d>& poses, double radius, const AlignmentGates& gates) {
    place(poses);
    constexpr std::size_t chunk = 512;
    struct Task {
      std::size_t instant, camera, begin;
    };
    std::vector<Task> tasks;
    for (std::size_t t = 0; t < instants_; ++t)
      for (std::size_t i = 0; i < cameras_; ++i)
        for (std::size_t k = 0; k < samples(t, i).size(); k += chunk) tasks.push_back({t, i, k});
    std::vector<std::vector<std::uint32_t>> histograms(tasks.size());
    clusters_.resize(tasks.size());
    const float per_radius = static_cast<float>(1 / radius);
    parallelFor(threads_, tasks.size(), [&](std::size_t k, int) {
      const Task& task = tasks[k];
      const std::vector<AlignmentSample>& all = samples(task.instant, task.camera);
      const std::size_t end = std::min(all.size(), task.begin + chunk);
      const std::vector<std::uint32_t>& neighbours = neighbours_[task.camera];
      AlignmentCluster& out = clusters_[k];
      out.camera = task.camera;
      out.part = task.begin / chunk;
      out.geometry.assign(neighbours.size(), AlignmentSums{});
      out.color.assign(neighbours.size(), AlignmentSums{});
      std::vector<std::uint32_t>& histogram = histograms[k];
      histogram.assign(kNoiseBins, 0);
      for (std::size_t slot = 0; slot < neighbours.size(); ++slot) {
        const float offset = offsets_[begin_[task.camera] + slot];
        if (view(task.instant, neighbours[slot]).missing()) continue;
        for (std::size_t s = task.begin; s < end; s += gates.stride) {
          Match match;
          if (!find(task.instant, task.camera, neighbours[slot], all[s], gates, match)) continue;
          ++histogram[static_cast<std::size_t>(noiseBin(std::fabs(match.r) * match.per_sigma))];
          const float w = tukeyWeight(match.r, std::max(gates.tukey / match.per_sigma, gates.reach)) * match.per_sigma *
                          match.per_sigma;
          const Vec3 x = per_radius * match.x;
          addCorrespondence(out.geometry[slot], x, match.n, match.r, w);
          if (gates.color && w > 0)
            addColor(task.instant, neighbours[slot], all[s], match, x, offset, gates, out.color[slot]);
        }
      }
    });
    for (PairSums& pair : pairs_) pair.geometry = pair.color = AlignmentSums{};
    std::vector<std::uint32_t> counts(kNoiseBins, 0);
    for (std::size_t k = 0; k < tasks.size(); ++k) {
      for (std::size_t slot = 0; slot < clusters_[k].geometry.size(); ++slot) {
        pairs_[begin_[tasks[k].camera] + slot].geometry += clusters_[k].geometry[slot];
        pairs_[begin_[tasks[k].camera] + slot].color += clusters_[k].color[slot];
      }
      for (std::size_t b = 0; b < counts.size(); ++b) counts[b] += histograms[k][b];
    }
    for (std::size_t k = 0; k < pairs_.size(); ++k)
      if (pairs_[k].color.w > 0) offsets_[k] += static_cast<float>(pairs_[k].color.wr / pairs_[k].color.w);
    median_ = median(counts);
  }

  const std::vector<PairSums>& pairs() const { return pairs_; }
  /** \brief What the last evaluate() added up to pairs(), part by part of the images. */
  const std::vector<AlignmentCluster>& clusters() const { return clusters_; }
  /** \brief The pair that a camera's first neighbour makes with it; those of the others follow. */
  std::size_t firstPair(std::size_t camera) const { return begin_[camera]; }
  /** \brief Of |r| over its standard deviation, in the last evaluate(); 0 if there was none. */
  float medianResidual() const { return median_; }

 private:
  /** \brief A point and its counterpart in another view. */
  struct Match {
    Vec3 x;           ///< the point, world
    Vec3 q;           ///< the same, other camera's frame
    Vec3 n;           ///< normal at the counterpart, world
    float r;          ///< residual, metres
    float per_sigma;  ///< over the standard deviation that noise gives it, 1/metres
    int u, v;         ///< block of the counterpart
  };

  static void sampleView(const AlignmentView& view, const RigidTransform& T, int count,
                         std::vector<AlignmentSample>& out) {
    out.clear();
    if (view.missing()) return;
    NormalSpaceSampling bins;
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        if (squaredNorm(view.normal(u, v)) > 0)
          bins.add(rotate(T, view.normal(u, v)), static_cast<std::uint32_t>(view.index(u, v)));
    std::vector<std::uint32_t> chosen;
    bins.choose(static_cast<std::size_t>(count), chosen);
    // Neighbours in the image become neighbours in the list, so that a stretch of it is a part of the image.
    const auto along = [&](std::uint32_t index) {
      return mortonCode(index % static_cast<std::uint32_t>(view.width()),
                        index / static_cast<std::uint32_t>(view.width()));
    };
    std::sort(chosen.begin(), chosen.end(), [&](std::uint32_t a, std::uint32_t b) { return along(a) < along(b); });
    for (const std::uint32_t index : chosen) {
      const int u = static_cast<int>(index) % view.width(), v = static_cast<int>(index) / view.width();
      out.push_back({view.point(u, v), view.normal(u, v), view.noise(u, v), {}});
      for (std::size_t scale = 0; scale < AlignmentView::kScales; ++scale)
        out.back().luma[scale] = view.hasColor() ? view.luma(u, v, scale) : -1.0f;
    }
  }

  /** \brief Place of a pixel along a curve through all squares, within them through all of their quarters, and so on. */
  static std::uint32_t mortonCode(std::uint32_t u, std::uint32_t v) {
    const auto spread = [](std::uint32_t x) {
      x = (x | x << 8) & 0x00ff00ffu;
      x = (x | x << 4) & 0x0f0f0f0fu;
      x = (x | x << 2) & 0x33333333u;
      return (x | x << 1) & 0x55555555u;
    };
    return spread(u) | spread(v) << 1;
  }

  void place(const std::vector<Eigen::Isometry3d>& poses) {
    to_world_.resize(cameras_);
    to_camera_.resize(cameras_);
    for (std::size_t i = 0; i < cameras_; ++i) {
      to_world_[i] = toRigidTransform(poses[i]);
      to_camera_[i] = toRigidTransform(poses[i].inverse());
    }
  }

  bool find(std::size_t instant, std::size_t i, std::size_t j, const AlignmentSample& sample,
            const AlignmentGates& gates, Match& match) const {
    const AlignmentView& other = view(instant, j);
    match.x = to_world_[i] * sample.p;
    match.q = to_camera_[j] * match.x;
    if (other.missing() || !other.locate(match.q, match.u, match.v)) return false;
    const Vec3& n = other.normal(match.u, match.v);
    if (!(squaredNorm(n) > 0)) return false;
    const Vec3 e = match.q - other.point(match.u, match.v);
    if (!(squaredNorm(e) < gates.distance * gates.distance)) return false;
    match.n = rotate(to_world_[j], n);
    if (!(dot(match.n, rotate(to_world_[i], sample.n)) > gates.normal_cosine)) return false;
    const float noise = other.noise(match.u, match.v);
    match.r = dot(n, e);
    match.per_sigma = 1.0f / std::sqrt(sample.noise * sample.noise + noise * noise + kFloor * kFloor);
    return true;
  }

  /** \brief The difference of grey levels at a match, and how it changes as the point moves over the other image. */
  void addColor(std::size_t instant, std::size_t j, const AlignmentSample& sample, const Match& match, const Vec3& x,
                float offset, const AlignmentGates& gates, AlignmentSums& sums) const {
    const AlignmentView& other = view(instant, j);
    if (!other.hasColor() || sample.luma[0] < 0) return;
    const int u = match.u, v = match.v;
    if (u < 1 || v < 1 || u + 1 >= other.width() || v + 1 >= other.height()) return;
    const std::size_t scale = gates.scale;
    const float left = other.luma(u - 1, v, scale), right = other.luma(u + 1, v, scale),
                above = other.luma(u, v - 1, scale), below = other.luma(u, v + 1, scale),
                here = other.luma(u, v, scale);
    if (left < 0 || right < 0 || above < 0 || below < 0 || here < 0) return;
    const float du = 0.5f * (right - left), dv = 0.5f * (below - above);
    const Intrinsics& K = other.geometry().intrinsics;
    const Pixel pixel = project(K, match.q);
    const float per_block = 1.0f / static_cast<float>(other.reduction());
    const float a = (pixel.u + 0.5f) * per_block - 0.5f - static_cast<float>(u);
    const float b = (pixel.v + 0.5f) * per_block - 0.5f - static_cast<float>(v);
    const float r = here + a * du + b * dv - sample.luma[scale] - offset;
    const float gu = du * per_block * K.fx / match.q.z, gv = dv * per_block * K.fy / match.q.z;
    const Vec3 gradient{gu, gv, -(gu * match.q.x + gv * match.q.y) / match.q.z};
    const float w = tukeyWeight(r, gates.color_tukey) / (kGreyNoise * kGreyNoise);
    addCorrespondence(sums, x, rotate(to_world_[j], gradient), r, w);
  }

  static float median(const std::vector<std::uint32_t>& counts) {
    std::uint64_t total = 0;
    for (const std::uint32_t n : counts) total += n;
    if (total == 0) return 0;
    std::uint64_t before = 0;
    int bin = 0;
    while (2 * (before + counts[static_cast<std::size_t>(bin)]) < total)
      before += counts[static_cast<std::size_t>(bin++)];
    return noiseBinBegin(bin + 1);
  }

  /** \brief What rounding to blocks leaves even of an exact measurement, metres. */
  static constexpr float kFloor = 0.0005f;
  /** \brief Standard deviation of a block's grey level, as two cameras see it. */
  static constexpr float kGreyNoise = 8.0f;

  int threads_{1};
  std::size_t cameras_{0};
  std::size_t instants_{0};
  RigGeometry rig_;
  std::vector<AlignmentView> views_;
  std::vector<std::vector<AlignmentSample>> samples_;
  std::vector<std::vector<std::uint32_t>> neighbours_;
  std::vector<PairSums> pairs_;
  std::vector<AlignmentCluster> clusters_;
  std::vector<float> offsets_;  ///< how much brighter j's image is than i's, pair by pair, grey levels
  std::vector<std::size_t> begin_;
  std::vector<RigidTransform> to_world_, to_camera_;
  float median_{0};
};

}  // namespace host
}  // namespace fuse_flow
