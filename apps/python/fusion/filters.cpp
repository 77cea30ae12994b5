#include "../bindings.h"
#include "../docstrings.h"
#include "../frames.h"
#include "../point_arrays.h"
#include "fusion_of.h"
#include "in_flight.h"
#include "methods/point_fused_normal.h"

#include <fuse_flow/filters/adaptive_hash_fusion.h>
#include <fuse_flow/filters/confidence_estimation.h>
#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/filters/multi_view_consistency.h>
#include <fuse_flow/recordings/organized_cloud.h>

#include <pybind11/stl.h>

#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow {
extern template class DepthBackprojection<pcl::PointXYZRGB>;  // compiled in recordings/instances.cpp
}

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief What one camera measured, and what keeps the arrays. */
struct CameraView {
  Camera camera;
  std::vector<py::object> kept;
  DepthView view;

  CameraView(const Camera& c, const ViewArrays& arrays) : camera(c), view(arrays.view(kept)) {
    checkRigFrame(RigFrame{{camera}, {view}, 0});
    if (view.missing()) throw py::value_error("fuse_flow.DepthView of camera '" + c.name + "': has no depth");
  }
};

py::array_t<float> confidenceEstimation(const ViewArrays& arrays, const Camera& camera,
                                        const ConfidenceParameters& parameters, unsigned int threads) {
  const CameraView one(camera, arrays);
  ConfidenceEstimation<pcl::PointXYZRGB> estimation;
  estimation.setParameters(parameters);
  estimation.setFocalLength(camera.intrinsics.fx);
  estimation.setNumberOfThreads(threads);
  {
    const InFlight in_flight;
    const auto cloud = std::make_shared<io::OrganizedCloud>();
    io::toOrganizedCloud(one.camera, one.view, *cloud);
    pcl::Indices kept;
    estimation.setInputCloud(cloud);
    estimation.filter(kept);
  }
  py::array_t<float> C({one.view.height(), one.view.width()});
  std::memcpy(C.mutable_data(), estimation.getConfidence().data(), sizeof(float) * static_cast<std::size_t>(C.size()));
  return C;
}

py::array_t<float> depthBackprojection(const ViewArrays& arrays, const Camera& camera,
                                       const PreprocessingParameters& parameters, unsigned int threads) {
  const CameraView one(camera, arrays);
  pcl::PointCloud<pcl::PointXYZRGB> cloud;
  {
    const InFlight in_flight;
    DepthBackprojection<pcl::PointXYZRGB> backprojection;
    backprojection.setParameters(parameters);
    backprojection.setNumberOfThreads(threads);
    backprojection.setCamera(one.camera);
    backprojection.setView(one.view);
    backprojection.filter(cloud);
  }
  py::array_t<float> points({one.view.height(), one.view.width(), 3});
  for (std::size_t i = 0; i < cloud.size(); ++i)
    std::memcpy(points.mutable_data() + 3 * i, cloud[i].data, 3 * sizeof(float));
  return points;
}

py::tuple multiViewConsistency(const py::object& points, const FrameLists& frame, int source_camera,
                               const std::optional<py::object>& normals, const ConsistencyParameters& parameters,
                               const PreprocessingParameters& preprocessing, unsigned int threads) {
  const pcl::PointCloud<pcl::PointXYZ> positions = cloudOf(points);
  const auto cloud = std::make_shared<pcl::PointCloud<io::PointFusedNormal>>();
  cloud->resize(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) (*cloud)[i].getVector3fMap() = positions[i].getVector3fMap();
  cloud->is_dense = false;
  if (normals) {
    const py::array_t<float> directions = tripletsOf(*normals, "normals");
    if (static_cast<std::size_t>(directions.shape(0)) != cloud->size())
      throw py::value_error("fuse_flow: there are " + std::to_string(cloud->size()) + " points but " +
                            std::to_string(directions.shape(0)) + " normals");
    for (std::size_t i = 0; i < cloud->size(); ++i)
      std::memcpy((*cloud)[i].normal, directions.data() + 3 * i, 3 * sizeof(float));
  }
  const FrameInput input(frame);
  MultiViewConsistency<io::PointFusedNormal> consistency;
  consistency.setParameters(parameters);
  consistency.setPreprocessing(preprocessing);
  consistency.setNumberOfThreads(threads);
  {
    const InFlight in_flight;
    consistency.setFrame(input.frame, source_camera);
    consistency.setInputCloud(cloud);
    pcl::Indices kept;
    consistency.filter(kept);
  }
  const auto size = static_cast<py::ssize_t>(cloud->size());
  return py::make_tuple(py::array_t<float>(size, consistency.getConsistency().data()),
                        py::array_t<int>(size, consistency.getViewCounts().data()));
}

