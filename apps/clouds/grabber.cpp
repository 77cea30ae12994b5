#include "clouds/grabber.h"

#include <pcl/common/io.h>
#include <pcl/io/image.h>
#include <pcl/io/image_depth.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <type_traits>
#include <utility>

namespace fuse_flow::io {
namespace {

using FileNameCallback = void(const std::string&);

std::uint64_t arrivalTime() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

/** \brief "000000033333.pcd" → 33333; "corner.pcd" → the time of its arrival. */
std::uint64_t stampOfFile(const std::string& path) {
  const std::string stem = std::filesystem::path(path).stem().string();
  const bool number = !stem.empty() && stem.size() < 20 && stem.find_first_not_of("0123456789") == std::string::npos;
  return number ? std::stoull(stem) : arrivalTime();
}

template <typename PointT>
OrganizedCloud::ConstPtr converted(const typename pcl::PointCloud<PointT>::ConstPtr& cloud) {
  if constexpr (std::is_same_v<PointT, OrganizedCloud::PointType>) {
    return cloud;
  } else {
    const OrganizedCloud::Ptr copy(new OrganizedCloud);
    pcl::copyPointCloud(*cloud, *copy);
    return copy;
  }
}

template <typename PointT>
bool connectAs(pcl::Grabber& grabber, const CloudReceiver& receive) {
  using CloudCallback = void(const typename pcl::PointCloud<PointT>::ConstPtr&);
  if (!grabber.providesCallback<CloudCallback>()) return false;
  const bool tells_files = grabber.providesCallback<FileNameCallback>();
  const auto unnamed =
      std::make_shared<OrganizedCloud::ConstPtr>();  // until its file's name follows, in the same thread
  const std::function<CloudCallback> on_cloud = [=](const typename pcl::PointCloud<PointT>::ConstPtr& cloud) {
    if (tells_files && cloud->header.stamp == 0)
      *unnamed = converted<PointT>(cloud);
    else
      receive(cloud->header.stamp ? cloud->header.stamp : arrivalTime(), converted<PointT>(cloud));
  };
  grabber.registerCallback(on_cloud);
  if (!tells_files) return true;
  const std::function<FileNameCallback> on_file = [=](const std::string& path) {
    if (*unnamed) receive(stampOfFile(path), std::exchange(*unnamed, nullptr));
  };
  grabber.registerCallback(on_file);
  return true;
}

std::shared_ptr<const LoadedView> imagesOf(const pcl::io::DepthImage& depth, const pcl::io::Image* color) {
  const unsigned int width = depth.getWidth(), height = depth.getHeight();
  const auto images = std::make_shared<LoadedView>();
  images->depth16.resize(static_cast<int>(width), static_cast<int>(height));
  depth.fillDepthImageRaw(width, height, images->depth16.data.data());
  const auto unmeasured = [&](std::uint16_t z) { return z == depth.getShadowValue() || z == depth.getNoSampleValue(); };
  std::replace_if(images->depth16.data.begin(), images->depth16.data.end(), unmeasured, 0);
  const auto fits = [&] {
    return (color->getWidth() == width && color->getHeight() == height) ||
           color->isResizingSupported(color->getWidth(), color->getHeight(), width, height);
  };
  if (color && fits()) {
    images->color.resize(static_cast<int>(width), static_cast<int>(height));
    color->fillRGB(width, height, &images->color.data[0].r);
  }
  return images;
}

}  // namespace

void connectDepthGrabber(pcl::Grabber& grabber, const ImageReceiver& receive) {
  using PairCallback = void(const pcl::io::Image::Ptr&, const pcl::io::DepthImage::Ptr&, float);
  using DepthCallback = void(const pcl::io::DepthImage::Ptr&);
  const auto deliver = [receive](const pcl::io::DepthImage& depth, const pcl::io::Image* color) {
    receive(depth.getTimestamp() ? depth.getTimestamp() : arrivalTime(), imagesOf(depth, color));
  };
  if (grabber.providesCallback<PairCallback>()) {
    const std::function<PairCallback> on_pair =
        [deliver](const pcl::io::Image::Ptr& color, const pcl::io::DepthImage::Ptr& depth,
                  float /*reciprocal_focal_length*/) { deliver(*depth, color.get()); };
    grabber.registerCallback(on_pair);
  } else if (grabber.providesCallback<DepthCallback>()) {
    const std::function<DepthCallback> on_depth = [deliver](const pcl::io::DepthImage::Ptr& depth) {
      deliver(*depth, nullptr);
    };
    grabber.registerCallback(on_depth);
  } else {
    throw InputError(grabber.getName() + ": delivers no depth images");
  }
}

void connectGrabber(pcl::Grabber& grabber, const CloudReceiver& receive) {
  if (!connectAs<pcl::PointXYZRGB>(grabber, receive) && !connectAs<pcl::PointXYZRGBA>(grabber, receive) &&
      !connectAs<pcl::PointXYZI>(grabber, receive) && !connectAs<pcl::PointXYZ>(grabber, receive))
    throw InputError(grabber.getName() + ": delivers no clouds, must deliver points with x, y, z");
}

}  // namespace fuse_flow::io
