#pragma once

#include <fuse_flow/gpu/calibration/cluster_layout.h>
#include <fuse_flow/gpu/calibration/sample_views.h>
#include <fuse_flow/gpu/calibration/sum_correspondences_kernel.h>
#include <fuse_flow/impl/calibration/rig_correspondences.hpp>

#include <chrono>

namespace fuse_flow {
namespace gpu {

/** \brief Where the time of an estimate goes, milliseconds of the host's clock; what is left is the host's algebra. */
struct EstimateTimes {
  double sampling{0};         ///< choosing samples, and where they lie
  double correspondences{0};  ///< neighbours, and all evaluations
  int evaluations{0};
};

/** \brief The views of several instants of one rig in device memory: host::AlignmentSystem's counterpart. What the host sees of
 *  them are sums. */
class AlignmentSystem : public host::RigCorrespondences {
 public:
  Execution run;
  StageTimes times;
  /** \brief Host threads that copy pageable images to pinned memory. */
  int threads{1};
  EstimateTimes spent;

  void clear() { instants_ = cameras_ = 0; }

  /** \brief One instant more; the images may go when it returns. */
  void add(const RigFrame& frame, const ExtrinsicParameters& p) {
    cameras_ = frame.cameras.size();
    times.start(run.stream);
    const ConfidenceParameters noise = noiseParameters(p);
    full_.assign(run, inCamerasFrames(frame), &noise, p.use_color, threads);
    times.mark("upload", 2.0 * static_cast<double>(full_.uploadedBytes()));
    DepthMapParameters measured = DepthMapParameters::withoutSmoothing(p.preprocessing);
    measured.confidence = noise;
    noise_.resize(frame.cameras.size());
    for (std::size_t i = 0; i < noise_.size(); ++i) noise_[i] = frame.cameras[i].noise.value_or(p.noise);
    measured.adapt_noise = true;
    if (full_.pixels() > 0) depth_.make(run, times, full_, measured);
    run.wait();  // how noisy views are says how large blocks are, and so how many
    if (maps_.size() == instants_) maps_.push_back(std::make_unique<BlockMaps>());
    BlockMaps& maps = *maps_[instants_];
    maps.make(run, times, full_, depth_, p, scratch_);
    run.wait();
    maps.keep(scratch_);
    images_.resize((instants_ + 1) * cameras_);
    for (std::size_t i = 0; i < cameras_; ++i) images_[instants_ * cameras_ + i] = maps.image(i, full_.hostView(i), p);
    ++instants_;
  }

  bool hasColor() const override {
    for (std::size_t t = 0; t < instants_; ++t)
      if (maps_[t]->hasColor()) return true;
    return false;
  }

  void sample(const std::vector<Eigen::Isometry3d>& poses, int count) override {
    const Timing timing(spent.sampling);
    host_images_.resize(images_.size());
    std::copy(images_.begin(), images_.end(), host_images_.data());
    device_images_.resize(images_.size());
    run.copySmall(device_images_.data(), std::as_const(host_images_).data(), images_.size());
    place(poses);
    samples_.choose(run, maps_, instants_, cameras_, device_images_.data(), places(), static_cast<std::size_t>(count));
  }

  host::SceneExtent extent(const std::vector<Eigen::Isometry3d>& poses) override {
    const Timing timing(spent.sampling);
    run.wait();
    host::SceneExtent result;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double squares = 0;
    const auto forEach = [&](auto&& visit) {
      for (std::size_t view = 0; view < instants_ * cameras_; ++view)
        if (samples_.count(view) > 0)
          visit(poses[view % cameras_], samples_.moments(view), static_cast<double>(samples_.count(view)));
    };
    forEach([&](const Eigen::Isometry3d& T, const PointMoments& moments, double n) {
      sum += T.linear() * Eigen::Vector3d(moments.sum) + n * T.translation();
    });
    const auto count = static_cast<double>(samples_.total());
    if (count == 0) return result;
    result.center = sum / count;
    // From the camera: numbers that are small wherever the world's origin is.
    forEach([&](const Eigen::Isometry3d& T, const PointMoments& moments, double n) {
      const Eigen::Vector3d from_center = T.linear().transpose() * (T.translation() - result.center);
      squares += moments.squares + 2 * from_center.dot(Eigen::Vector3d(moments.sum)) + n * from_center.squaredNorm();
    });
    result.radius = std::max(1e-3, std::sqrt(squares / count));
    return result;
  }

