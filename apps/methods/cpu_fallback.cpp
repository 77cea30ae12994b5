#include "methods/cpu_fallback.h"

#include <fuse_flow/device_error.h>

#include <utility>

namespace fuse_flow::io {

CpuFallback::CpuFallback(const Make& make_gpu, Make make_cpu, Warn warn)
    : make_cpu_(std::move(make_cpu)), warn_(std::move(warn)) {
  try {
    method_ = make_gpu();
  } catch (const DeviceError& error) {
    goOnWithoutGpu(error.what());
  }
}

void CpuFallback::fuse(const RigFrame& frame, Cloud& output) {
  if (!method_) method_ = make_cpu_();  // which there was no memory for before
  if (on_gpu_) {
    try {
      method_->fuse(frame, output);
      return;
    } catch (const DeviceError& error) {
      goOnWithoutGpu(error.what());
    }
  }
  method_->fuse(frame, output);
}

std::shared_ptr<const stream::EncodedFrame> CpuFallback::fuseEncoded(const RigFrame& frame,
                                                                     const stream::FrameTimes& times) {
  if (!on_gpu_) return nullptr;
  try {
    return method_->fuseEncoded(frame, times);
  } catch (const DeviceError& error) {
    goOnWithoutGpu(error.what());
    return nullptr;
  }
}

void CpuFallback::goOnWithoutGpu(const std::string& error) {
  on_gpu_ = false;
  method_ = nullptr;  // before the CPU's takes memory
  warn_("the GPU has failed, and the CPU goes on: " + error + "; --device gpu ends there instead");
  method_ = make_cpu_();
}

}  // namespace fuse_flow::io
