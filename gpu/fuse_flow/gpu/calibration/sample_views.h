#pragma once

#include <fuse_flow/gpu/calibration/block_maps.h>
#include <fuse_flow/gpu/calibration/choose_samples_kernel.h>
#include <fuse_flow/impl/calibration/normal_space_sampling.hpp>

#include <memory>
#include <vector>

namespace fuse_flow {
namespace gpu {

/** \brief The samples of all views on the device, view by view, along the curve through each image: those that the CPU chooses, in
 *  its order. */
class SampleViews {
 public:
  /** \brief Waits once, to share the samples out. \param instants how many of maps count  \param images on the device, view by
   *  view  \param places on the device, camera by camera  \param count of samples of a view */
  void choose(Execution& run, const std::vector<std::unique_ptr<BlockMaps>>& maps, std::size_t instants,
              std::size_t cameras, const BlockImage* images, const CameraPlace* places, std::size_t count) {
    views_ = instants * cameras;
    sortBlocks(run, maps, instants, cameras, places);
    shareOut(run, maps, cameras, count);
    gather(run, images);
    sumMoments(run);
  }

  std::size_t total() const { return begin(views_); }
  /** \brief The first of a view's samples; those of the next follow. */
  std::size_t begin(std::size_t view) const { return host_begins_.data()[view]; }
  std::size_t count(std::size_t view) const { return begin(view + 1) - begin(view); }
  const AlignmentSample* samples() const { return samples_.data(); }
  /** \brief begin() of every view, and the end, on the device. */
  const std::uint32_t* begins() const { return begins_.data(); }
  /** \brief Of a view's samples in its camera's frame, once the stream has been waited for. */
  const PointMoments& moments(std::size_t view) const { return moments_.data()[view]; }

  std::size_t bytes() const {
    return keys_.bytes() + other_keys_.bytes() + values_.bytes() + other_values_.bytes() + bins_.bytes() +
           offsets_.bytes() + firsts_.bytes() + begins_.bytes() + chosen_.bytes() + view_of_.bytes() +
           samples_.bytes() + device_moments_.bytes();
  }

 private:
  std::size_t bins() const { return views_ * kNormalBins; }

  static int bitsOf(std::size_t largest) {
    int bits = 0;
    while (largest >> bits > 0) ++bits;
    return bits;
  }

  void reserve(std::size_t n) {
    for (auto* buffer : {&keys_, &other_keys_, &values_, &other_values_}) buffer->resize(n);
  }

  /** \brief All blocks by the bins of their normals, and in these in the order of the image. */
  void sortBlocks(Execution& run, const std::vector<std::unique_ptr<BlockMaps>>& maps, std::size_t instants,
                  std::size_t cameras, const CameraPlace* places) {
    std::size_t blocks = 0;
    for (std::size_t t = 0; t < instants; ++t) blocks += maps[t]->blocks();
    if (blocks > FrameViews::kMaxPixels)
      throw pcl::PCLException("fuse_flow::ExtrinsicEstimation: the frames on the GPU have more than 2^27 blocks");
    reserve(blocks);
    blocks = 0;
    for (std::size_t t = 0; t < instants; ++t) {
      run.forEach(maps[t]->blocks(),
                  BinNormals{maps[t]->grid(), maps[t]->normals(), places, static_cast<std::uint32_t>(t * cameras),
                             static_cast<std::uint32_t>(bins()), keys_.data() + blocks, values_.data() + blocks});
      blocks += maps[t]->blocks();
    }
    run.sortByKey(keys_, other_keys_, values_, other_values_, blocks, bitsOf(bins()));
    bins_.resize(bins() + 1);
    host_bins_.resize(bins() + 1);
    run.forEach(bins() + 1, FindBins{keys_.data(), static_cast<std::uint32_t>(blocks), bins_.data()});
    run.copySmall(host_bins_.data(), std::as_const(bins_).data(), bins() + 1);
    run.wait();
  }

  /** \brief How many samples each bin gives, and so where each view's begin. */
  void shareOut(Execution& run, const std::vector<std::unique_ptr<BlockMaps>>& maps, std::size_t cameras,
                std::size_t count) {
    host_begins_.resize(views_ + 1);
    host_firsts_.resize(bins() + 1);
    host_offsets_.resize(views_);
    std::uint32_t first = 0;
    for (std::size_t view = 0; view < views_; ++view) {
      host_begins_.data()[view] = first;
      host_offsets_.data()[view] = maps[view / cameras]->offset(view % cameras);
      const std::uint32_t* begins = host_bins_.data() + view * kNormalBins;
      host::NormalBinSizes sizes;
      for (std::size_t b = 0; b < kNormalBins; ++b) sizes[b] = begins[b + 1] - begins[b];
      const host::NormalBinSizes shares = host::evenShares(sizes, count);
      for (std::size_t b = 0; b < kNormalBins; ++b) {
        host_firsts_.data()[view * kNormalBins + b] = first;
        first += static_cast<std::uint32_t>(shares[b]);
      }
    }
    host_begins_.data()[views_] = host_firsts_.data()[bins()] = first;
    begins_.resize(views_ + 1);
    firsts_.resize(bins() + 1);
    offsets_.resize(views_);
    run.copySmall(begins_.data(), std::as_const(host_begins_).data(), views_ + 1);
    run.copySmall(firsts_.data(), std::as_const(host_firsts_).data(), bins() + 1);
    run.copySmall(offsets_.data(), std::as_const(host_offsets_).data(), views_);
  }

  void gather(Execution& run, const BlockImage* images) {
    const std::size_t n = total();
    chosen_.resize(n);
    view_of_.resize(n);
    samples_.resize(n);
    // The sorted blocks are read while keys of samples are written: into the other buffers.
    other_keys_.resize(n);
    other_values_.resize(n);
    run.forEach(n, ChooseSample{images, offsets_.data(), bins_.data(), values_.data(), firsts_.data(),
                                static_cast<std::uint32_t>(bins()), other_keys_.data(), other_values_.data(),
                                chosen_.data(), view_of_.data()});
    run.sortByKey(other_keys_, keys_, other_values_, values_, n, 32);
    run.forEach(n, ViewOfSample{other_values_.data(), view_of_.data(), other_keys_.data()});
    run.sortByKey(other_keys_, keys_, other_values_, values_, n, bitsOf(views_ - 1));
    run.forEach(n, GatherSample{images, other_values_.data(), chosen_.data(), view_of_.data(), samples_.data()});
  }

  void sumMoments(Execution& run) {
    device_moments_.resize(views_);
    moments_.resize(views_);
    const SumMoments sum{samples_.data(), begins_.data(), device_moments_.data()};
#if FUSE_FLOW_CUDA
    run.launch("sumMomentsKernel", sumMomentsKernel, static_cast<unsigned int>(views_), kMomentThreads, sum);
#else
    run.forEach(views_, sum);
#endif
    run.copySmall(moments_.data(), std::as_const(device_moments_).data(), views_);
  }

  std::size_t views_{0};
  DeviceBuffer<std::uint32_t> keys_, other_keys_, values_, other_values_;
  DeviceBuffer<std::uint32_t> bins_, firsts_, begins_, offsets_, chosen_, view_of_;
  PinnedBuffer<std::uint32_t> host_bins_, host_firsts_, host_begins_, host_offsets_;
  DeviceBuffer<AlignmentSample> samples_;
  DeviceBuffer<PointMoments> device_moments_;
  PinnedBuffer<PointMoments> moments_;
};

}  // namespace gpu
}  // namespace fuse_flow
