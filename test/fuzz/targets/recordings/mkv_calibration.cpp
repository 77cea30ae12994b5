#include "../../fuzz_target.h"

#include "recordings/streams/azure_kinect.h"

#include <fuse_flow/recordings/error.h>

/** \brief The calibration in a file of an Azure Kinect: JSON, as rig.json. */
FUSE_FLOW_FUZZ_TARGET(mkv_calibration, 1 << 18, 512, 2000) {
  using namespace fuse_flow;
  fuse_flow_fuzz::accepts<io::InputError>([&] {
    io::azureKinectCamera("calibration.json", std::string(input), {"NFOV_2X2BINNED", "720P"});
  });
}
