#pragma once

#include <fuse_flow/filters/adaptive_hash_fusion.h>
#include <fuse_flow/gpu/filters/cloud_aggregation.h>

namespace fuse_flow {

/** \brief On the GPU, for clouds in host memory or on the device. The points of a coarse cell come in the order of their places in it.
 *  \copydetails AdaptiveHashFusion */
template <typename PointT>
class AdaptiveHashFusion<PointT, device::Thrust> : public AdaptiveHashFusion<PointT, device::Host> {
 public:
  ///@{
  /** \brief As in every PCL filter. */
  using Ptr = pcl::shared_ptr<AdaptiveHashFusion>;
  using ConstPtr = pcl::shared_ptr<const AdaptiveHashFusion>;
  ///@}

  /** \copydoc AdaptiveHashFusion<PointT, device::Host>::AdaptiveHashFusion
   *  \throws pcl::PCLException if there is no GPU */
  explicit AdaptiveHashFusion(bool extract_removed_indices = false)
      : AdaptiveHashFusion<PointT, device::Host>(extract_removed_indices), device_("fuse_flow::AdaptiveHashFusion") {}

  /** \brief The CUDA stream that it runs on; default the default stream. */
  void setStream(gpu::Stream stream) { device_.run.stream = stream; }

  using DeviceCloud = gpu::DeviceCloud<PointT>;
  using AdaptiveHashFusion<PointT, device::Host>::setInputCloud;
  using AdaptiveHashFusion<PointT, device::Host>::filter;

  /** \brief The clouds that filter(DeviceCloud&) reads, in the world frame: cloud i is what camera i saw; null or empty: it
   *  saw nothing. In place of setCameraIndices(), which is for clouds in host memory. */
  void setInputClouds(const std::vector<typename DeviceCloud::ConstPtr>& clouds) { device_inputs_ = clouds; }
  /** \brief One cloud, all of camera 0. */
  void setInputCloud(const typename DeviceCloud::ConstPtr& cloud) { device_inputs_ = {cloud}; }

  /** \brief As filter() of the clouds in host memory, one after the other; that is also how setIndices() and
   *  getRemovedIndices() count. An index counts once, however often it was given. Nothing is copied over the bus but the
   *  number of points. \param output may be one of the inputs. Its header is that of the first cloud, its sensor pose too
   *  where there is no other cloud.
   *  \throws pcl::PCLException for a point more than 2^20 cells from the origin
   *  \throws pcl::BadArgumentException for more clouds than the frame has cameras, or an index beyond the clouds */
  void filter(DeviceCloud& output) {
    constexpr const char* owner = "fuse_flow::AdaptiveHashFusion";
    const detail::OneThread::Inside inside(this->one_thread_, owner);
    const gpu::DeviceFilter::Visit visit(device_);
    if (device_inputs_.empty()) throw pcl::PCLException(std::string(owner) + ": no input cloud on the device");
    if (this->frame_ && device_inputs_.size() > this->frame_->cameras.size())
      detail::throwBadArgument(owner, ": ", device_inputs_.size(), " clouds, the frame has ",
                               this->frame_->cameras.size(), " cameras");
    const std::uint8_t* wanted = uploadWanted(owner);
    gpu::ConsistencyEvaluator evaluator;
    if (this->frame_) evaluator = prepareFrame();
    std::vector<std::uint8_t> represents;
    aggregation_.fuse(this->parameters_, device_inputs_, wanted, this->frame_ ? &evaluator : nullptr,
                      this->weight_in_intensity_, result_, this->extract_removed_indices_ ? &represents : nullptr);
    describe();
    this->removed_indices_->clear();
    for (std::size_t k = 0; k < represents.size(); ++k)
      if (!represents[k] && (wanted == nullptr || host_wanted_[k]))
        this->removed_indices_->push_back(static_cast<pcl::index_t>(k));
    std::swap(output, result_);
  }

 protected:
  std::vector<FusedPoint> fusePoints(const std::vector<WeightedPoint>& points,
                                     const std::vector<std::uint32_t>& cameras,
                                     std::vector<std::uint64_t>& agreeing) override {
    const gpu::DeviceFilter::Visit visit(device_);
    if (!this->frame_) return aggregation_.fuse(this->parameters_, points, cameras, nullptr, agreeing);
    const gpu::ConsistencyEvaluator evaluator = prepareFrame();
    return aggregation_.fuse(this->parameters_, points, cameras, &evaluator, agreeing);
  }

 private:
  /** \brief The frame's depth on the device. */
  gpu::ConsistencyEvaluator prepareFrame() {
    views_.assign(device_.run, *this->frame_, nullptr, false, gpu::copyThreads(this->threads_));
    maps_.make(device_.run, device_.times, views_, gpu::DepthMapParameters::withoutSmoothing(this->preprocessing_));
    return {views_.grid().views, maps_.measured(), this->consistency_};
  }

  /** \brief Null: all points. */
  const std::uint8_t* uploadWanted(const char* owner) {
    if (!this->use_indices_) return nullptr;
    std::size_t size = 0;
    for (const typename DeviceCloud::ConstPtr& cloud : device_inputs_) size += cloud ? cloud->size() : 0;
    host_wanted_.assign(size, 0);
    for (const pcl::index_t index : *this->getIndices()) {
      if (index < 0 || static_cast<std::size_t>(index) >= size)
        detail::throwBadArgument(owner, ": index ", index, ", the clouds have ", size, " points");
      host_wanted_[static_cast<std::size_t>(index)] = 1;
    }
    device_.upload(host_wanted_.data(), size, wanted_);
    return wanted_.data();
  }

  /** \brief All of the result but its points. */
  void describe() {
    const typename DeviceCloud::ConstPtr& first = device_inputs_.front();
    if (first && device_inputs_.size() == 1) {
      DeviceCloud::copyHeader(*first, result_);
    } else {
      DeviceCloud::copyHeader(DeviceCloud(), result_);
      if (first) result_.header = first->header;
    }
    // Of clouds whose normals are known all are; of others nobody has looked.
    result_.is_dense =
        !gpu::PointLayout<PointT>::has_normal ||
        std::all_of(device_inputs_.begin(), device_inputs_.end(),
                    [](const typename DeviceCloud::ConstPtr& cloud) { return !cloud || cloud->is_dense; });
  }

  gpu::DeviceFilter device_;
  gpu::CloudAggregation aggregation_{device_};
  gpu::FrameViews views_;
  gpu::DepthMaps maps_;
  std::vector<typename DeviceCloud::ConstPtr> device_inputs_;
  std::vector<std::uint8_t> host_wanted_;
  gpu::DeviceBuffer<std::uint8_t> wanted_;
  DeviceCloud result_;
};

}  // namespace fuse_flow
