#pragma once

#include <fuse_flow/gpu/calibration/sample_views.h>
#include <fuse_flow/gpu/calibration/sum_correspondences.h>
#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/impl/calibration/rig_correspondences.hpp>

#include <vector>

namespace fuse_flow {
namespace gpu {

/** \brief Which samples are added up with which views: pair by pair of cameras, within them instant by instant, and then along the
 *  image, which is the order in which the CPU adds them. On the device, with a copy here. */
class ClusterLayout {
 public:
  void assign(Execution& run, const std::vector<host::PairSums>& pairs, const SampleViews& samples,
              std::size_t instants, std::size_t cameras) {
    clusters_.clear();
    begins_.assign(1, 0);
    for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
      for (std::size_t t = 0; t < instants; ++t) {
        const std::size_t view = t * cameras + pairs[pair].i, other = t * cameras + pairs[pair].j;
        const std::size_t end = samples.begin(view) + samples.count(view);
        for (std::size_t k = samples.begin(view); k < end; k += host::kClusterSamples)
          clusters_.push_back(
              {static_cast<std::uint32_t>(view), static_cast<std::uint32_t>(other), static_cast<std::uint32_t>(k),
               static_cast<std::uint32_t>(std::min(end, k + host::kClusterSamples)), static_cast<std::uint32_t>(pair)});
      }
      begins_.push_back(static_cast<std::uint32_t>(clusters_.size()));
    }
    upload(run, clusters_, host_clusters_, device_clusters_);
    upload(run, begins_, host_begins_, device_begins_);
  }

  std::size_t size() const { return clusters_.size(); }
  /** \brief The first cluster of a pair of cameras; those of the next follow. */
  std::size_t begin(std::size_t pair) const { return begins_[pair]; }
  /** \brief Of all clusters, on the device. */
  const ClusterPair* clusters() const { return device_clusters_.data(); }
  /** \brief begin() of every pair, and the end, on the device. */
  const std::uint32_t* begins() const { return device_begins_.data(); }
  std::size_t bytes() const { return device_clusters_.bytes() + device_begins_.bytes(); }

 private:
  template <typename Value>
  static void upload(Execution& run, const std::vector<Value>& values, PinnedBuffer<Value>& pinned,
                     DeviceBuffer<Value>& device) {
    pinned.resize(values.size());
    device.resize(values.size());
    std::copy(values.begin(), values.end(), pinned.data());
    run.copySmall(device.data(), std::as_const(pinned).data(), values.size());
  }

  std::vector<ClusterPair> clusters_;
  std::vector<std::uint32_t> begins_;
  PinnedBuffer<ClusterPair> host_clusters_;
  PinnedBuffer<std::uint32_t> host_begins_;
  DeviceBuffer<ClusterPair> device_clusters_;
  DeviceBuffer<std::uint32_t> device_begins_;
};

}  // namespace gpu
}  // namespace fuse_flow
