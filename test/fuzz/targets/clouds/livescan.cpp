#include "../../fuzz_target.h"
#include "../../scratch.h"

#include "clouds/livescan_file.h"

#include <fuse_flow/recordings/error.h>

/** \brief Clouds by LiveScan3D: 10 bytes a point, of which 48 are made. */
FUSE_FLOW_FUZZ_TARGET(livescan, 1 << 16, 64, 1000) {
  using namespace fuse_flow;
  const std::string path = fuse_flow_fuzz::scratchFile("recording_1.bin", input);
  fuse_flow_fuzz::accepts<io::InputError>([&] {
    io::LiveScanFile::is(path);
    io::LiveScanFile file(path);
    pcl::PointCloud<io::PointFusedNormal> points;
    for (std::size_t frame = 0; frame < std::min<std::size_t>(3, file.frameCount()); ++frame) file.read(frame, points);
  });
}
