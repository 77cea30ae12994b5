#include "bindings.h"
#include "frames.h"
#include "fusion/in_flight.h"
#include "plain.h"
#include "point_arrays.h"

#include <fuse_flow/quality/reprojection_quality.h>
#include <fuse_flow/quality/surface_quality.h>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

ReprojectionQuality qualityOfReprojection(const py::object& points, const FrameLists& frame,
                                          const ReprojectionQualityParameters& parameters, unsigned int threads) {
  const auto cloud = cloudOf(points);
  const FrameInput input(frame);
  const InFlight in_flight;
  return reprojectionQuality(cloud, input.frame, parameters, threads);
}

SurfaceQuality qualityOfSurface(const py::object& points, const FrameLists& frame,
                                const SurfaceQualityParameters& parameters, unsigned int threads) {
  const auto cloud = cloudOf(points);
  const FrameInput input(frame);
  const InFlight in_flight;
  return surfaceQuality(cloud, input.frame, parameters, threads);
}

TemporalFlicker flickerOf(const py::object& before, const FrameLists& before_frame, const py::object& after,
                          const FrameLists& after_frame, const SurfaceQualityParameters& parameters,
                          unsigned int threads) {
  const auto before_cloud = cloudOf(before), after_cloud = cloudOf(after);
  const FrameInput before_input(before_frame), after_input(after_frame);
  const InFlight in_flight;
  return temporalFlicker(before_cloud, before_input.frame, after_cloud, after_input.frame, parameters, threads);
}

void bindReprojection(py::module_& module) {
  auto parameters = named<ReprojectionQualityParameters>(module, "ReprojectionQualityParameters");
  plain(parameters)
      .FUSE_FLOW_FIELD(ReprojectionQualityParameters, visibility)
      .FUSE_FLOW_FIELD(ReprojectionQualityParameters, coverage_radius)
      .FUSE_FLOW_FIELD(ReprojectionQualityParameters, coverage_step)
      .FUSE_FLOW_FIELD(ReprojectionQualityParameters, min_range)
      .FUSE_FLOW_FIELD(ReprojectionQualityParameters, max_range);
  named<ReprojectionQuality>(module, "ReprojectionQuality")
      .FUSE_FLOW_RESULT(ReprojectionQuality, points)
      .FUSE_FLOW_RESULT(ReprojectionQuality, seen_points)
      .FUSE_FLOW_RESULT(ReprojectionQuality, multi_view_points)
      .FUSE_FLOW_RESULT(ReprojectionQuality, violating_points)
      .FUSE_FLOW_RESULT(ReprojectionQuality, pixels)
      .FUSE_FLOW_RESULT(ReprojectionQuality, covered_pixels)
      .FUSE_FLOW_RESULT(ReprojectionQuality, error)
      .FUSE_FLOW_RESULT(ReprojectionQuality, multi_view_error)
      .def_property_readonly("violation_share", &ReprojectionQuality::violationShare,
                             doc("ReprojectionQuality::violationShare"))
      .def_property_readonly("coverage", &ReprojectionQuality::coverage, doc("ReprojectionQuality::coverage"));
  module.def("reprojection_quality", &qualityOfReprojection, py::arg("points"), py::arg("frame"), py::kw_only(),
             py::arg("parameters") = ReprojectionQualityParameters(), py::arg("threads") = 0,
             "Computes eq. 12, and the figures that must be read together with it.\n\n"
             "points: a Cloud, or (N, 3) floats in the world frame, metres; copied.\n"
             "frame: the views to compare with; they need not be those that the cloud was made from.");
}

}  // namespace

void bindQuality(py::module_& module) {
  bindReprojection(module);
  auto parameters = named<SurfaceQualityParameters>(module, "SurfaceQualityParameters");
  parameters.doc() = "Radii and limits of surface_quality() and temporal_flicker().";
  plain(parameters)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, neighborhood)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, visibility)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, silhouette)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, min_separation)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, max_separation)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, coverage_radius)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, coverage_deviations)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, max_coverage_radius)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, coverage_step)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, max_motion)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, samples)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, min_range)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, max_range)
      .FUSE_FLOW_FIELD(SurfaceQualityParameters, noise);
  named<TemporalFlicker>(module, "TemporalFlicker")
      .FUSE_FLOW_RESULT(TemporalFlicker, points)
      .FUSE_FLOW_RESULT(TemporalFlicker, sum)
      .def_property_readonly("mean", &TemporalFlicker::mean, doc("TemporalFlicker::mean"));
  named<SurfaceQuality>(module, "SurfaceQuality")
      .def(py::init<>())
      .FUSE_FLOW_RESULT(SurfaceQuality, points)
      .FUSE_FLOW_RESULT(SurfaceQuality, sampled_points)
      .FUSE_FLOW_RESULT(SurfaceQuality, surface_points)
      .FUSE_FLOW_RESULT(SurfaceQuality, judged_points)
      .FUSE_FLOW_RESULT(SurfaceQuality, double_points)
      .FUSE_FLOW_RESULT(SurfaceQuality, violating_points)
      .FUSE_FLOW_RESULT(SurfaceQuality, pixels)
      .FUSE_FLOW_RESULT(SurfaceQuality, covered_pixels)
      .FUSE_FLOW_RESULT(SurfaceQuality, noise_sum)
      .FUSE_FLOW_RESULT(SurfaceQuality, flicker)
      .def_property_readonly("noise", &SurfaceQuality::noise, doc("SurfaceQuality::noise"))
      .def_property_readonly("double_surfaces", &SurfaceQuality::doubleSurfaces, doc("SurfaceQuality::doubleSurfaces"))
      .def_property_readonly("violation_share", &SurfaceQuality::violationShare, doc("SurfaceQuality::violationShare"))
      .def_property_readonly("coverage", &SurfaceQuality::coverage, doc("SurfaceQuality::coverage"))
      .def(
          "__iadd__", [](SurfaceQuality& sum, const SurfaceQuality& more) -> SurfaceQuality& { return sum += more; },
          "Adds the counts and sums of another frame.");
  module.def("surface_quality", &qualityOfSurface, py::arg("points"), py::arg("frame"), py::kw_only(),
             py::arg("parameters") = SurfaceQualityParameters(), py::arg("threads") = 0,
             "The measures of one cloud, all but flicker: see SurfaceQuality.\n\n"
             "points: a Cloud, or (N, 3) floats in the world frame, metres; copied.\n"
             "frame: the views to compare with; they need not be those that the cloud was made from.");
  module.def("temporal_flicker", &flickerOf, py::arg("before"), py::arg("before_frame"), py::arg("after"),
             py::arg("after_frame"), py::kw_only(), py::arg("parameters") = SurfaceQualityParameters(),
             py::arg("threads") = 0,
             "How much a cloud jumps from one frame to the next where nothing moves, along the surface's normal.\n\n"
             "before, after: clouds, or (N, 3) floats in the world frame, metres; copied. before_frame, after_frame: "
             "the frames that they "
             "were made from, of the same cameras; the arrays of the first must not have been overwritten.");
}

}  // namespace fuse_flow::python
