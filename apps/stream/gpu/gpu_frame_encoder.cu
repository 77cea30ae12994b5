#include "stream/gpu/gpu_frame_encoder.h"

#include "stream/gpu/device_frame_encoder.h"

namespace fuse_flow::stream {

struct GpuFrameEncoder::Workspace : DeviceFrameEncoder {
  using DeviceFrameEncoder::DeviceFrameEncoder;
};

GpuFrameEncoder::GpuFrameEncoder(const EncodingOptions& options) : workspace_(new Workspace(options)) {}
GpuFrameEncoder::~GpuFrameEncoder() = default;

const EncodingOptions& GpuFrameEncoder::options() const { return workspace_->options(); }

std::shared_ptr<const EncodedFrame> GpuFrameEncoder::encode(const CloudView& cloud, const FrameTimes& times,
                                                            void* stream) {
  return workspace_->encode(cloud, times, static_cast<gpu::Stream>(stream));
}

}  // namespace fuse_flow::stream
