#include "../bindings.h"
#include "../plain.h"
#include "estimator.h"
#include "poses.h"

#include <fuse_flow/calibration/extrinsic_estimation.h>

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <pcl/point_types.h>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

using ExtrinsicEstimator = EstimatorOf<ExtrinsicEstimation<pcl::PointXYZ>, ExtrinsicParameters>;

ExtrinsicResult estimateExtrinsics(ExtrinsicEstimator& estimator, const std::optional<py::object>& initial) {
  if (!initial) return estimator.run([](auto& estimation) { return estimation.estimate(); });
  const std::vector<Eigen::Isometry3d> poses = posesOf(*initial, "initial");
  return estimator.run([&](auto& estimation) { return estimation.estimate(poses); });
}

void bindExtrinsicResult(py::module_& module) {
  named<CameraCorrection>(module, "CameraCorrection")
      .def_property_readonly(
          "T_correction", [](const CameraCorrection& c) { return matrixOf(c.T_correction); },
          doc("CameraCorrection::T_correction"))
      .FUSE_FLOW_RESULT(CameraCorrection, translation)
      .FUSE_FLOW_RESULT(CameraCorrection, rotation)
      .FUSE_FLOW_RESULT(CameraCorrection, translation_deviation)
      .FUSE_FLOW_RESULT(CameraCorrection, rotation_deviation)
      .FUSE_FLOW_RESULT(CameraCorrection, neighbours)
      .FUSE_FLOW_RESULT(CameraCorrection, constrained)
      .def_property_readonly(
          "covariance", [](const CameraCorrection& c) { return readOnly(py::cast(Eigen::MatrixXd(c.covariance))); },
          doc("CameraCorrection::covariance"))
      .def_property_readonly(
          "free_directions",
          [](const CameraCorrection& c) {
            Eigen::MatrixXd rows(static_cast<Eigen::Index>(c.free_directions.size()), 6);
            for (Eigen::Index i = 0; i < rows.rows(); ++i)
              rows.row(i) = c.free_directions[static_cast<std::size_t>(i)].transpose();
            return readOnly(py::cast(rows));
          },
          doc("CameraCorrection::free_directions"));
  named<CameraOverlap>(module, "CameraOverlap")
      .FUSE_FLOW_RESULT(CameraOverlap, first)
      .FUSE_FLOW_RESULT(CameraOverlap, second)
      .FUSE_FLOW_RESULT(CameraOverlap, correspondences)
      .FUSE_FLOW_RESULT(CameraOverlap, residual_before)
      .FUSE_FLOW_RESULT(CameraOverlap, residual);
  named<ExtrinsicResult>(module, "ExtrinsicResult")
      .def_property_readonly(
          "T_world_camera", [](const ExtrinsicResult& r) { return matricesOf(r.T_world_camera); },
          "(N, 4, 4) float64, camera by camera: camera to world, metres.")
      .def_property_readonly(
          "scene_center", [](const ExtrinsicResult& r) { return readOnly(py::cast(Eigen::VectorXd(r.scene_center))); },
          doc("ExtrinsicResult::scene_center"))
      .FUSE_FLOW_RESULT(ExtrinsicResult, corrections)
      .FUSE_FLOW_RESULT(ExtrinsicResult, overlaps)
      .FUSE_FLOW_RESULT(ExtrinsicResult, scene_radius)
      .FUSE_FLOW_RESULT(ExtrinsicResult, residual_before)
      .FUSE_FLOW_RESULT(ExtrinsicResult, residual)
      .FUSE_FLOW_RESULT(ExtrinsicResult, iterations)
      .FUSE_FLOW_RESULT(ExtrinsicResult, converged);
}

}  // namespace

void bindExtrinsics(py::module_& module) {
  py::enum_<Gauge>(module, "Gauge", doc("Gauge")).FUSE_FLOW_VALUE(Gauge, Mean).FUSE_FLOW_VALUE(Gauge, FirstCamera);
  auto parameters = named<ExtrinsicParameters, std::shared_ptr<ExtrinsicParameters>>(module, "ExtrinsicParameters");
  plain(parameters)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, preprocessing)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, smoothing)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, max_speckle)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, noise)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, reduction)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, coarse_above)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, samples)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, max_neighbours)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, max_correspondence_distance)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, min_correspondence_distance)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, max_normal_angle)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, min_information)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, residual_multipath)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, use_color)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, max_iterations)
      .FUSE_FLOW_FIELD(ExtrinsicParameters, gauge);
  bindExtrinsicResult(module);
  auto estimation = py::class_<ExtrinsicEstimator>(module, "ExtrinsicEstimation", doc("ExtrinsicEstimation"));
  bindEstimator<ExtrinsicParameters>(estimation, "ExtrinsicParameters", doc("ExtrinsicEstimation::addFrame"))
      .def("estimate", &estimateExtrinsics, py::arg("initial") = py::none(),
           "Estimates all poses. initial: (N, 4, 4), where the search begins; default the poses of the first frame.\n\n"
           "Raises RuntimeError without a frame.");
}

}  // namespace fuse_flow::python
