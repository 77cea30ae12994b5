#include "recordings/calibrations/calibration.h"
#include "recordings/files/pcd_file.h"
#include "recordings/range.h"
#include "recordings/readers/readers.h"

#include <fuse_flow/recordings/organized_cloud.h>

#include <pcl/common/io.h>
#include <pcl/conversions.h>

#include <filesystem>

namespace fuse_flow::io {
namespace {

class PcdRecording : public Recording {
 public:
  explicit PcdRecording(std::vector<std::string> paths) : paths_(std::move(paths)) {}

  void add(const std::string& path, bool read_color) {
    pcl::PCLPointCloud2 blob;
    OrganizedCloud cloud;
    const SensorPose pose = readPcd(path, blob);
    checkCloud(path, blob);
    {
      const SilencePcl silence;  // about the colour that the file may lack
      pcl::fromPCLPointCloud2(blob, cloud);
    }
    cloud.sensor_origin_ = pose.origin;
    cloud.sensor_orientation_ = pose.orientation;
    cameras_.push_back(cameraOf(path, cloud, &warnings_));
    checkCameraInput(path, cameras_.back());
    const bool has_color =
        read_color && (pcl::getFieldIndex(blob, "rgb") >= 0 || pcl::getFieldIndex(blob, "rgba") >= 0);
    imagesOf(cloud, has_color, images_.emplace_back());
  }

  std::string kind() const override { return "pcd"; }
  std::size_t frameCount() const override { return 1; }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  std::vector<std::string> inputs() const override { return paths_; }

  void read(std::size_t, LoadedFrame& out) override {
    out.images = images_;
    out.rig.cameras = cameras_;
    out.rig.stamp = 0;
    out.damaged.clear();
    out.rig.views.assign(cameras_.size(), DepthView());
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      out.rig.views[i].depth32 = out.images[i].depth32.view();
      out.rig.views[i].color = out.images[i].color.view();
    }
  }

 private:
  std::vector<std::string> paths_;
  std::vector<Camera> cameras_;
  std::vector<LoadedView> images_;
};

}  // namespace

bool isPcdFile(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return extension == ".pcd" || extension == ".PCD";
}

std::unique_ptr<Recording> openPcd(const std::vector<std::string>& paths, const RecordingOptions& options) {
  if (options.slide != 0) throw OptionError("--slide: " + paths[0] + ": PCD files are one instant, must be 0");
  if (options.depth_scale)
    throw OptionError("--depth-scale: " + paths[0] + ": points of PCD files are in metres, must not be given");
  if (!options.intrinsics.empty())
    throw OptionError("--intrinsics: " + paths[0] + ": the points of PCD files tell them, must not be given");
  std::vector<std::string> chosen = paths;
  if (!options.views.empty()) {
    chosen.clear();
    for (const std::size_t i : parseRange(options.views, paths.size(), "--views")) chosen.push_back(paths[i]);
  }
  auto recording = std::make_unique<PcdRecording>(paths);
  for (const std::string& path : chosen) recording->add(path, options.read_color);
  return recording;
}

}  // namespace fuse_flow::io
