#include "../bindings.h"
#include "../plain.h"
#include "estimator.h"
#include "poses.h"

#include <fuse_flow/calibration/coarse_alignment.h>

#include <pybind11/stl.h>

namespace fuse_flow::python {

void bindCoarseAlignment(pybind11::module_& module) {
  namespace py = pybind11;
  using Estimator = EstimatorOf<CoarseAlignment, CoarseAlignmentParameters>;
  py::enum_<Placement>(module, "Placement", doc("Placement"))
      .FUSE_FLOW_VALUE(Placement, Missing)
      .FUSE_FLOW_VALUE(Placement, Alone)
      .FUSE_FLOW_VALUE(Placement, Ambiguous)
      .FUSE_FLOW_VALUE(Placement, Placed);
  auto parameters =
      named<CoarseAlignmentParameters, std::shared_ptr<CoarseAlignmentParameters>>(module, "CoarseAlignmentParameters");
  plain(parameters)
      .FUSE_FLOW_FIELD(CoarseAlignmentParameters, preprocessing)
      .FUSE_FLOW_FIELD(CoarseAlignmentParameters, noise)
      .FUSE_FLOW_FIELD(CoarseAlignmentParameters, samples)
      .FUSE_FLOW_FIELD(CoarseAlignmentParameters, cell_size)
      .FUSE_FLOW_FIELD(CoarseAlignmentParameters, tolerance)
      .FUSE_FLOW_FIELD(CoarseAlignmentParameters, max_roll)
      .FUSE_FLOW_FIELD(CoarseAlignmentParameters, use_color)
      .FUSE_FLOW_FIELD(CoarseAlignmentParameters, hypotheses)
      .FUSE_FLOW_FIELD(CoarseAlignmentParameters, min_score)
      .FUSE_FLOW_FIELD(CoarseAlignmentParameters, max_ambiguity);
  named<ViewAgreement>(module, "ViewAgreement")
      .FUSE_FLOW_RESULT(ViewAgreement, confirmed)
      .FUSE_FLOW_RESULT(ViewAgreement, unlike)
      .FUSE_FLOW_RESULT(ViewAgreement, contradicted)
      .FUSE_FLOW_RESULT(ViewAgreement, color_spread)
      .FUSE_FLOW_RESULT(ViewAgreement, color_evidence)
      .FUSE_FLOW_RESULT(ViewAgreement, likeness)
      .def_property_readonly("score", &ViewAgreement::score, doc("ViewAgreement::score"));
  named<CoarseOverlap>(module, "CoarseOverlap")
      .FUSE_FLOW_RESULT(CoarseOverlap, first)
      .FUSE_FLOW_RESULT(CoarseOverlap, second)
      .FUSE_FLOW_RESULT(CoarseOverlap, agreement);
  named<CoarseAlignmentResult>(module, "CoarseAlignmentResult")
      .def_property_readonly(
          "T_world_camera", [](const CoarseAlignmentResult& r) { return matricesOf(r.T_world_camera); },
          doc("CoarseAlignmentResult::T_world_camera"))
      .FUSE_FLOW_RESULT(CoarseAlignmentResult, placements)
      .FUSE_FLOW_RESULT(CoarseAlignmentResult, groups)
      .FUSE_FLOW_RESULT(CoarseAlignmentResult, overlaps)
      .def_property_readonly("complete", &CoarseAlignmentResult::complete, doc("CoarseAlignmentResult::complete"));
  auto alignment = py::class_<Estimator>(module, "CoarseAlignment", doc("CoarseAlignment"));
  bindEstimator<CoarseAlignmentParameters>(alignment, "CoarseAlignmentParameters", doc("CoarseAlignment::addFrame"))
      .def(
          "estimate", [](Estimator& estimator) { return estimator.run([](auto& found) { return found.estimate(); }); },
          doc("CoarseAlignment::estimate"));
}

}  // namespace fuse_flow::python
