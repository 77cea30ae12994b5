// A recording that the tools read, of images that a program has in memory.
#include "scene.h"

#include <fuse_flow/recordings/rig_writer.h>

#include <iostream>

int main() try {
  const std::vector<fuse_flow::Camera> my_cameras = exampleCameras();

  fuse_flow::io::RigDescription rig;
  for (const fuse_flow::Camera& camera : my_cameras) rig.cameras.push_back({camera});
  rig.frames_per_second = 30.0;
  const fuse_flow::io::RigWriter writer("my_recording", rig, false);  // a new folder; true: with colour images
  fuse_flow::io::LoadedFrame images;
  images.images.resize(my_cameras.size());
  images.rig.views.resize(my_cameras.size());
  for (std::size_t frame = 0; frame < 2; ++frame) {
    for (std::size_t i = 0; i < my_cameras.size(); ++i) {
      fuse_flow::io::DepthImage& depth = images.images[i].depth16;
      depth.resize(640, 480);
      depth.data = exampleDepth(my_cameras[i]);    // std::uint16_t, in units of the camera's depth_scale
      images.rig.views[i].depth16 = depth.view();  // {} where the camera lost this frame
    }
    writer.write(frame, images);
  }
  writer.finish();  // writes rig.json
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
