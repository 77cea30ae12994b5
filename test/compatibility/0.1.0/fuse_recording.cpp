#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>
#include <fuse_flow/recordings/recording.h>

#include <pcl/io/pcd_io.h>

#include <iostream>

int main(int argc, char** argv) try {
  const auto recording = fuse_flow::io::openRecording({argv + 1, argv + argc});
  for (const std::string& warning : recording->warnings()) std::cerr << warning << '\n';
  fuse_flow::io::LoadedFrame frame;
  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  for (const std::size_t number : recording->frames()) {
    recording->read(number, frame);  // frame.rig is the RigFrame, frame.images what it points into
    fusion.fuse(frame.rig, cloud);
    pcl::io::savePCDFileBinary("fused_" + std::to_string(number) + ".pcd", cloud);
  }
} catch (const std::exception& error) {  // one line: the file, what is wrong, what would be right
  std::cerr << error.what() << '\n';
  return 1;
}
