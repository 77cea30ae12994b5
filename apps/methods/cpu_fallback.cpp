#include "methods/cpu_fallback.h"

#include <utility>

namespace fuse_flow::io {

CpuFallback::CpuFallback(const Make& make_gpu, Make make_cpu, Warn warn)
    : method_(make_gpu, std::move(make_cpu), std::move(warn)) {}

void CpuFallback::fuse(const RigFrame& frame, Cloud& output) {
  method_.run([&](Method& method) { method.fuse(frame, output); });
}

std::shared_ptr<const stream::EncodedFrame> CpuFallback::fuseEncoded(const RigFrame& frame,
                                                                     const stream::FrameTimes& times) {
  std::shared_ptr<const stream::EncodedFrame> encoded;
  if (method_.onGpu())
    method_.run([&](Method& method) { encoded = method_.onGpu() ? method.fuseEncoded(frame, times) : nullptr; });
  return encoded;
}

}  // namespace fuse_flow::io
