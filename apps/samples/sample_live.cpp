// Several grabbers, of any kind, synchronised by time stamp and fused as their clouds arrive.
//   sample_live FOLDER FOLDER …              organised PCD files, a folder a camera; its pose is its first file's VIEWPOINT
//   sample_live rig.json '#1' '#2' …         OpenNI2 devices, where PCL has them; a calibration goes before sources without poses
#include "clouds/grabber.h"

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/live/view_synchronizer.h>
#include <fuse_flow/point_types.h>
#include <fuse_flow/recordings/rig_json.h>

#include <pcl/io/pcd_grabber.h>
#ifdef HAVE_OPENNI2
#include <pcl/io/openni2_grabber.h>
#endif

#include <algorithm>
#include <filesystem>
#include <iostream>

namespace fs = std::filesystem;
using namespace fuse_flow;

std::unique_ptr<pcl::Grabber> openGrabber(const std::string& source) {
#ifdef HAVE_OPENNI2
  if (source[0] == '#') try {
      return std::make_unique<pcl::io::OpenNI2Grabber>(source);
    } catch (const std::exception&) {  // PCL tells where in its sources
      throw std::runtime_error(source + ": there is no such OpenNI2 device");
    }
#endif
  std::vector<std::string> files;
  std::error_code none;  // what is no folder has no files either
  for (const fs::directory_entry& entry : fs::directory_iterator(source, none))
    if (entry.path().extension() == ".pcd") files.push_back(entry.path().string());
  if (files.empty()) throw std::runtime_error(source + ": is no folder of .pcd files");
  std::sort(files.begin(), files.end());
  return std::make_unique<pcl::PCDGrabber<pcl::PointXYZRGB>>(files, 5.0f);  // frames per second
}

int main(int argc, char** argv) try {
  std::vector<std::string> sources(argv + 1, argv + argc);
  RigFrame frame;
  if (!sources.empty() && fs::path(sources[0]).extension() == ".json") {
    for (const io::RigCamera& calibrated : io::readRigJson(sources[0]).cameras)
      frame.cameras.push_back(calibrated.camera);
    sources.erase(sources.begin());
    if (frame.cameras.size() != sources.size())
      throw std::runtime_error("the calibration has not as many cameras as there are sources");
  }
  if (sources.empty()) throw std::runtime_error("usage: sample_live [rig.json] SOURCE SOURCE …");
  frame.cameras.resize(sources.size());
  frame.views.resize(sources.size());
  SynchronizerParameters parameters;
  parameters.max_wait = std::chrono::milliseconds(500);                      // above the period of the files, 200 ms
  if (fs::is_directory(sources[0])) parameters.clocks = ClockModel::Shared;  // devices have each its own
  ViewSynchronizer<io::OrganizedCloud::ConstPtr> synchronizer(sources.size(), parameters);
  std::vector<std::unique_ptr<pcl::Grabber>> grabbers;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    grabbers.push_back(openGrabber(sources[i]));
    io::connectGrabber(*grabbers[i],
                       [&synchronizer, i](std::uint64_t stamp, const io::OrganizedCloud::ConstPtr& cloud) {
                         synchronizer.push(i, stamp, cloud);
                       });
  }
  for (const auto& grabber : grabbers) grabber->start();
  const auto running = [](const auto& grabber) { return grabber->isRunning(); };
  const auto unknown = [](const Camera& camera) { return camera.intrinsics.width == 0; };
  FuseFlow<PointFused> fusion;
  pcl::PointCloud<PointFused> cloud;
  std::vector<io::LoadedView> images(sources.size());  // what the views of the frame point into
  for (;;) {
    const auto set = synchronizer.wait(std::chrono::seconds(1));
    if (!set && std::none_of(grabbers.begin(), grabbers.end(), running)) break;  // the files have been played
    if (!set) continue;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      frame.views[i] = {};
      if (!set->views[i]) continue;  // missing from this instant: the others are fused without it
      const io::OrganizedCloud& grabbed = *set->views[i]->payload;
      if (unknown(frame.cameras[i])) frame.cameras[i] = io::cameraOf(sources[i], grabbed);
      io::imagesOf(grabbed, true, images[i]);
      frame.views[i].depth32 = images[i].depth32.view();
      frame.views[i].color = images[i].color.view();
    }
    if (std::any_of(frame.cameras.begin(), frame.cameras.end(), unknown)) continue;  // until each has delivered once
    frame.stamp = set->stamp;
    fusion.fuse(frame, cloud);
    const std::size_t missing = fusion.getStatistics().missing_cameras.size();
    std::cout << set->stamp << " us: " << sources.size() - missing << " of " << sources.size() << " cameras, "
              << set->spread.count() << " us apart, " << cloud.size() << " points" << std::endl;
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const SynchronizerStatistics::Camera c = synchronizer.getStatistics().cameras[i];
    std::cout << sources[i] << ": " << c.received << " clouds, " << c.used << " fused; lost: " << c.unmatched
              << " unmatched, " << c.late << " late, " << c.overrun << " overrun\n";
  }
} catch (const std::exception& error) {
  std::cerr << "sample_live: " << error.what() << std::endl;
  return 1;
}
