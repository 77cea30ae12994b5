#include "../bindings.h"
#include "../calibration/poses.h"
#include "../plain.h"

#include <fuse_flow/fusion/parameters.h>

#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <optional>
#include <utility>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

using Corner = std::array<float, 3>;
using Corners = std::pair<Corner, Corner>;

py::object cropBoxOf(const FuseFlowParameters& parameters) {
  if (!parameters.crop_box) return py::none();
  const auto corner = [](const Eigen::Vector3f& p) { return readOnly(py::array_t<float>(3, p.data())); };
  return py::make_tuple(corner(parameters.crop_box->min()), corner(parameters.crop_box->max()));
}

void setCropBox(FuseFlowParameters& parameters, const std::optional<Corners>& corners) {
  parameters.crop_box.reset();
  if (!corners) return;
  const auto point = [](const Corner& p) { return Eigen::Vector3f(p[0], p[1], p[2]); };
  parameters.crop_box = Eigen::AlignedBox3f(point(corners->first), point(corners->second));
}

void bindForms(py::module_& module) {
  py::enum_<ConfidenceForm>(module, "ConfidenceForm", doc("ConfidenceForm"))
      .FUSE_FLOW_VALUE(ConfidenceForm, Published)
      .FUSE_FLOW_VALUE(ConfidenceForm, SlopeCompensated)
      .FUSE_FLOW_VALUE(ConfidenceForm, Given);
  py::enum_<OcclusionForm>(module, "OcclusionForm", doc("OcclusionForm"))
      .FUSE_FLOW_VALUE(OcclusionForm, Published)
      .FUSE_FLOW_VALUE(OcclusionForm, OcclusionAware);
  py::enum_<DistanceForm>(module, "DistanceForm", doc("DistanceForm"))
      .FUSE_FLOW_VALUE(DistanceForm, Euclidean)
      .FUSE_FLOW_VALUE(DistanceForm, AlongRay);
  py::enum_<Representatives>(module, "Representatives", doc("Representatives"))
      .FUSE_FLOW_VALUE(Representatives, HighestConfidence)
      .FUSE_FLOW_VALUE(Representatives, DifferentCameras)
      .FUSE_FLOW_VALUE(Representatives, CameraMeans);
  py::enum_<ConsistencyAt>(module, "ConsistencyAt", doc("ConsistencyAt"))
      .FUSE_FLOW_VALUE(ConsistencyAt, Representatives)
      .FUSE_FLOW_VALUE(ConsistencyAt, CellMean);
}

