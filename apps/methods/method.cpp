#include "methods/method.h"

#include "methods/cpu_fallback.h"
#include "methods/fusion_method.h"
#include "methods/fusion_with_normals.h"
#include "methods/gpu_method.h"
#include "methods/instances.h"

#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/recordings/error.h>

#include <pcl/common/common.h>
#include <pcl/filters/approximate_voxel_grid.h>
#include <pcl/filters/impl/approximate_voxel_grid.hpp>
#include <pcl/filters/impl/filter_indices.hpp>
#include <pcl/filters/impl/statistical_outlier_removal.hpp>
#include <pcl/filters/impl/voxel_grid.hpp>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/filters/voxel_grid.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <sstream>
#include <type_traits>

namespace fuse_flow {

// See instances.h.
template class FuseFlow<PointFused>;
template ReprojectionQuality reprojectionQuality(const pcl::PointCloud<PointFused>&, const RigFrame&,
                                                 const ReprojectionQualityParameters&, unsigned int);
template ReprojectionQuality reprojectionQuality(const pcl::PointCloud<pcl::PointXYZ>&, const RigFrame&,
                                                 const ReprojectionQualityParameters&, unsigned int);
template SurfaceQuality surfaceQuality(const pcl::PointCloud<PointFused>&, const RigFrame&,
                                       const SurfaceQualityParameters&, unsigned int);
template SurfaceQuality surfaceQuality(const pcl::PointCloud<pcl::PointXYZ>&, const RigFrame&,
                                       const SurfaceQualityParameters&, unsigned int);
template TemporalFlicker temporalFlicker(const pcl::PointCloud<PointFused>&, const RigFrame&,
                                         const pcl::PointCloud<PointFused>&, const RigFrame&,
                                         const SurfaceQualityParameters&, unsigned int);
template TemporalFlicker temporalFlicker(const pcl::PointCloud<pcl::PointXYZ>&, const RigFrame&,
                                         const pcl::PointCloud<pcl::PointXYZ>&, const RigFrame&,
                                         const SurfaceQualityParameters&, unsigned int);
// Compiled in recordings/instances.cpp.
extern template class DepthBackprojection<pcl::PointXYZRGB>;

}  // namespace fuse_flow

namespace fuse_flow::io {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - begin).count();
}

/** \brief PCL's route: every view back-projected, all in one cloud, and perhaps a grid over it. The peers see the same
 *  ranges and crop box. */
class Concatenation : public Method {
 public:
  explicit Concatenation(const MethodOptions& options) : options_(options) {
    backprojection_.setParameters(options.parameters.preprocessing);
    backprojection_.setNumberOfThreads(options.threads);
  }

  void fuse(const RigFrame& frame, Cloud& output) override {
    checkRigFrame(frame);
    const Clock::time_point start = Clock::now();
    statistics_ = {};
    check_ms_ = 0;
    const auto all = std::make_shared<pcl::PointCloud<pcl::PointXYZRGB>>();
    std::size_t pixels = 0;
    for (const DepthView& view : frame.views)
      pixels += static_cast<std::size_t>(view.width()) * static_cast<std::size_t>(view.height());
    all->reserve(pixels);
    for (std::size_t i = 0; i < frame.cameras.size(); ++i) {
      if (frame.views[i].missing()) {
        statistics_.missing_cameras.push_back(i);
        continue;
      }
      backprojection_.setCamera(frame.cameras[i]);
      backprojection_.setView(frame.views[i]);
      backprojection_.filter(view_cloud_);
      for (const pcl::PointXYZRGB& p : view_cloud_) {
        if (!std::isfinite(p.z)) continue;
        ++statistics_.measured_points;
        const auto& box = options_.parameters.crop_box;
        if (!box || box->contains(Eigen::Vector3f(p.x, p.y, p.z))) all->push_back(p);
      }
    }
    statistics_.gated_points = all->size();
    const Clock::time_point generated = Clock::now();
    statistics_.generate_ms = milliseconds(start, generated);
    thin(all);
    const Clock::time_point thinned = Clock::now();
    statistics_.fuse_ms = milliseconds(generated, thinned) - check_ms_;
    output.clear();
    output.reserve(thinned_.size());
    for (const pcl::PointXYZRGB& p : thinned_) {
      PointFused& q = output.emplace_back();
      q.x = p.x;
      q.y = p.y;
      q.z = p.z;
      q.rgba = p.rgba;
      q.confidence = 1.0f;
      q.view_count = 1;
    }
    output.header.stamp = frame.stamp;
    statistics_.fused_points = output.size();
    const Clock::time_point end = Clock::now();
    statistics_.output_ms = milliseconds(thinned, end);
    statistics_.total_ms = milliseconds(start, end) - check_ms_;
  }

 protected:
  virtual void thin(const pcl::PointCloud<pcl::PointXYZRGB>::Ptr& all) { thinned_ = std::move(*all); }

  MethodOptions options_;
  pcl::PointCloud<pcl::PointXYZRGB> thinned_;
  double check_ms_{0};  ///< of the last frame: what only the tools ask for

