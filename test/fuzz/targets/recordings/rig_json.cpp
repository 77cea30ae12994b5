#include "../../fuzz_target.h"
#include "../../scratch.h"

#include <fuse_flow/recordings/error.h>
#include <fuse_flow/recordings/rig_json.h>

/** \brief A rig's calibration. A value of JSON is some 40 bytes, of which two are the least that it is written with; a key has a copy more. A lens of another model is fitted, by
 *  samples of its whole image. */
FUSE_FLOW_FUZZ_TARGET(rig_json, 4 << 20, 512, 2000) {
  using namespace fuse_flow;
  const std::string path = fuse_flow_fuzz::scratchFile("rig.json", input);
  fuse_flow_fuzz::accepts<io::InputError>([&] { io::readRigJson(path); });
}
