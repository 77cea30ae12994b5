#include "bindings.h"
#include "in_flight.h"

PYBIND11_MODULE(_fuse_flow, module) {
  using namespace fuse_flow::python;
  module.doc() = "Fuses the images of several calibrated depth cameras into one point cloud, frame by frame.";
  finishBeforeExit();
  bindErrors(module);
  bindCameras(module);
  bindFrames(module);
  bindStatistics(module);
  bindParameters(module);
  bindClouds(module);
  bindDeviceClouds(module);
  bindFusion(module);
  bindRecordings(module);
  bindFilters(module);
  bindQuality(module);
  bindExtrinsics(module);
  bindCoarseAlignment(module);
  bindDepthCorrection(module);
  bindTracking(module);
  bindSynchronizer(module);
  bindStereo(module);
#ifdef FUSE_FLOW_WITH_STREAM
  bindStreams(module);
#endif
}
