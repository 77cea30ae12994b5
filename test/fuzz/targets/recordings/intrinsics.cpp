#include "../../fuzz_target.h"
#include "../../scratch.h"

#include "recordings/calibrations/intrinsics_file.h"

#include <fuse_flow/recordings/error.h>

/** \brief A camera's intrinsics: the first byte says as what kind of file. A value of YAML is some 400 bytes, of which two are the least that it is written
 *  with; and a lens is fitted, as in rig.json. */
FUSE_FLOW_FUZZ_TARGET(intrinsics, 4 << 20, 2048, 2000) {
  using namespace fuse_flow;
  static const char* const names[] = {"camera.yaml", "camera.json", "K.txt", "cameras.txt", "camera_trajectory.json"};
  if (input.empty()) return;
  const std::string path =
      fuse_flow_fuzz::scratchFile(names[static_cast<unsigned char>(input[0]) % 5], input.substr(1));
  fuse_flow_fuzz::accepts<io::InputError>([&] { io::readIntrinsicsFile(path, 640, 480); });
}
