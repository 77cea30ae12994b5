#include "../bindings.h"
#include "../plain.h"
#include "estimator.h"
#include "poses.h"

#include <fuse_flow/calibration/depth_correction_estimation.h>

#include <pybind11/stl.h>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

using CorrectionEstimator = EstimatorOf<DepthCorrectionEstimation, DepthCorrectionParameters>;

DepthCorrectionResult estimateCorrection(CorrectionEstimator& estimator, const std::optional<py::object>& initial,
                                         const std::optional<py::object>& refined) {
  if (!initial && refined)
    throw py::value_error(
        "fuse_flow.DepthCorrectionEstimation: refined poses are compared with initial ones, which are not given");
  if (!initial) return estimator.run([](auto& estimation) { return estimation.estimate(); });
  const auto begin = posesOf(*initial, "initial");
  if (!refined) return estimator.run([&](auto& estimation) { return estimation.estimate(begin); });
  const auto compared = posesOf(*refined, "refined");
  return estimator.run([&](auto& estimation) { return estimation.estimate(begin, compared); });
}

}  // namespace

void bindDepthCorrection(py::module_& module) {
  auto parameters =
      named<DepthCorrectionParameters, std::shared_ptr<DepthCorrectionParameters>>(module, "DepthCorrectionParameters");
  plain(parameters)
      .FUSE_FLOW_FIELD(DepthCorrectionParameters, views)
      .FUSE_FLOW_FIELD(DepthCorrectionParameters, columns)
      .FUSE_FLOW_FIELD(DepthCorrectionParameters, rows)
      .FUSE_FLOW_FIELD(DepthCorrectionParameters, shared)
      .FUSE_FLOW_FIELD(DepthCorrectionParameters, magnitude)
      .FUSE_FLOW_FIELD(DepthCorrectionParameters, roughness)
      .FUSE_FLOW_FIELD(DepthCorrectionParameters, pose_deviation)
      .FUSE_FLOW_FIELD(DepthCorrectionParameters, redundancy)
      .FUSE_FLOW_FIELD(DepthCorrectionParameters, effective_instants);
  named<DepthCorrectionResult>(module, "DepthCorrectionResult")
      .FUSE_FLOW_RESULT(DepthCorrectionResult, cameras)
      .FUSE_FLOW_RESULT(DepthCorrectionResult, observable)
      .FUSE_FLOW_RESULT(DepthCorrectionResult, residual_before)
      .FUSE_FLOW_RESULT(DepthCorrectionResult, residual)
      .FUSE_FLOW_RESULT(DepthCorrectionResult, correspondences)
      .FUSE_FLOW_RESULT(DepthCorrectionResult, residual_of_poses)
      .FUSE_FLOW_RESULT(DepthCorrectionResult, correspondences_of_poses)
      .FUSE_FLOW_RESULT(DepthCorrectionResult, compared)
      .FUSE_FLOW_RESULT(DepthCorrectionResult, iterations)
      .FUSE_FLOW_RESULT(DepthCorrectionResult, converged)
      .def("explains_more", &DepthCorrectionResult::explainsMore, py::arg("gain") = 0.05,
           doc("DepthCorrectionResult::explainsMore"));
  auto estimation =
      py::class_<CorrectionEstimator>(module, "DepthCorrectionEstimation", doc("DepthCorrectionEstimation"));
  bindEstimator<DepthCorrectionParameters>(estimation, "DepthCorrectionParameters",
                                           doc("DepthCorrectionEstimation::addFrame"))
      .def("estimate", &estimateCorrection, py::arg("initial") = py::none(), py::arg("refined") = py::none(),
           "Estimates corrections and poses. initial: (N, 4, 4), where the search begins; default the poses of the "
           "first frame. "
           "refined: (N, 4, 4), poses that ExtrinsicEstimation has found from depth without corrections, to compare "
           "with: see "
           "DepthCorrectionResult.explains_more().\n\nRaises RuntimeError without a frame.");
}

}  // namespace fuse_flow::python
