#pragma once

#include <fuse_flow/impl/calibration/alignment_view.hpp>
#include <fuse_flow/impl/calibration/normal_space_sampling.hpp>
#include <fuse_flow/impl/calibration/rig_correspondences.hpp>
#include <fuse_flow/impl/calibration/sample_projections.hpp>
#include <fuse_flow/impl/host/parallel.hpp>

#include <vector>

namespace fuse_flow {
namespace host {

/** \brief The views of several instants of one rig in host memory. */
class AlignmentSystem : public RigCorrespondences {
 public:
  explicit AlignmentSystem(int threads = 1) : threads_(threads) {}
  void setThreads(int threads) { threads_ = threads; }

  const AlignmentView& view(std::size_t instant, std::size_t camera) const {
    return views_[instant * cameras_ + camera];
  }

  bool hasColor() const override {
    for (std::size_t k = 0; k < instants_ * cameras_; ++k)
      if (!views_[k].missing() && views_[k].hasColor()) return true;
    return false;
  }

  void clear() { instants_ = cameras_ = 0; }

  /** \brief One instant more; the buffers of earlier ones are used again after clear(). */
  void add(const RigFrame& frame, const ExtrinsicParameters& p) {
    cameras_ = frame.cameras.size();
    rig_.update(frame);
    if (views_.size() < (instants_ + 1) * cameras_) views_.resize((instants_ + 1) * cameras_);
    AlignmentView* views = views_.data() + instants_ * cameras_;
    noise_.resize(cameras_);
    for (std::size_t i = 0; i < cameras_; ++i) noise_[i] = rig_[i].noise.value_or(p.noise);
    parallelFor(threads_, cameras_, [&](std::size_t i, int) {
      if (frame.views[i].missing()) {
        views[i].clear();
      } else {
        views[i].assign(rig_[i], frame.views[i], p);
      }
    });
    ++instants_;
  }

  void sample(const std::vector<Eigen::Isometry3d>& poses, int count) override {
    samples_.resize(instants_ * cameras_);
    parallelFor(threads_, samples_.size(), [&](std::size_t k, int) {
      sampleView(views_[k], toRigidTransform(poses[k % cameras_]), count, samples_[k]);
    });
  }
  const std::vector<AlignmentSample>& samples(std::size_t instant, std::size_t camera) const {
    return samples_[instant * cameras_ + camera];
  }

  SceneExtent extent(const std::vector<Eigen::Isometry3d>& poses) override {
    SceneExtent result;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double squares = 0, count = 0;
    const auto forEach = [&](auto&& visit) {
      for (std::size_t t = 0; t < instants_; ++t)
        for (std::size_t i = 0; i < cameras_; ++i)
          for (const AlignmentSample& s : samples(t, i)) visit(poses[i] * Eigen::Vector3d(s.p.x, s.p.y, s.p.z));
    };
    forEach([&](const Eigen::Vector3d& x) {
      sum += x;
      count += 1;
    });
    if (count > 0) {
      result.center = sum / count;
      forEach([&](const Eigen::Vector3d& x) { squares += (x - result.center).squaredNorm(); });
      result.radius = std::max(1e-3, std::sqrt(squares / count));
    }
    return result;
  }

  const std::vector<AlignmentCluster>& clusters() override { return clusters_; }

 protected:
  bool missing(std::size_t instant, std::size_t camera) const override { return view(instant, camera).missing(); }
  float normalNoiseOf(std::size_t instant, std::size_t camera) const override {
    return view(instant, camera).normalNoise();
  }

  /** \brief Of all views, one instant after the other; empty where there is none. */
  std::vector<std::vector<AlignmentSample>>& allSamples() { return samples_; }
  std::vector<AlignmentCluster>& allClusters() { return clusters_; }

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
    // So that a stretch of the list is a part of the image.
    const auto along = [&](std::uint32_t index) {
      return mortonCode(index % static_cast<std::uint32_t>(view.width()),
                        index / static_cast<std::uint32_t>(view.width()));
    };
    std::sort(chosen.begin(), chosen.end(), [&](std::uint32_t a, std::uint32_t b) { return along(a) < along(b); });
    for (const std::uint32_t index : chosen) {
      const int u = static_cast<int>(index) % view.width(), v = static_cast<int>(index) / view.width();
      out.push_back(sampleOf(view.image(), u, v));
    }
  }