Cloud adaptiveHashFusion(const py::object& points, const std::optional<py::object>& colors,
                         const std::optional<py::object>& confidence, const std::optional<py::object>& cameras,
                         const FrameLists* frame, const AggregationParameters& parameters,
                         const ConsistencyParameters& consistency, unsigned int threads) {
  const pcl::PointCloud<pcl::PointXYZ> positions = cloudOf(points);
  const std::size_t size = positions.size();
  const auto input = std::make_shared<pcl::PointCloud<PointFused>>();
  input->resize(size);
  input->is_dense = false;
  for (std::size_t i = 0; i < size; ++i) {
    (*input)[i].getVector3fMap() = positions[i].getVector3fMap();
    (*input)[i].confidence = 1.0f;
  }
  if (colors) {
    const auto array = py::array_t<std::uint8_t, py::array::c_style>::ensure(*colors);
    if (!array || array.ndim() != 2 || array.shape(1) != 3 || static_cast<std::size_t>(array.shape(0)) != size) {
      PyErr_Clear();
      throw py::value_error("fuse_flow: colors must be uint8 of shape (" + std::to_string(size) + ", 3)");
    }
    for (std::size_t i = 0; i < size; ++i) {
      const std::uint8_t* rgb = array.data() + 3 * i;
      (*input)[i].r = rgb[0];
      (*input)[i].g = rgb[1];
      (*input)[i].b = rgb[2];
    }
  }
  if (confidence) {
    const py::array_t<float> C = numbersOf<float>(*confidence, "confidence", size);
    for (std::size_t i = 0; i < size; ++i) (*input)[i].confidence = C.data()[i];
  }
  AdaptiveHashFusion<PointFused> fusion;
  fusion.setParameters(parameters);
  fusion.setNumberOfThreads(threads);
  if (cameras) {
    const py::array_t<std::uint32_t> numbers = numbersOf<std::uint32_t>(*cameras, "cameras", size);
    fusion.setCameraIndices({numbers.data(), numbers.data() + size});
  }
  const FrameInput views = frame != nullptr ? FrameInput(*frame) : FrameInput();
  const auto fused = std::make_shared<pcl::PointCloud<PointFused>>();
  {
    const InFlight in_flight;
    if (frame != nullptr) fusion.setFrame(views.frame, consistency);
    fusion.setInputCloud(input);
    fusion.filter(*fused);
  }
  return {fused, reinterpret_cast<std::byte*>(fused->data()), fused->size(), layoutOf<PointFused>(), 0};
}

}  // namespace

void bindFilters(py::module_& module) {
  module.def("confidence_estimation", &confidenceEstimation, py::arg("view"), py::arg("camera"), py::kw_only(),
             py::arg("parameters") = ConfidenceParameters(), py::arg("threads") = 0,
             "Eq. 2 and 3: the measurement confidence C of each pixel of a depth image.\n\n"
             "Returns (height, width) float32, 0 … 1; 0 where there is no measurement. The gate of eq. 9 keeps C > "
             "parameters.threshold.");
  module.def("depth_backprojection", &depthBackprojection, py::arg("view"), py::arg("camera"), py::kw_only(),
             py::arg("parameters") = PreprocessingParameters(), py::arg("threads") = 0,
             "Eq. 8: a point for each pixel of a depth image, without lens distortion.\n\n"
             "Returns (height, width, 3) float32 in the world frame, metres; NaN where there is no measurement.");
  module.def(
      "multi_view_consistency", &multiViewConsistency, py::arg("points"), py::arg("frame"), py::kw_only(),
      py::arg("source_camera") = -1, py::arg("normals") = py::none(), py::arg("parameters") = ConsistencyParameters(),
      py::arg("preprocessing") = PreprocessingParameters(), py::arg("threads") = 0,
      "Eq. 4–7: how well each point agrees with the depth images of a frame.\n\n"
      "points: a Cloud, or (N, 3) floats in the world frame, metres; copied.\n"
      "source_camera: number of the camera that all points came from, which is not asked about them; -1: none.\n"
      "normals: (N, 3), world frame; with them, and a source camera, views that the surface faces away from are not "
      "asked.\n\n"
      "Returns V, (N,) float32, 0 … 1, and the number of views that had a say, (N,) int32; without any, V is 1.");
  module.def("adaptive_hash_fusion", &adaptiveHashFusion, py::arg("points"), py::kw_only(),
             py::arg("colors") = py::none(), py::arg("confidence") = py::none(), py::arg("cameras") = py::none(),
             py::arg("frame") = py::none(), py::arg("parameters") = AggregationParameters(),
             py::arg("consistency") = ConsistencyParameters(), py::arg("threads") = 0,
             "Section 5: adaptive cells, representatives and eq. 11, for points in the world frame; in place of a "
             "voxel grid.\n\n"
             "points: a Cloud, or (N, 3) floats, metres; copied. Those that are not finite are left out.\n"
             "colors: (N, 3) uint8. confidence: (N,) floats, 0 … 1; default 1; points without any are left out.\n"
             "cameras: (N,) integers, the camera of each point; default camera 0.\n"
             "frame: with it, V over its views weights the points.");
}

}  // namespace fuse_flow::python
