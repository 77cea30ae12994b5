// A frame of three cameras to one cloud: the lines of doc/guide/cpp.md.
#include "scene.h"

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <iostream>

int main() {
  const std::vector<fuse_flow::Camera> my_cameras = exampleCameras();
  std::vector<std::vector<std::uint16_t>> buffers;
  for (const fuse_flow::Camera& camera : my_cameras) buffers.push_back(exampleDepth(camera));
  const std::uint16_t* depth_millimetres = buffers[0].data();
  const std::vector<fuse_flow::Rgb8> pixels(buffers[0].size(), {200, 120, 40});
  const fuse_flow::Rgb8* rgb = pixels.data();

  // A camera as your calibration knows it.
  fuse_flow::Camera camera;
  camera.name = "left";
  camera.intrinsics = {640, 480, 525.0f, 525.0f, 319.5f, 239.5f, {}};  // width, height, fx, fy, cx, cy; pixels
  camera.intrinsics.distortion.k1 = 0.02f;
  camera.T_world_camera = Eigen::Translation3d(-0.1, 0, 0) * Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY());
  fuse_flow::checkCamera(camera);  // throws and says what is wrong

  // A frame.
  fuse_flow::RigFrame frame;   // once: one Camera a view, from your calibration
  frame.cameras = my_cameras;  // intrinsics, distortion, T_world_camera
  frame.views.resize(frame.cameras.size());
  frame.views[0].depth16 = {depth_millimetres, 640, 480};  // const std::uint16_t*; a row stride in bytes may follow
  frame.views[0].color = {rgb, 640, 480};                  // const Rgb8*, three bytes a pixel: r, g, b; optional
  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  fusion.fuse(frame, cloud);  // position, colour, confidence, number of cameras
  const std::vector<std::size_t> absent = fusion.getStatistics().missing_cameras;  // the second and the third

  // Frame after frame.
  fuse_flow::FuseFlowParameters parameters;
  parameters.preprocessing.max_range = 4.0f;      // metres
  parameters.aggregation.min_cell_size = 0.016f;  // metres: a third of the points
  fusion.setParameters(parameters);
  bool good = absent.size() == 2;
  for (int instant = 0; instant < 2; ++instant) {
    for (std::size_t i = 0; i < frame.cameras.size(); ++i) {
      frame.views[i] = {};  // missing, unless a depth image has come
      if (!buffers[i].empty()) frame.views[i].depth16 = {buffers[i].data(), 640, 480};
    }
    fusion.fuse(frame, cloud);
    std::cout << cloud.size() << " points in " << fusion.getStatistics().total_ms << " ms\n";
    good = good && onBoardOrWall(cloud);
  }
  return good ? 0 : 1;
}