  void countSeen(const std::vector<Eigen::Isometry3d>& poses, const AlignmentGates& gates,
                 std::vector<Seen>& seen) override {
    place(poses);
    parallelFor(threads_, seen.size(), [&](std::size_t k, int) {
      const std::size_t i = k / cameras_, j = k % cameras_;
      if (i == j) return;
      for (std::size_t t = 0; t < instants_; ++t) {
        if (view(t, j).missing()) continue;
        const std::vector<AlignmentSample>& all = samples(t, i);
        for (std::size_t s = 0; s < all.size(); s += kSeenStride) {
          Match match;
          ++seen[k].asked;
          seen[k].count += findMatch(places_[i], places_[j], view(t, j).image(), all[s], gates, match) ? 1 : 0;
        }
      }
    });
  }

  void addUp(const std::vector<Eigen::Isometry3d>& poses, float per_radius, const AlignmentGates& gates) override {
    place(poses);
    struct Task {
      std::size_t instant, camera, begin;
    };
    std::vector<Task> tasks;
    for (std::size_t t = 0; t < instants_; ++t)
      for (std::size_t i = 0; i < cameras_; ++i)
        for (std::size_t k = 0; k < samples(t, i).size(); k += kClusterSamples) tasks.push_back({t, i, k});
    std::vector<std::vector<std::uint32_t>> histograms(tasks.size());
    clusters_.resize(tasks.size());
    if (projections_.size() < static_cast<std::size_t>(threads_))
      projections_.resize(static_cast<std::size_t>(threads_));
    parallelFor(threads_, tasks.size(), [&](std::size_t k, int thread) {
      const Task& task = tasks[k];
      const std::vector<AlignmentSample>& all = samples(task.instant, task.camera);
      const std::size_t end = std::min(all.size(), task.begin + kClusterSamples);
      const std::size_t first = firstPair(task.camera), neighbours = firstPair(task.camera + 1) - first;
      AlignmentCluster& out = clusters_[k];
      out.camera = task.camera;
      out.part = task.begin / kClusterSamples;
      out.geometry.assign(neighbours, AlignmentSums{});
      out.color.assign(neighbours, AlignmentSums{});
      std::vector<std::uint32_t>& histogram = histograms[k];
      histogram.assign(kNoiseBins, 0);
      const CameraPlace& place_i = places_[task.camera];
      SampleProjections& projections = projections_[static_cast<std::size_t>(thread)];
      projections.assign(place_i.to_world, all, task.begin, end, gates.stride);
      for (std::size_t slot = 0; slot < neighbours; ++slot) {
        const std::size_t j = pairs_[first + slot].j;
        const BlockImage& other = view(task.instant, j).image();
        if (other.missing()) continue;
        projections.project(places_[j].to_camera, other);
        for (std::size_t n = 0; n < projections.size(); ++n) {
          const std::size_t s = task.begin + n * gates.stride;
          Match match;
          if (!projections.inside(n, match) || !isMatch(place_i, places_[j], other, all[s], gates, match)) continue;
          ++histogram[static_cast<std::size_t>(residualBin(match.r, match.per_sigma))];
          const Correspondence geometry = geometryOf(match, gates, per_radius);
          addCorrespondence(out.geometry[slot], geometry.x, geometry.n, geometry.r, geometry.w);
          Correspondence color;
          if (gates.color && geometry.w > 0 &&
              colorOf(place_i, places_[j], other, all[s], match, geometry.x, offsets_[first + slot], gates, color))
            addCorrespondence(out.color[slot], color.x, color.n, color.own, color.r, color.w);
        }
      }
    });
    for (std::size_t k = 0; k < tasks.size(); ++k) {
      for (std::size_t slot = 0; slot < clusters_[k].geometry.size(); ++slot) {
        pairs_[firstPair(tasks[k].camera) + slot].geometry += clusters_[k].geometry[slot];
        pairs_[firstPair(tasks[k].camera) + slot].color += clusters_[k].color[slot];
      }
      for (std::size_t b = 0; b < residuals_.size(); ++b) residuals_[b] += histograms[k][b];
    }
  }

 private:
  void place(const std::vector<Eigen::Isometry3d>& poses) {
    places_.resize(cameras_);
    for (std::size_t i = 0; i < cameras_; ++i)
      places_[i] = {toRigidTransform(poses[i]), toRigidTransform(poses[i].inverse()), noise_[i]};
  }

  int threads_{1};
  RigGeometry rig_;
  std::vector<AlignmentView> views_;
  std::vector<std::vector<AlignmentSample>> samples_;
  std::vector<AlignmentCluster> clusters_;
  std::vector<NoiseModel> noise_;  ///< camera by camera
  std::vector<CameraPlace> places_;
  std::vector<SampleProjections> projections_;  ///< thread by thread
};

}  // namespace host
}  // namespace fuse_flow