  const std::vector<host::AlignmentCluster>& clusters() override {
    const Timing timing(spent.correspondences);
    PinnedBuffer<AlignmentSums>& sums = host_cluster_sums_;
    sums.resize(2 * layout_.size());
    run.copy(sums.data(), std::as_const(cluster_sums_).data(), 2 * layout_.size());
    run.wait();
    clusters_.clear();
    for (std::size_t camera = 0; camera < cameras_; ++camera) {
      std::size_t place = 0;  // the same for all neighbours
      for (std::size_t view = camera; view < instants_ * cameras_; view += cameras_)
        for (std::size_t k = 0; k < samples_.count(view); k += host::kClusterSamples, ++place) {
          clusters_.push_back({camera, k / host::kClusterSamples, {}, {}});
          for (std::size_t pair = firstPair(camera); pair < firstPair(camera + 1); ++pair) {
            clusters_.back().geometry.push_back(sums.data()[2 * (layout_.begin(pair) + place)]);
            clusters_.back().color.push_back(sums.data()[2 * (layout_.begin(pair) + place) + 1]);
          }
        }
    }
    return clusters_;
  }

  /** \brief The samples of a view of the last sample(), for tests. */
  std::vector<AlignmentSample> samples(std::size_t instant, std::size_t camera) {
    const std::size_t view = instant * cameras_ + camera;
    PinnedBuffer<AlignmentSample> samples;
    samples.resize(samples_.count(view));
    run.copy(samples.data(), samples_.samples() + samples_.begin(view), samples_.count(view));
    run.wait();
    return {samples.data(), samples.data() + samples_.count(view)};
  }

  /** \brief Device memory held. */
  std::size_t bytes() const {
    std::size_t sum = full_.bytes() + depth_.bytes() + scratch_.bytes() + samples_.bytes() + device_images_.bytes() +
                      input_.bytes() + seen_.bytes() + layout_.bytes() + cluster_sums_.bytes() + run.scratchBytes();
    for (const auto& maps : maps_) sum += maps->bytes();
    return sum;
  }

 private:
  /** \brief Adds the time that it lives to a sum. */
  class Timing {
   public:
    explicit Timing(double& sum) : sum_(sum) {}
    ~Timing() { sum_ += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count(); }
    Timing(const Timing&) = delete;

   private:
    double& sum_;
    std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
  };

  /** \brief The frame without poses and without confidence. The data computed from images do not depend on poses, so moved cameras need no
   *  new geometry. The alignment does not use confidence. */
  const RigFrame& inCamerasFrames(const RigFrame& frame) {
    frame_ = frame;
    for (Camera& camera : frame_.cameras) camera.T_world_camera.setIdentity();
    for (DepthView& view : frame_.views) view.confidence = {};
    return frame_;
  }

  bool missing(std::size_t instant, std::size_t camera) const override { return maps_[instant]->missing(camera); }
  float normalNoiseOf(std::size_t instant, std::size_t camera) const override {
    return maps_[instant]->normalNoiseOf(camera);
  }

  // What changes from evaluation to evaluation goes up in one piece: places, offsets of pairs, and an empty histogram.

  std::size_t placeWords() const { return cameras_ * sizeof(CameraPlace) / 4; }
  const CameraPlace* places() const { return reinterpret_cast<const CameraPlace*>(input_.data()); }
  const float* offsets() const { return reinterpret_cast<const float*>(input_.data() + placeWords()); }
  std::uint32_t* residuals() { return input_.data() + placeWords() + offsets_.size(); }

  void place(const std::vector<Eigen::Isometry3d>& poses) {
    const std::size_t words = placeWords() + offsets_.size() + kNoiseBins;
    host_input_.resize(words);
    input_.resize(words);
    for (std::size_t i = 0; i < cameras_; ++i) {
      const CameraPlace place{toRigidTransform(poses[i]), toRigidTransform(poses[i].inverse()), noise_[i]};
      std::memcpy(host_input_.data() + i * sizeof(CameraPlace) / 4, &place, sizeof(CameraPlace));
    }
    if (!offsets_.empty())
      std::memcpy(host_input_.data() + placeWords(), offsets_.data(), offsets_.size() * sizeof(float));
    std::memset(host_input_.data() + placeWords() + offsets_.size(), 0, kNoiseBins * sizeof(std::uint32_t));
    run.copySmall(input_.data(), std::as_const(host_input_).data(), words);
  }

