// The library's filters one by one, in a pipeline of PCL's: between PassThrough and StatisticalOutlierRemoval.
//   sample_pcl_pipeline RECORDING fused.pcd

#include <fuse_flow/filters/adaptive_hash_fusion.h>
#include <fuse_flow/filters/confidence_estimation.h>
#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/filters/multi_view_consistency.h>
#include <fuse_flow/recordings/input_files.h>
#include <fuse_flow/recordings/organized_cloud.h>

#include <pcl/common/point_tests.h>
#include <pcl/filters/passthrough.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/io/pcd_io.h>

#include <iostream>
#include <memory>

using PointT = pcl::PointXYZRGB;
using Cloud = pcl::PointCloud<PointT>;

/** \brief Filters a cloud, in place, and says what is left of it. */
void apply(pcl::Filter<PointT>& filter, const char* name, const Cloud::Ptr& cloud) {
  filter.setInputCloud(cloud);
  filter.filter(*cloud);
  std::size_t finite = 0;  // an organised cloud keeps a place for every pixel
  for (const PointT& point : *cloud) finite += pcl::isFinite(point) ? 1 : 0;
  std::cout << "  " << name << ": " << finite << " points\n";
}

int main(int argc, char** argv) try {
  if (argc != 3) throw std::runtime_error("usage: sample_pcl_pipeline RECORDING OUTPUT.pcd");
  fuse_flow::io::LoadedFrame loaded;
  const std::unique_ptr<fuse_flow::io::Recording> recording = fuse_flow::io::openRecording({argv[1]});
  fuse_flow::io::InputFiles(recording->inputs()).refuseToReplace("OUTPUT.pcd", argv[2]);
  recording->read(0, loaded);
  const fuse_flow::RigFrame& frame = loaded.rig;

  Cloud::Ptr all(new Cloud);
  for (std::size_t i = 0; i < frame.cameras.size(); ++i) {
    if (frame.views[i].missing()) continue;
    std::cout << frame.cameras[i].name << "\n";
    const Cloud::Ptr cloud(new Cloud);  // as a grabber delivers it: organised, in the camera's frame
    fuse_flow::io::toOrganizedCloud(frame.cameras[i], frame.views[i], *cloud);

    pcl::PassThrough<PointT> pass(
        true);  // true, because PCL keeps clouds organised only where it lists what it removes
    pass.setFilterFieldName("z");
    pass.setFilterLimits(0.4f, 5.0f);  // metres
    pass.setKeepOrganized(true);       // the next filter looks at a pixel's neighbours
    apply(pass, "PassThrough", cloud);

    fuse_flow::ConfidenceEstimation<PointT> confidence(true);  // removes edges, holes, noise
    confidence.setFocalLength(frame.cameras[i].intrinsics.fx);
    confidence.setKeepOrganized(true);
    apply(confidence, "ConfidenceEstimation", cloud);

    fuse_flow::DepthBackprojection<PointT> backprojection;  // to the world frame
    backprojection.setCamera(frame.cameras[i]);
    apply(backprojection, "DepthBackprojection", cloud);

    fuse_flow::MultiViewConsistency<PointT> consistency;  // removes what the other cameras see through
    consistency.setFrame(frame, static_cast<int>(i));
    apply(consistency, "MultiViewConsistency", cloud);
    *all += *cloud;
  }

  std::cout << "together: " << all->size() << " points\n";
  fuse_flow::AdaptiveHashFusion<PointT> fusion;  // in place of pcl::VoxelGrid
  apply(fusion, "AdaptiveHashFusion", all);
  pcl::StatisticalOutlierRemoval<PointT> outliers;
  outliers.setMeanK(12);
  outliers.setStddevMulThresh(3.0);
  apply(outliers, "StatisticalOutlierRemoval", all);
  return pcl::io::savePCDFileBinary(argv[2], *all) == 0 ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << "sample_pcl_pipeline: " << error.what() << std::endl;
  return 1;
}
