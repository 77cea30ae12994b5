#pragma once

#include <fuse_flow/device_error.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace fuse_flow::io {

/** \brief Something that works on the GPU until that fails, and on the CPU from then on, for --device auto: a GPU that runs out of memory, or is
 *  lost, costs speed and no frame. */
template <typename Worker>
class GpuThenCpu {
 public:
  using Make = std::function<std::unique_ptr<Worker>()>;
  using Warn = std::function<void(const std::string&)>;

  /** \param make_gpu may throw DeviceError  \param warn gets one line when the GPU has failed */
  GpuThenCpu(const Make& make_gpu, Make make_cpu, Warn warn) : make_cpu_(std::move(make_cpu)), warn_(std::move(warn)) {
    try {
      worker_ = make_gpu();
    } catch (const DeviceError& error) {
      goOnWithoutGpu(error.what());
    }
  }

  /** \brief action(Worker&); again with the CPU's if the GPU fails in it. */
  template <typename Action>
  void run(const Action& action) {
    if (!worker_) worker_ = make_cpu_();  // which there was no memory for before
    if (on_gpu_) {
      try {
        action(*worker_);
        return;
      } catch (const DeviceError& error) {
        goOnWithoutGpu(error.what());
      }
    }
    action(*worker_);
  }

  bool onGpu() const { return on_gpu_; }
  /** \brief Null after there was no memory for the CPU's. */
  const Worker* worker() const { return worker_.get(); }

 private:
  void goOnWithoutGpu(const std::string& error) {
    on_gpu_ = false;
    worker_ = nullptr;  // before the CPU's takes memory
    warn_("the GPU has failed, and the CPU goes on: " + error + "; --device gpu ends there instead");
    worker_ = make_cpu_();
  }

  Make make_cpu_;
  Warn warn_;
  std::unique_ptr<Worker> worker_;
  bool on_gpu_{true};
};

}  // namespace fuse_flow::io
