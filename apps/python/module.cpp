#include "bindings.h"
#include "fusion/in_flight.h"
#include "recordings/open_ends.h"

PYBIND11_MODULE(_fuse_flow, module) {
  using namespace fuse_flow::python;
  module.doc() = "Fuses the images of several calibrated depth cameras into one point cloud, frame by frame.";
  finishBeforeExit();
  beforeExit(&OpenEnd::closeAll);
  bindErrors(module);
  bindCameras(module);
  bindFrames(module);
  bindStatistics(module);
  bindParameters(module);
  bindClouds(module);
  bindDeviceClouds(module);
  bindFusion(module);
  bindRecordings(module);
  bindRigWriter(module);
  bindPoseCheck(module);
  bindFilters(module);
  bindQuality(module);
  bindExtrinsics(module);
  bindCoarseAlignment(module);
  bindDepthCorrection(module);
  bindTracking(module);
  bindSynchronizer(module);
  bindLive(module);
  bindStereo(module);
#ifdef FUSE_FLOW_WITH_STREAM
  bindStreams(module);
#endif
}
