#pragma once

#include <fuse_flow/recordings/recording.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A point for each pixel, in its camera's frame, as a sensor delivers it. */
using OrganizedCloud = pcl::PointCloud<pcl::PointXYZRGB>;

/** \brief What a view's sensor would deliver as a cloud, without the lens's distortion; its sensor pose is the origin, as PCL's
 *  filters expect of points in the sensor's frame. */
void toOrganizedCloud(const Camera& camera, const DepthView& view, OrganizedCloud& cloud);

/** \brief The camera that measured a cloud: intrinsics and distortion that map its points to their pixels with the least squares;
 *  its pose is the cloud's sensor pose. Throws InputError, beginning with the path, for a cloud that is not organised, or that no
 *  camera at its origin sees so.  \param path what messages call it; its stem names the camera
 *  \param warnings gets a line where points come back beside their places; null: nobody reads it */
Camera cameraOf(const std::string& path, const OrganizedCloud& cloud, std::vector<std::string>* warnings = nullptr);

/** \brief The depth image of a cloud, and its colour image where has_color. */
void imagesOf(const OrganizedCloud& cloud, bool has_color, LoadedView& images);

}  // namespace fuse_flow::io
