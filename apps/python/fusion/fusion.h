#pragma once

#include "../cloud.h"

#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/fusion/statistics.h>
#include <fuse_flow/rig_frame.h>

#include <memory>

namespace fuse_flow::python {

/** \brief What the points of a cloud have besides position, colour, confidence and view_count. */
struct PointExtras {
  bool normals{false};
  bool camera_mask{false};
};

/** \brief A FuseFlow, of whatever points and wherever it runs. */
class Fusion {
 public:
  virtual ~Fusion() = default;
  virtual void setParameters(const FuseFlowParameters& parameters) = 0;
  virtual void setNumberOfThreads(unsigned int threads) = 0;
  virtual Cloud fuse(const RigFrame& frame) = 0;
  virtual FrameStatistics statistics() const = 0;
};

std::unique_ptr<Fusion> makeHostFusion(const PointExtras& extras);

}  // namespace fuse_flow::python
