#pragma once

#include "../fusion/fusion.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace fuse_flow::python {

/** \brief A cloud in the memory of a GPU, complete: any stream may read it. */
struct GpuCloud {
  std::shared_ptr<const void> memory;  ///< keeps the points
  std::byte* points{nullptr};          ///< in the GPU's memory
  std::size_t size{0};
  PointLayout layout;
  std::uint64_t stamp{0};
  int device{0};  ///< number of the GPU
};

/** \brief A FuseFlow on a GPU. Images may be in host memory or in the GPU's: each is found out by its pointer. */
class GpuFusion : public Fusion {
 public:
  /** \brief The clouds stay on the GPU. */
  virtual GpuCloud fuseOnDevice(const RigFrame& frame) = 0;
  /** \brief The stream that everything runs on: a cudaStream_t. */
  virtual std::uintptr_t stream() const = 0;
  /** \brief Work of another stream is done before what follows on stream(). \param other a cudaStream_t, or 1 or 2 for the default streams */
  virtual void waitFor(std::uintptr_t other) = 0;
  /** \brief Number of the GPU that it runs on. */
  virtual int device() const = 0;
};

/** \brief On the GPU that is current. \throws pcl::PCLException if there is none */
std::unique_ptr<GpuFusion> makeGpuFusion(const PointExtras& extras);

}  // namespace fuse_flow::python
