// A project that uses the library from outside: two cameras look at a wall, one metre away.
#include <fuse_flow/filters/adaptive_hash_fusion.h>
#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <cmath>
#include <iostream>

#if !__has_include(<fuse_flow/gpu/fuse_flow.h>)
#error "the GPU classes are not among the headers"
#endif

int main() {
  const std::vector<std::uint16_t> wall(64 * 48, 1000);
  fuse_flow::RigFrame frame;
  for (const double x : {-0.05, 0.05}) {
    fuse_flow::Camera camera;
    camera.name = x < 0 ? "left" : "right";
    camera.intrinsics = {64, 48, 60.0f, 60.0f, 31.5f, 23.5f, {}};
    camera.T_world_camera.translation().x() = x;
    frame.cameras.push_back(camera);
    fuse_flow::DepthView view;
    view.depth16 = {wall.data(), 64, 48};
    frame.views.push_back(view);
  }
  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  fusion.fuse(frame, cloud);
  std::cout << cloud.size() << " points\n";
  bool on_the_wall = cloud.size() > 100;

  // A filter by itself, over a point type that PCL knows nothing of, must link too.
  fuse_flow::AdaptiveHashFusion<fuse_flow::PointFused> filter;
  filter.setInputCloud(cloud.makeShared());
  filter.filter(cloud);
  on_the_wall = on_the_wall && !cloud.empty();
  for (const auto& point : cloud) on_the_wall = on_the_wall && std::abs(point.z - 1.0f) < 1e-4f;
  return on_the_wall ? 0 : 1;
}
