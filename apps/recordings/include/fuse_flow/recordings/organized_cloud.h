#pragma once

#include <fuse_flow/recordings/recording.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A cloud with one point for each pixel, in the camera frame, as a sensor delivers it. */
using OrganizedCloud = pcl::PointCloud<pcl::PointXYZRGB>;

/** \brief Converts a view to a cloud, as its sensor would deliver it, without lens distortion. Its sensor pose is the origin, as PCL's
 *  filters expect for points in the sensor frame. */
void toOrganizedCloud(const Camera& camera, const DepthView& view, OrganizedCloud& cloud);

/** \brief Fits the camera that measured a cloud: intrinsics and distortion map its points to their pixels with least squares. Its pose is
 *  the sensor pose of the cloud. Throws InputError, beginning with the path, for a cloud that is not organised, or that no camera at its
 *  origin could see. \param path name of the cloud in messages; its stem is the name of the camera \param warnings receives a line if
 *  points do not project to their pixels; null: no warnings */
Camera cameraOf(const std::string& path, const OrganizedCloud& cloud, std::vector<std::string>* warnings = nullptr);

/** \brief The depth image of a cloud, and its colour image where has_color. */
void imagesOf(const OrganizedCloud& cloud, bool has_color, LoadedView& images);

}  // namespace fuse_flow::io
