#pragma once

#include <fuse_flow/stream/encoded_frame.h>

#include <memory>

namespace fuse_flow::stream {

/** \brief FrameEncoder for clouds in device memory: what leaves the GPU are the bytes. Its frames decode to what those of FrameEncoder do,
 *  with about as many bytes. Built where there is CUDA. One thread may use it at a time. */
class GpuFrameEncoder {
 public:
  /** \throws std::invalid_argument as FrameEncoder does, pcl::PCLException if there is no device */
  explicit GpuFrameEncoder(const EncodingOptions& options = {});
  ~GpuFrameEncoder();
  GpuFrameEncoder(const GpuFrameEncoder&) = delete;
  GpuFrameEncoder& operator=(const GpuFrameEncoder&) = delete;

  /** \brief The same bytes for the same points, in any order. \param cloud points into device memory
   *  \param stream the cudaStream_t on which the points are made, and which is waited for  \throws pcl::PCLException of CUDA's errors */
  std::shared_ptr<const EncodedFrame> encode(const CloudView& cloud, const FrameTimes& times, void* stream = nullptr);
  const EncodingOptions& options() const;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace fuse_flow::stream
