// Each stage of the paper as a filter among PCL's own.
#include "scene.h"

#include <fuse_flow/filters/adaptive_hash_fusion.h>
#include <fuse_flow/filters/confidence_estimation.h>
#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/filters/multi_view_consistency.h>

#include <pcl/filters/passthrough.h>
#include <pcl/filters/statistical_outlier_removal.h>

#include <iostream>

using PointT = pcl::PointXYZRGB;
using Cloud = pcl::PointCloud<PointT>;

Cloud::Ptr passThrough(const Cloud::ConstPtr& input) {
  const Cloud::Ptr output(new Cloud);
  pcl::PassThrough<PointT> pass(true);
  pass.setInputCloud(input);
  pass.setFilterFieldName("z");
  pass.setFilterLimits(0.4f, 4.0f);
  pass.setKeepOrganized(true);  // confidence looks at a pixel's neighbours; PCL then wants the true above
  pass.filter(*output);
  return output;
}

Cloud::Ptr withoutOutliers(const Cloud::ConstPtr& input) {
  const Cloud::Ptr output(new Cloud);
  pcl::StatisticalOutlierRemoval<PointT> outliers;
  outliers.setInputCloud(input);
  outliers.setMeanK(12);
  outliers.setStddevMulThresh(3.0);
  outliers.filter(*output);
  return output;
}

// Eq. 2, 3, 9. In: organised, in the camera's frame. Out: the points with C > τ.
Cloud::Ptr confident(const Cloud::ConstPtr& input, float focal_length) {
  const Cloud::Ptr output(new Cloud);
  fuse_flow::ConfidenceEstimation<PointT> confidence(true);
  confidence.setInputCloud(input);
  confidence.setFocalLength(focal_length);  // pixels
  confidence.setKeepOrganized(true);
  confidence.filter(*output);
  return output;
}

// Eq. 8. In: organised, in the camera's frame. Out: organised, in the world's.
Cloud::Ptr inWorld(const Cloud::ConstPtr& input, const fuse_flow::Camera& camera) {
  const Cloud::Ptr output(new Cloud);
  fuse_flow::DepthBackprojection<PointT> backprojection;
  backprojection.setInputCloud(input);
  backprojection.setCamera(camera);
  backprojection.filter(*output);
  return output;
}

// Eq. 4–7. In: any cloud in the world frame. Out: the points that the other views do not contradict.
Cloud::Ptr consistent(const Cloud::ConstPtr& input, const fuse_flow::RigFrame& frame, int source_camera) {
  const Cloud::Ptr output(new Cloud);
  fuse_flow::MultiViewConsistency<PointT> consistency;
  consistency.setInputCloud(input);
  consistency.setFrame(frame, source_camera);
  consistency.setThreshold(0.1f);
  consistency.filter(*output);
  return output;
}

// Section 5. In: any cloud in the world frame. Out: one point a cell, as pcl::VoxelGrid, but cells follow the density.
Cloud::Ptr fused(const Cloud::ConstPtr& input) {
  const Cloud::Ptr output(new Cloud);
  fuse_flow::AggregationParameters cells;
  cells.min_cell_size = 0.01f;  // metres
  fuse_flow::AdaptiveHashFusion<PointT> fusion;
  fusion.setInputCloud(input);
  fusion.setParameters(cells);
  fusion.filter(*output);
  return output;
}

int main() {
  fuse_flow::RigFrame frame;
  frame.cameras = exampleCameras();
  std::vector<std::vector<std::uint16_t>> depths;
  for (const fuse_flow::Camera& camera : frame.cameras) depths.push_back(exampleDepth(camera));
  std::vector<Cloud::Ptr> clouds;  // as a grabber delivers them: organised, each in its camera's frame
  for (std::size_t i = 0; i < depths.size(); ++i) {
    frame.views.emplace_back();
    frame.views[i].depth16 = {depths[i].data(), 640, 480};
    fuse_flow::Camera at_origin = frame.cameras[i];
    at_origin.T_world_camera.setIdentity();
    fuse_flow::DepthBackprojection<PointT> grabber;
    grabber.setCamera(at_origin);
    grabber.setView(frame.views[i]);
    clouds.emplace_back(new Cloud);
    grabber.filter(*clouds.back());
  }

  bool good = true;
  const auto check = [&good](const char* name, const Cloud::ConstPtr& cloud) {
    const bool passes = onBoardOrWall(*cloud);
    std::cout << name << ": " << cloud->size() << " points" << (passes ? "\n" : ", wrong\n");
    good = good && passes;
  };
  const Cloud::ConstPtr cloud = clouds[0];
  const fuse_flow::Camera& camera = frame.cameras[0];

  // One filter alone, between two of PCL's.
  check("confidence", withoutOutliers(confident(passThrough(cloud), camera.intrinsics.fx)));
  check("back-projection", withoutOutliers(inWorld(passThrough(cloud), camera)));
  check("consistency", withoutOutliers(consistent(inWorld(passThrough(cloud), camera), frame, 0)));
  check("fusion", withoutOutliers(fused(passThrough(cloud))));

  // All of them.
  Cloud::Ptr all(new Cloud);
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    const fuse_flow::Camera& source = frame.cameras[i];
    const Cloud::Ptr trusted = confident(passThrough(clouds[i]), source.intrinsics.fx);
    *all += *consistent(inWorld(trusted, source), frame, static_cast<int>(i));
  }
  check("together", withoutOutliers(fused(all)));
  return good ? 0 : 1;
}