 private:
  DepthBackprojection<pcl::PointXYZRGB> backprojection_;
  pcl::PointCloud<pcl::PointXYZRGB> view_cloud_;
};

template <typename Grid>
class GridOfConcatenation : public Concatenation {
 public:
  using Concatenation::Concatenation;

 protected:
  void thin(const pcl::PointCloud<pcl::PointXYZRGB>::Ptr& all) override {
    if (all->empty()) {
      thinned_.clear();
      return;
    }
    const Clock::time_point unchecked = Clock::now();
    checkCells(*all);
    check_ms_ = milliseconds(unchecked, Clock::now());
    Grid grid;
    grid.setInputCloud(withoutOutliers(all));
    grid.setLeafSize(options_.leaf_size, options_.leaf_size, options_.leaf_size);
    grid.filter(thinned_);
  }

  virtual pcl::PointCloud<pcl::PointXYZRGB>::Ptr withoutOutliers(const pcl::PointCloud<pcl::PointXYZRGB>::Ptr& all) {
    return all;
  }

 private:
  /** \brief Both grids number cells with 32 bits. Out of numbers pcl::VoxelGrid prints a warning and thins nothing;
   *  pcl::ApproximateVoxelGrid's hash, 7171 i + 3079 j + 4231 k, overflows. */
  void checkCells(const pcl::PointCloud<pcl::PointXYZRGB>& all) const {
    constexpr bool exact = std::is_same_v<Grid, pcl::VoxelGrid<pcl::PointXYZRGB>>;
    pcl::PointXYZRGB low, high;
    pcl::getMinMax3D(all, low, high);
    const Eigen::Array3d least = low.getArray3fMap().cast<double>(), most = high.getArray3fMap().cast<double>();
    const double per_leaf = 1.0 / static_cast<double>(options_.leaf_size);
    const double numbers =
        exact ? ((most - least) * per_leaf + 1).prod()
              : ((least.abs().max(most.abs()) * per_leaf + 1) * Eigen::Array3d(7171, 3079, 4231)).sum();
    if (numbers < std::numeric_limits<std::int32_t>::max()) return;
    std::ostringstream message;
    message << "--leaf-size is " << options_.leaf_size << ", too small for a cloud from (" << least.transpose()
            << ") to (" << most.transpose() << ") m: " << (exact ? "pcl::VoxelGrid" : "pcl::ApproximateVoxelGrid")
            << " numbers its cells with 32 bits";
    throw OptionError(message.str());
  }
};

using VoxelGridOfConcatenation = GridOfConcatenation<pcl::VoxelGrid<pcl::PointXYZRGB>>;

class OutlierRemoval : public VoxelGridOfConcatenation {
 public:
  using VoxelGridOfConcatenation::VoxelGridOfConcatenation;

 protected:
  pcl::PointCloud<pcl::PointXYZRGB>::Ptr withoutOutliers(const pcl::PointCloud<pcl::PointXYZRGB>::Ptr& all) override {
    pcl::StatisticalOutlierRemoval<pcl::PointXYZRGB> filter;
    filter.setInputCloud(all);
    filter.setMeanK(16);
    filter.setStddevMulThresh(1.0);
    const auto kept = std::make_shared<pcl::PointCloud<pcl::PointXYZRGB>>();
    filter.filter(*kept);
    return kept;
  }
};

}  // namespace

std::unique_ptr<Method> makeMethod(const std::string& name, const MethodOptions& options) {
  if (name != "fuse_flow" && options.device == "gpu")
    throw OptionError("--device gpu: --method " + name + " runs on the CPU only");
  if (name != "fuse_flow" && options.normals) throw OptionError("--normals: --method " + name + " has none");
  if (name != "fuse_flow" && options.camera_mask)
    throw OptionError("--camera-mask: --method " + name + " does not know which cameras a point is from");
  if (name == "fuse_flow") {
    if (runsOnGpu(options.device)) {
      if (options.device == "gpu" || !options.warn) return makeGpuFusion(options);  // nobody would know
      MethodOptions on_cpu = options;
      on_cpu.device = "cpu";
      return std::make_unique<CpuFallback>([&] { return makeGpuFusion(options); },
                                           [on_cpu] { return makeMethod("fuse_flow", on_cpu); }, options.warn);
    }
    if (options.morePerPoint()) return std::make_unique<FusionWithNormals<FuseFlow<PointFusedNormal>>>(options);
    return std::make_unique<FusionMethod<FuseFlow<PointFused>>>(options);
  }
  if (name == "concatenate") return std::make_unique<Concatenation>(options);
  if (name == "voxel_grid") return std::make_unique<VoxelGridOfConcatenation>(options);
  if (name == "outlier_removal") return std::make_unique<OutlierRemoval>(options);
  if (name == "approximate_voxel_grid")
    return std::make_unique<GridOfConcatenation<pcl::ApproximateVoxelGrid<pcl::PointXYZRGB>>>(options);
  throw InputError("--method " + name +
                   ": must be fuse_flow, concatenate, voxel_grid, approximate_voxel_grid or outlier_removal");
}

}  // namespace fuse_flow::io
