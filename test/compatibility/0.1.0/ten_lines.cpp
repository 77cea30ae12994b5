#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

int main() {
  fuse_flow::Camera camera;                                            // of your calibration; distortion, too
  camera.intrinsics = {640, 480, 525.0f, 525.0f, 319.5f, 239.5f, {}};  // pixels
  camera.T_world_camera = Eigen::Translation3d(-0.1, 0, 0);            // metres; x right, y down, z forward
  std::vector<std::uint16_t> depth(640 * 480, 1000);                   // millimetres, row by row: what your SDK gives
  std::vector<fuse_flow::Rgb8> rgb(640 * 480, {200, 120, 40});         // three bytes a pixel: r, g, b

  fuse_flow::RigFrame frame;  // keep it, and fusion, from frame to frame
  frame.cameras = {camera};   // 2 to 50 of them
  frame.views.resize(frame.cameras.size());
  frame.views[0].depth16 = {depth.data(), 640, 480};  // a pointer, nothing is copied; a row stride may follow
  frame.views[0].color = {rgb.data(), 640, 480};      // optional
  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  fusion.fuse(frame, cloud);  // position, colour, confidence, number of cameras
}
