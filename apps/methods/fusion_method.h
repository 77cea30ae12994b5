#pragma once

#include "methods/method.h"

namespace fuse_flow::io {

/** \brief Ours, on the CPU or a GPU. */
template <typename FuseFlowT>
class FusionMethod : public Method {
 public:
  explicit FusionMethod(const MethodOptions& options) {
    fusion_.setParameters(options.parameters);
    fusion_.setNumberOfThreads(options.threads);
  }
  void fuse(const RigFrame& frame, Cloud& output) override {
    fusion_.fuse(frame, output);
    statistics_ = fusion_.getStatistics();
  }

 protected:
  FuseFlowT fusion_;
};

}  // namespace fuse_flow::io
