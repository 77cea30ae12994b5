// The same frame on a GPU. Compiled by nvcc it runs on CUDA; compiled by another compiler, on Thrust's CPU system.
#include "scene.h"

#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <iostream>

int main() {
  std::vector<fuse_flow::RigFrame> frames(2);
  std::vector<std::vector<std::uint16_t>> depths;
  for (const fuse_flow::Camera& camera : exampleCameras()) depths.push_back(exampleDepth(camera));
  for (fuse_flow::RigFrame& frame : frames) {
    frame.cameras = exampleCameras();
    frame.views.resize(frame.cameras.size());
    for (std::size_t i = 0; i < depths.size(); ++i) frame.views[i].depth16 = {depths[i].data(), 640, 480};
  }
  pcl::PointCloud<fuse_flow::PointFused> cloud;

  fuse_flow::FuseFlow<fuse_flow::PointFused, fuse_flow::device::Thrust> fusion;
  fusion.fuse(frames[0], cloud);  // one frame, host to host
  bool good = onBoardOrWall(cloud);

  fusion.submit(frames[0]);  // or several in flight: upload, computation and download overlap
  fusion.submit(frames[1]);  // the images must stay valid until next() has returned their frame
  fusion.next(cloud);        // the oldest
  good = good && onBoardOrWall(cloud);
  fusion.next(cloud);
  good = good && onBoardOrWall(cloud);
  std::cout << cloud.size() << " points\n";
  return good ? 0 : 1;
}