void bindSteps(py::module_& module) {
  auto preprocessing = named<PreprocessingParameters>(module, "PreprocessingParameters");
  plain(preprocessing)
      .FUSE_FLOW_FIELD(PreprocessingParameters, min_range)
      .FUSE_FLOW_FIELD(PreprocessingParameters, max_range)
      .FUSE_FLOW_FIELD(PreprocessingParameters, fill_neighbours)
      .FUSE_FLOW_FIELD(PreprocessingParameters, fill_tolerance)
      .FUSE_FLOW_FIELD(PreprocessingParameters, bilateral)
      .FUSE_FLOW_FIELD(PreprocessingParameters, bilateral_sigma_s)
      .FUSE_FLOW_FIELD(PreprocessingParameters, bilateral_sigma_r);
  auto smoothing = named<SmoothingParameters>(module, "SmoothingParameters");
  plain(smoothing)
      .FUSE_FLOW_FIELD(SmoothingParameters, passes)
      .FUSE_FLOW_FIELD(SmoothingParameters, tolerance)
      .FUSE_FLOW_FIELD(SmoothingParameters, shrink)
      .FUSE_FLOW_FIELD(SmoothingParameters, wide_above)
      .FUSE_FLOW_FIELD(SmoothingParameters, twicing)
      .FUSE_FLOW_FIELD(SmoothingParameters, twicing_above);
  auto confidence = named<ConfidenceParameters>(module, "ConfidenceParameters");
  plain(confidence)
      .FUSE_FLOW_FIELD(ConfidenceParameters, form)
      .FUSE_FLOW_FIELD(ConfidenceParameters, alpha)
      .FUSE_FLOW_FIELD(ConfidenceParameters, beta)
      .FUSE_FLOW_FIELD(ConfidenceParameters, gamma)
      .FUSE_FLOW_FIELD(ConfidenceParameters, delta)
      .FUSE_FLOW_FIELD(ConfidenceParameters, threshold)
      .FUSE_FLOW_FIELD(ConfidenceParameters, length_unit)
      .FUSE_FLOW_FIELD(ConfidenceParameters, noise)
      .FUSE_FLOW_FIELD(ConfidenceParameters, noise_reference)
      .FUSE_FLOW_FIELD(ConfidenceParameters, max_incidence);
  auto consistency = named<ConsistencyParameters>(module, "ConsistencyParameters");
  plain(consistency)
      .FUSE_FLOW_FIELD(ConsistencyParameters, occlusion)
      .FUSE_FLOW_FIELD(ConsistencyParameters, distance)
      .FUSE_FLOW_FIELD(ConsistencyParameters, sigma)
      .FUSE_FLOW_FIELD(ConsistencyParameters, sigma_per_noise)
      .FUSE_FLOW_FIELD(ConsistencyParameters, margin)
      .FUSE_FLOW_FIELD(ConsistencyParameters, free_space_penalty)
      .FUSE_FLOW_FIELD(ConsistencyParameters, weigh_contradictions)
      .FUSE_FLOW_FIELD(ConsistencyParameters, min_facing)
      .FUSE_FLOW_FIELD(ConsistencyParameters, silhouette_radius)
      .FUSE_FLOW_FIELD(ConsistencyParameters, max_views)
      .FUSE_FLOW_FIELD(ConsistencyParameters, max_candidates);
  auto aggregation = named<AggregationParameters>(module, "AggregationParameters");
  plain(aggregation)
      .FUSE_FLOW_FIELD(AggregationParameters, cell_size)
      .FUSE_FLOW_FIELD(AggregationParameters, min_cell_size)
      .FUSE_FLOW_FIELD(AggregationParameters, points_per_cell)
      .FUSE_FLOW_FIELD(AggregationParameters, representatives)
      .FUSE_FLOW_FIELD(AggregationParameters, consistency_at)
      .FUSE_FLOW_FIELD(AggregationParameters, min_weight)
      .FUSE_FLOW_FIELD(AggregationParameters, weak_weight)
      .FUSE_FLOW_FIELD(AggregationParameters, confirmation_reach)
      .FUSE_FLOW_FIELD(AggregationParameters, reach_per_noise);
  auto agreement = named<AgreementParameters>(module, "AgreementParameters");
  plain(agreement)
      .FUSE_FLOW_FIELD(AgreementParameters, min_views)
      .FUSE_FLOW_FIELD(AgreementParameters, pixels)
      .FUSE_FLOW_FIELD(AgreementParameters, relative);
}

}  // namespace

void bindParameters(py::module_& module) {
  bindForms(module);
  bindSteps(module);
  auto parameters = named<FuseFlowParameters, std::shared_ptr<FuseFlowParameters>>(module, "FuseFlowParameters");
  plain(parameters)
      .FUSE_FLOW_FIELD(FuseFlowParameters, preprocessing)
      .FUSE_FLOW_FIELD(FuseFlowParameters, smoothing)
      .FUSE_FLOW_FIELD(FuseFlowParameters, confidence)
      .FUSE_FLOW_FIELD(FuseFlowParameters, consistency)
      .FUSE_FLOW_FIELD(FuseFlowParameters, aggregation)
      .FUSE_FLOW_FIELD(FuseFlowParameters, adapt_noise)
      .FUSE_FLOW_FIELD(FuseFlowParameters, half_weight_noise)
      .FUSE_FLOW_FIELD(FuseFlowParameters, gate_noise)
      .FUSE_FLOW_FIELD(FuseFlowParameters, max_noise)
      .FUSE_FLOW_FIELD(FuseFlowParameters, min_support)
      .FUSE_FLOW_FIELD(FuseFlowParameters, min_confidence)
      .FUSE_FLOW_FIELD(FuseFlowParameters, agreement)
      .FUSE_FLOW_FIELD(FuseFlowParameters, use_measurement_confidence)
      .FUSE_FLOW_FIELD(FuseFlowParameters, use_distance_consistency)
      .FUSE_FLOW_FIELD(FuseFlowParameters, use_spatial_hash)
      .def_property("crop_box", &cropBoxOf, &setCropBox, doc("FuseFlowParameters::crop_box"))
      .def_static("published", &FuseFlowParameters::published, doc("FuseFlowParameters::published"))
      .def_static("estimated_depth", &FuseFlowParameters::estimatedDepth, doc("FuseFlowParameters::estimatedDepth"))
      .def(
          "check", [](const FuseFlowParameters& values) { checkParameters(values); },
          "Raises ValueError, naming the parameter and its value, if one is out of its range; fuse() does so too.");
}

}  // namespace fuse_flow::python
