#pragma once

#include "methods/method.h"

namespace fuse_flow::io {

/** \brief Ours, on the CPU or a GPU, with normals or the cameras of each point: most users want neither, and they take time. */
template <typename FuseFlowT>
class FusionWithNormals : public Method {
 public:
  explicit FusionWithNormals(const MethodOptions& options) {
    fusion_.setParameters(options.parameters);
    fusion_.setNumberOfThreads(options.threads);
    fusion_.setComputeNormals(options.normals);
  }
  void fuse(const RigFrame& frame, Cloud& output) override {
    fusion_.fuse(frame, with_normals_);
    statistics_ = fusion_.getStatistics();
    output.header = with_normals_.header;
    output.resize(with_normals_.size());
    for (std::size_t i = 0; i < output.size(); ++i) {
      const PointFusedNormal& p = with_normals_[i];
      PointFused& q = output[i];
      q.x = p.x;
      q.y = p.y;
      q.z = p.z;
      q.rgba = p.rgba;
      q.confidence = p.confidence;
      q.view_count = p.view_count;
    }
  }

 protected:
  FuseFlowT fusion_;
};

}  // namespace fuse_flow::io
