// One fused frame, and the cameras that measured it, in a PCLVisualizer.
//   sample_visualize RECORDING                  in a window; q ends it, PCL's other keys work as ever
//   sample_visualize RECORDING picture.png      into a picture
#include "drawing/display.h"

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/recordings/input_files.h>
#include <fuse_flow/recordings/recording.h>

#include <pcl/point_types.h>
#include <pcl/visualization/pcl_visualizer.h>
#include <vtkObject.h>
#include <vtkRenderWindow.h>

#include <iostream>
#include <memory>

using Cloud = pcl::PointCloud<pcl::PointXYZRGB>;

int main(int argc, char** argv) try {
  if (argc != 2 && argc != 3) throw std::runtime_error("usage: sample_visualize RECORDING [PICTURE.png]");
  fuse_flow::drawing::requireDisplay("sample_visualize");

  fuse_flow::io::LoadedFrame loaded;
  const std::unique_ptr<fuse_flow::io::Recording> recording = fuse_flow::io::openRecording({argv[1]});
  if (argc == 3) fuse_flow::io::InputFiles(recording->inputs()).refuseToReplace("PICTURE.png", argv[2]);
  recording->read(0, loaded);
  const Cloud::Ptr cloud(new Cloud);
  fuse_flow::FuseFlow<pcl::PointXYZRGB> fusion;  // any PCL point: one with rgb has colour fused
  fusion.fuse(loaded.rig, *cloud);

  vtkObject::GlobalWarningDisplayOff();  // PCL calls what VTK 9 deprecates, and VTK says so for every actor
  pcl::visualization::PCLVisualizer viewer("FUSE-Flow");
  viewer.setSize(1280, 720);
  viewer.setBackgroundColor(0.08, 0.09, 0.11);
  viewer.addPointCloud<pcl::PointXYZRGB>(cloud, "fused");
  viewer.setPointCloudRenderingProperties(pcl::visualization::PCL_VISUALIZER_POINT_SIZE, 3, "fused");
  viewer.setShowFPS(false);
  for (const fuse_flow::Camera& camera : loaded.rig.cameras)
    viewer.addCoordinateSystem(0.2, camera.T_world_camera.cast<float>(), camera.name);

  // From above and behind the first camera.
  const Eigen::Isometry3d& T = loaded.rig.cameras.front().T_world_camera;
  const Eigen::Vector3d eye = T * Eigen::Vector3d(0.4, -0.4, -1.8);
  const Eigen::Vector3d at = T * Eigen::Vector3d(0, 0, 2);
  const Eigen::Vector3d up = -T.linear().col(1);
  viewer.setCameraPosition(eye.x(), eye.y(), eye.z(), at.x(), at.y(), at.z(), up.x(), up.y(), up.z());
  viewer.setCameraClipDistances(0.01, 100);

  std::cout << cloud->size() << " points from " << loaded.rig.cameras.size() << " cameras" << std::endl;
  if (argc == 3) {
    viewer.getRenderWindow()->Render();
    viewer.saveScreenshot(argv[2]);
    return 0;
  }
  viewer.spin();  // spinOnce() of PCL 1.12 does not get on with VTK 9.1
  return 0;
} catch (const std::exception& error) {
  std::cerr << "sample_visualize: " << error.what() << std::endl;
  return 1;
}
