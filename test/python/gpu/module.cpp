// The module without what needs libraries of its own (recordings, calibration, stereo): for a machine that has a GPU and little else.
#include "bindings.h"
#include "in_flight.h"

PYBIND11_MODULE(_fuse_flow, module) {
  using namespace fuse_flow::python;
  finishBeforeExit();
  bindErrors(module);
  bindCameras(module);
  bindFrames(module);
  bindStatistics(module);
  bindParameters(module);
  bindClouds(module);
  bindDeviceClouds(module);
  bindFusion(module);
}