  void countSeen(const std::vector<Eigen::Isometry3d>& poses, const AlignmentGates& gates,
                 std::vector<Seen>& seen) override {
    const Timing timing(spent.correspondences);
    laid_out_ = false;
    place(poses);
    seen_.resize(seen.size());
    host_seen_.resize(seen.size());
    run.fill(seen_.data(), seen.size(), 0);
    for (std::size_t t = 0; t < instants_; ++t) {
      std::size_t most = 0;
      for (std::size_t i = 0; i < cameras_; ++i) most = std::max(most, samples_.count(t * cameras_ + i));
      const std::size_t asked = (most + kSeenStride - 1) / kSeenStride;
      run.forEach(seen.size() * asked,
                  CountSeen{device_images_.data(), samples_.samples(), samples_.begins(), places(), gates,
                            static_cast<std::uint32_t>(t * cameras_), static_cast<std::uint32_t>(cameras_),
                            static_cast<std::uint32_t>(asked), static_cast<std::uint32_t>(kSeenStride), seen_.data()});
    }
    run.copySmall(host_seen_.data(), std::as_const(seen_).data(), seen.size());
    run.wait();
    for (std::size_t k = 0; k < seen.size(); ++k) {
      const std::size_t i = k / cameras_, j = k % cameras_;
      seen[k].count = host_seen_.data()[k];
      for (std::size_t t = 0; t < instants_ && i != j; ++t)
        if (!missing(t, j)) seen[k].asked += (samples_.count(t * cameras_ + i) + kSeenStride - 1) / kSeenStride;
    }
  }

  void addUp(const std::vector<Eigen::Isometry3d>& poses, float per_radius, const AlignmentGates& gates) override {
    const Timing timing(spent.correspondences);
    ++spent.evaluations;
    if (!laid_out_) {
      layout_.assign(run, pairs_, samples_, instants_, cameras_);
      cluster_sums_.resize(2 * layout_.size());
      host_pair_sums_.resize(2 * pairs_.size());
      host_residuals_.resize(kNoiseBins);
      laid_out_ = true;
    }
    if (layout_.size() == 0) return;
    place(poses);
    const SumCorrespondences sum{layout_.clusters(),
                                 device_images_.data(),
                                 samples_.samples(),
                                 places(),
                                 offsets(),
                                 static_cast<std::uint32_t>(cameras_),
                                 gates,
                                 per_radius,
                                 cluster_sums_.data(),
                                 residuals()};
#if FUSE_FLOW_CUDA
    run.launch("sumCorrespondencesKernel", sumCorrespondencesKernel, static_cast<unsigned int>(layout_.size()),
               kSumThreads, sum);
#else
    run.forEach(layout_.size(), sum);
#endif
    const SumPairs sum_pairs{layout_.begins(), cluster_sums_.data(),   static_cast<std::uint32_t>(pairs_.size()),
                             residuals(),      host_pair_sums_.data(), host_residuals_.data()};
    run.forEach(sum_pairs.steps(), sum_pairs);
    run.wait();
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
      pairs_[pair].geometry = host_pair_sums_.data()[2 * pair];
      pairs_[pair].color = host_pair_sums_.data()[2 * pair + 1];
    }
    std::copy(host_residuals_.data(), host_residuals_.data() + kNoiseBins, residuals_.begin());
  }

  RigFrame frame_;
  FrameViews full_;
  DepthMaps depth_;
  BlockScratch scratch_;
  std::vector<std::unique_ptr<BlockMaps>> maps_;  ///< instant by instant; more of them than instants after clear()
  std::vector<BlockImage> images_;                ///< view by view
  std::vector<NoiseModel> noise_;                 ///< camera by camera
  PinnedBuffer<BlockImage> host_images_;
  DeviceBuffer<BlockImage> device_images_;
  SampleViews samples_;
  PinnedBuffer<std::uint32_t> host_input_, host_seen_, host_residuals_;
  DeviceBuffer<std::uint32_t> input_, seen_;
  bool laid_out_{false};
  ClusterLayout layout_;
  DeviceBuffer<AlignmentSums> cluster_sums_;
  PinnedBuffer<AlignmentSums> host_cluster_sums_, host_pair_sums_;
  std::vector<host::AlignmentCluster> clusters_;
};

}  // namespace gpu
}  // namespace fuse_flow
