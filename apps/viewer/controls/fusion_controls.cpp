#include "viewer/controls/fusion_controls.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::viewing {
namespace {

bool& switchOf(FuseFlowParameters& parameters, Component component) {
  if (component == Component::MeasurementConfidence) return parameters.use_measurement_confidence;
  if (component == Component::DistanceConsistency) return parameters.use_distance_consistency;
  return parameters.use_spatial_hash;
}

std::string titleOf(const std::string& method, const io::MethodOptions& options) {
  if (method == "fuse_flow") return "FUSE-Flow";
  if (method == kStreamed) return "streamed";
  if (method == "concatenate") return "concatenated";
  const std::string leaf = ", " + std::to_string(std::lround(1000 * options.leaf_size)) + " mm";
  if (method == "voxel_grid") return "pcl::VoxelGrid" + leaf;
  if (method == "approximate_voxel_grid") return "pcl::ApproximateVoxelGrid" + leaf;
  return "outlier removal, pcl::VoxelGrid" + leaf;
}

FusionSettingPtr makeSetting(const std::string& title, const std::string& method, const io::MethodOptions& options) {
  return std::make_shared<FusionSetting>(FusionSetting{title, method, options});
}

}  // namespace

bool uses(const FuseFlowParameters& parameters, Component component) {
  FuseFlowParameters copy = parameters;
  return switchOf(copy, component);
}

FusionControls::FusionControls(const std::string& method, const io::MethodOptions& options)
    : method_(method), options_(options), initial_(options), kept_(options) {
  update();
}

void FusionControls::update() { fused_ = makeSetting(titleOf(method_, options_), method_, options_); }

void FusionControls::toggle(Component component) {
  change([component](FuseFlowParameters& p) { switchOf(p, component) = !switchOf(p, component); });
}

void FusionControls::change(const std::function<void(FuseFlowParameters&)>& apply) {
  const std::optional<Eigen::AlignedBox3f> box = options_.parameters.crop_box;
  apply(options_.parameters);
  update();
  const std::optional<Eigen::AlignedBox3f>& now = options_.parameters.crop_box;
  const bool same_box = box.has_value() == now.has_value() && (!box || box->isApprox(*now, 0.0f));
  if (!same_box) updateComparison();
}

void FusionControls::reset() {
  change([this](FuseFlowParameters& p) {
    const std::optional<Eigen::AlignedBox3f> box = p.crop_box;
    p = initial_.parameters;
    p.crop_box = box;
  });
}

const std::vector<std::string>& FusionControls::comparisonNames() {
  static const std::vector<std::string> names{"none",      "concatenate",     "voxel_grid", "approximate_voxel_grid",
                                              "published", "outlier_removal", "kept"};
  return names;
}

void FusionControls::compareWith(const std::string& name) {
  compared_with_ = name;
  updateComparison();
}

void FusionControls::compareWithNext() {
  const std::vector<std::string>& names = comparisonNames();
  const auto at = std::find(names.begin(), names.end(), compared_with_);
  compareWith(at + 1 == names.end() ? names.front() : *(at + 1));
}

void FusionControls::keep() {
  kept_ = options_;
  compareWith("kept");
}

void FusionControls::updateComparison() {
  const std::optional<Eigen::AlignedBox3f>& box = options_.parameters.crop_box;
  io::MethodOptions options = compared_with_ == "kept" ? kept_ : initial_;
  if (compared_with_ == "none") {
    comparison_.reset();
    return;
  }
  if (compared_with_ == "published") {
    const PreprocessingParameters preprocessing = options.parameters.preprocessing;
    options.parameters = FuseFlowParameters::published();
    options.parameters.preprocessing = preprocessing;  // of the sensor: ranges, holes
  }
  options.parameters.crop_box = box;
  if (compared_with_ == "published")
    comparison_ = makeSetting("FUSE-Flow, published forms", "fuse_flow", options);
  else if (compared_with_ == "kept")
    comparison_ = makeSetting(titleOf(method_, options) + ", kept setting", method_, options);
  else {
    options.device = "cpu";
    comparison_ = makeSetting(titleOf(compared_with_, options), compared_with_, options);
  }
}

}  // namespace fuse_flow::viewing
