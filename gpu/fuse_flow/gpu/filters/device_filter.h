#pragma once

#include <fuse_flow/gpu/device_cloud.h>
#include <fuse_flow/gpu/runtime/on_error.h>
#include <fuse_flow/gpu/sensors/depth_maps.h>

#include <string>
#include <vector>

namespace fuse_flow {
namespace gpu {

/** \brief What the filters for device::Thrust have in common: a stream, and copies between host vectors and the device. The
 *  filters are those of the CPU but for the step that computes, so that they honour the same settings. */
class DeviceFilter {
 public:
  /** \brief Throws pcl::PCLException if there is no device. It runs on the device that is current where it is made. */
  explicit DeviceFilter(const char* name) : home_(name) {}

  /** \brief While it lives, the filter's device is the calling thread's; an error that ends it is followed by no more work. */
  class Visit {
   public:
    explicit Visit(DeviceFilter& filter) : at_home_(filter.home_), settle_(Settle{filter.run}) {}

   private:
    struct Settle {
      Execution& run;
      void operator()() const { run.settle(); }
    };
    const HomeDevice::Visit at_home_;
    const OnError<Settle> settle_;
  };

  Execution run;
  StageTimes times;

  /** \brief From pageable memory. */
  template <typename Value>
  void upload(const Value* from, std::size_t n, DeviceBuffer<Value>& to) {
    to.resize(n);
    run.copy(to.data(), from, n);
    run.wait();
  }

  /** \brief The cloud that a filter reads. \throws pcl::PCLException if none has been set */
  template <typename PointT>
  static const DeviceCloud<PointT>& inputOf(const char* owner,
                                            const std::shared_ptr<const DeviceCloud<PointT>>& cloud) {
    if (!cloud) throw pcl::PCLException(std::string(owner) + ": no input cloud on the device: call setInputCloud()");
    return *cloud;
  }

  /** \brief To pageable memory. */
  template <typename Value>
  void download(const DeviceBuffer<Value>& from, std::size_t n, Value* to) {
    run.copy(to, from.data(), n);
    run.wait();
  }

 private:
  HomeDevice home_;
};

}  // namespace gpu
}  // namespace fuse_flow
