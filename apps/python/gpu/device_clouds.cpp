#include "../bindings.h"
#include "dlpack.h"
#include "gpu_fusion.h"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief A field of a cloud in the memory of a GPU, for other libraries to take over without a copy. */
struct DeviceArray {
  std::shared_ptr<const void> memory;
  std::byte* data{nullptr};
  int device{0};
  dlpack::DataType type{};
  std::vector<std::int64_t> shape, strides;  ///< strides in elements

  std::string typestr() const {
    const char kind = type.code == dlpack::kFloat ? 'f' : type.code == dlpack::kUInt ? 'u' : 'i';
    return (type.bits > 8 ? "<" : "|") + std::string(1, kind) + std::to_string(type.bits / 8);
  }
};

/** \brief What another library keeps for as long as it uses an array; it may let go in any thread, without the interpreter's lock. */
struct Handed {
  DeviceArray array;
  dlpack::ManagedTensor managed{};
};

py::capsule handOver(const DeviceArray& array, const py::object&, const py::kwargs&) {
  auto handed = std::make_unique<Handed>();
  handed->array = array;
  handed->managed.tensor = {handed->array.data,
                            {dlpack::kCuda, array.device},
                            static_cast<std::int32_t>(array.shape.size()),
                            array.type,
                            handed->array.shape.data(),
                            handed->array.strides.data(),
                            0};
  handed->managed.context = handed.get();
  handed->managed.deleter = [](dlpack::ManagedTensor* managed) { delete static_cast<Handed*>(managed->context); };
  // Who takes it over renames it, and is then the one to call the deleter.
  return py::capsule(&handed.release()->managed, "dltensor", [](PyObject* capsule) {
    if (PyCapsule_IsValid(capsule, "dltensor") == 0) return;
    auto* managed = static_cast<dlpack::ManagedTensor*>(PyCapsule_GetPointer(capsule, "dltensor"));
    managed->deleter(managed);
  });
}

py::dict interfaceOf(const DeviceArray& array) {
  py::list strides;
  for (const std::int64_t stride : array.strides) strides.append(stride * (array.type.bits / 8));
  py::dict interface;
  interface["version"] = 3;
  interface["typestr"] = array.typestr();
  interface["shape"] = py::tuple(py::cast(array.shape));
  interface["strides"] = py::tuple(strides);
  interface["data"] = py::make_tuple(reinterpret_cast<std::uintptr_t>(array.data), false);
  interface["stream"] = py::none();  // the cloud is complete
  return interface;
}

/** \param length of a vector; 0: a number */
DeviceArray fieldOf(const GpuCloud& cloud, std::size_t offset, dlpack::DataType type, std::int64_t length = 0) {
  DeviceArray array{
      cloud.memory, cloud.points == nullptr ? nullptr : cloud.points + offset, cloud.device, type, {}, {}};
  array.shape.push_back(static_cast<std::int64_t>(cloud.size));
  array.strides.push_back(static_cast<std::int64_t>(cloud.layout.size / (type.bits / 8)));
  if (length > 0) {
    array.shape.push_back(length);
    array.strides.push_back(1);
  }
  return array;
}

constexpr dlpack::DataType kFloat32{dlpack::kFloat, 32, 1}, kInt32{dlpack::kInt, 32, 1}, kByte{dlpack::kUInt, 8, 1};

/** \brief Where the fields begin in DeviceCloud.words. */
py::dict columnsOf(const PointLayout& layout) {
  const auto column = [](std::size_t bytes) { return bytes / sizeof(float); };
  py::dict columns;
  columns["points"] = 0;
  columns["bgra"] = column(layout.rgba);
  columns["confidence"] = column(layout.confidence);
  columns["view_count"] = column(layout.view_count);
  if (layout.normal) columns["normals"] = column(*layout.normal);
  if (layout.camera_mask) columns["camera_mask"] = column(*layout.camera_mask);
  return columns;
}

DeviceArray optionalField(const GpuCloud& cloud, const std::optional<std::size_t>& offset, dlpack::DataType type,
                          std::int64_t length, const char* how) {
  if (!offset) throw py::attribute_error(how);
  return fieldOf(cloud, *offset, type, length);
}

}  // namespace

void bindDeviceClouds(py::module_& module) {
  py::class_<DeviceArray>(
      module, "DeviceArray",
      "A field of a DeviceCloud, for torch.from_dlpack(), cupy.from_dlpack() and whatever else knows DLPack or "
      "__cuda_array_interface__: they share its memory.")
      .def("__dlpack__", &handOver, py::arg("stream") = py::none())
      .def("__dlpack_device__",
           [](const DeviceArray& a) { return py::make_tuple(static_cast<int>(dlpack::kCuda), a.device); })
      .def_property_readonly("__cuda_array_interface__", &interfaceOf, "Version 3.")
      .def_property_readonly(
          "shape", [](const DeviceArray& a) { return py::tuple(py::cast(a.shape)); }, "As numpy's.");

  py::class_<GpuCloud>(module, "DeviceCloud",
                       "A fused cloud in the memory of a GPU. It is complete: any stream may read it.")
      .def("__len__", [](const GpuCloud& cloud) { return cloud.size; })
      .def_property_readonly(
          "points", [](const GpuCloud& c) { return fieldOf(c, 0, kFloat32, 3); },
          "(N, 3) float32: x, y, z in the world frame, metres.")
      .def_property_readonly(
          "bgra", [](const GpuCloud& c) { return fieldOf(c, c.layout.rgba, kByte, 4); },
          "(N, 4) uint8: blue, green, red, alpha, as they lie in memory.")
      .def_property_readonly(
          "confidence", [](const GpuCloud& c) { return fieldOf(c, c.layout.confidence, kFloat32); },
          "(N,) float32: ω of eq. 10, in (0, 1].")
      .def_property_readonly(
          "view_count", [](const GpuCloud& c) { return fieldOf(c, c.layout.view_count, kInt32); },
          "(N,) int32: the number of cameras that contributed.")
      .def_property_readonly(
          "normals",
          [](const GpuCloud& c) {
            return optionalField(c, c.layout.normal, kFloat32, 3,
                                 "this cloud has no normals: FuseFlow(normals=True) makes them");
          },
          "(N, 3) float32, of length 1, facing the cameras; NaN where none is known.")
      .def_property_readonly(
          "camera_mask",
          [](const GpuCloud& c) {
            return optionalField(c, c.layout.camera_mask, kInt32, 2,
                                 "this cloud has no camera_mask: FuseFlow(camera_mask=True) makes it");
          },
          "(N, 2) int32: one bit for each contributing camera.")
      .def_property_readonly(
          "words",
          [](const GpuCloud& c) {
            return fieldOf(c, 0, kFloat32, static_cast<std::int64_t>(c.layout.size / sizeof(float)));
          },
          "(N, W) float32: whole points as they lie in memory, without gaps, for libraries that take no strides, as "
          "JAX. "
          "columns says where which field begins; those of integers have their bits.")
      .def_property_readonly(
          "columns", [](const GpuCloud& c) { return columnsOf(c.layout); }, "Of each field its first column in words.")
      .def_readonly("stamp", &GpuCloud::stamp, "Of the frame that it was fused from, microseconds.");
}

}  // namespace fuse_flow::python
