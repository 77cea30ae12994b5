// The module without what needs libraries of its own (recordings, calibration, stereo): for a machine that has a GPU and little else, PCL's
// headers but not its libraries.
#include "bindings.h"
#include "fusion/in_flight.h"

#include <pcl/console/print.h>

namespace pcl::console {

// What PCL's headers call of its libraries: its messages, which nobody reads here.
void print(VERBOSITY_LEVEL, const char*, ...) {}
VERBOSITY_LEVEL getVerbosityLevel() { return L_ERROR; }
bool isVerbosityLevelEnabled(VERBOSITY_LEVEL) { return false; }
void setVerbosityLevel(VERBOSITY_LEVEL) {}

}  // namespace pcl::console

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
