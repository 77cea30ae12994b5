#include "cloud_file.h"

#include <fuse_flow/recordings/recording.h>

/** \brief A cloud, and an organised cloud as a recording of one camera. LZF makes 264 bytes of 3, which are then sorted into another array, and a cloud
 *  of PCL's types is made of them, of 32 bytes a point. */
FUSE_FLOW_FUZZ_TARGET(pcd, 1 << 20, 4096, 400) {
  using namespace fuse_flow;
  const std::string path = fuse_flow_fuzz::readCloudFile("cloud.pcd", input);
  fuse_flow_fuzz::accepts<io::InputError>([&] {
    const auto recording = io::openRecording({path});
    io::LoadedFrame frame;
    recording->read(0, frame);
    fuse_flow_fuzz::requireGoodFrame(frame);
  });
}
