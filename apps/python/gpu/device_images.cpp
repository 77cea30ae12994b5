#include "device_images.h"

#include "dlpack.h"

#include <pybind11/stl.h>

#include <string>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

[[noreturn]] void refuse(const char* what, const std::string& why) {
  throw py::value_error("fuse_flow.DepthView: " + std::string(what) + " " + why);
}

void checkDevice(int device, const char* what, const DeviceReader& reader) {
  if (reader.device >= 0 && device != reader.device)
    refuse(what, "is on GPU " + std::to_string(device) + ", must be on GPU " + std::to_string(reader.device) +
                     ", on which FuseFlow was made");
}

py::dtype typeOf(const dlpack::DataType& type, const char* what) {
  // What images are made of, without reading a name.
  if (type.lanes == 1 && type.code == dlpack::kUInt && type.bits == 8) return py::dtype::of<std::uint8_t>();
  if (type.lanes == 1 && type.code == dlpack::kUInt && type.bits == 16) return py::dtype::of<std::uint16_t>();
  if (type.lanes == 1 && type.code == dlpack::kFloat && type.bits == 32) return py::dtype::of<float>();
  const char* kind = type.code == dlpack::kFloat  ? "f"
                     : type.code == dlpack::kUInt ? "u"
                     : type.code == dlpack::kInt  ? "i"
                                                  : nullptr;
  if (kind == nullptr || type.lanes != 1 || type.bits % 8 != 0 || type.bits > 64 ||
      (type.code == dlpack::kFloat && type.bits < 16))
    refuse(what, "is of a type that is neither an integer nor a float");
  return py::dtype(kind + std::to_string(type.bits / 8));
}

/** \param owner keeps the tensor's memory for as long as the array lives */
py::array arrayOver(const dlpack::Tensor& t, const char* what, const DeviceReader& reader, const py::object& owner) {
  const py::dtype type = typeOf(t.dtype, what);
  checkDevice(t.device.id, what, reader);
  std::vector<py::ssize_t> shape(t.shape, t.shape + t.ndim), strides;
  if (t.strides != nullptr)
    for (int i = 0; i < t.ndim; ++i) strides.push_back(t.strides[i] * type.itemsize());
  return py::array(type, shape, strides, static_cast<const std::byte*>(t.data) + t.byte_offset, owner);
}

/** \brief The functions of a tensor's library; null if it has none, and its methods must be called: they take twenty times as long. */
const dlpack::ExchangeApi* exchangeOf(const py::object& tensor) {
  static PyObject* const name = PyUnicode_InternFromString("__dlpack_c_exchange_api__");
  const auto capsule =
      py::reinterpret_steal<py::object>(PyObject_GetAttr(reinterpret_cast<PyObject*>(Py_TYPE(tensor.ptr())), name));
  if (!capsule) {
    PyErr_Clear();
    return nullptr;
  }
  if (PyCapsule_IsValid(capsule.ptr(), dlpack::kExchangeName) == 0) return nullptr;
  // The table stays for as long as the process runs.
  auto* api = static_cast<const dlpack::ExchangeApi*>(PyCapsule_GetPointer(capsule.ptr(), dlpack::kExchangeName));
  while (api != nullptr && api->version.major != dlpack::kExchangeMajor) api = api->older;
  return api != nullptr && api->describe != nullptr && api->managed_of != nullptr && api->current_stream != nullptr
             ? api
             : nullptr;
}

dlpack::Tensor described(const dlpack::ExchangeApi& api, const py::object& tensor) {
  dlpack::Tensor t{};
  if (api.describe(tensor.ptr(), &t) != 0) throw py::error_already_set();
  return t;
}

py::array byExchange(const dlpack::ExchangeApi& api, const py::object& tensor, const char* what, DeviceReader& reader) {
  if (reader.stream == 0) return arrayOver(described(api, tensor), what, reader, tensor);
  dlpack::ManagedTensorVersioned* managed = nullptr;
  if (api.managed_of(tensor.ptr(), &managed) != 0) throw py::error_already_set();
  // Keeps the memory, whatever other threads do with the object of Python's meanwhile.
  const py::capsule owner(managed, [](void* pointer) {
    auto* tensor_of_array = static_cast<dlpack::ManagedTensorVersioned*>(pointer);
    if (tensor_of_array->deleter != nullptr) tensor_of_array->deleter(tensor_of_array);
  });
  const dlpack::Tensor& t = managed->tensor;
  const py::array array = arrayOver(t, what, reader, owner);
  void* current = nullptr;
  if (api.current_stream(dlpack::kCuda, t.device.id, &current) != 0) throw py::error_already_set();
  constexpr std::uintptr_t legacy_default = 1;  // cudaStreamLegacy
  const auto stream = current == nullptr ? legacy_default : reinterpret_cast<std::uintptr_t>(current);
  if (stream != reader.stream && (reader.waiting.empty() || reader.waiting.back() != stream))
    reader.waiting.push_back(stream);
  return array;
}

/** \brief The tensor's own description. \param stream that waits for the tensor; 0: nobody waits for anybody */
py::capsule dlpackOf(const py::object& tensor, std::uintptr_t stream) {
  const auto ask = [&](const py::object& who) {
    return py::capsule(tensor.attr("__dlpack__")(py::arg("stream") = who));
  };
  if (stream != 0) return ask(py::int_(stream));
  try {
    return ask(py::int_(-1));
  } catch (const py::error_already_set&) {
    return ask(py::none());  // JAX 0.11 takes −1, which the protocol has for "nobody", for a stream
  }
}

py::array byDlpack(const py::object& tensor, const char* what, DeviceReader& reader) {
  const py::capsule capsule = dlpackOf(tensor, reader.stream);
  auto* managed = static_cast<dlpack::ManagedTensor*>(PyCapsule_GetPointer(capsule.ptr(), "dltensor"));
  if (managed == nullptr) throw py::error_already_set();
  // The capsule, which nobody takes over, calls the deleter as it goes.
  return arrayOver(managed->tensor, what, reader, capsule);
}

py::array byInterface(const py::object& tensor, DeviceReader& reader) {
  const py::dict interface = tensor.attr("__cuda_array_interface__");
  const auto type = py::dtype(std::string(py::str(interface["typestr"])));
  const auto shape = interface["shape"].cast<std::vector<py::ssize_t>>();
  std::vector<py::ssize_t> strides;
  if (interface.contains("strides") && !interface["strides"].is_none())
    strides = interface["strides"].cast<std::vector<py::ssize_t>>();
  if (reader.stream != 0 && interface.contains("stream") && !interface["stream"].is_none())
    reader.waiting.push_back(interface["stream"].cast<std::uintptr_t>());
  const auto address = interface["data"].cast<py::tuple>()[0].cast<std::uintptr_t>();
  // NOLINTNEXTLINE(performance-no-int-to-ptr): as the protocol gives it
  return py::array(type, shape, strides, reinterpret_cast<const void*>(address), tensor);
}

}  // namespace

bool onDevice(const py::object& object) {
  if (const dlpack::ExchangeApi* api = exchangeOf(object)) {
    const std::int32_t type = described(*api, object).device.type;
    return type == dlpack::kCuda || type == dlpack::kCudaManaged;
  }
  if (py::hasattr(object, "__dlpack_device__")) {
    const int type = object.attr("__dlpack_device__")().cast<py::tuple>()[0].cast<int>();
    return type == dlpack::kCuda || type == dlpack::kCudaManaged;
  }
  return py::hasattr(object, "__cuda_array_interface__");
}

py::array addressesOf(const py::object& tensor, const char* what, DeviceReader& reader) {
  if (const dlpack::ExchangeApi* api = exchangeOf(tensor)) return byExchange(*api, tensor, what, reader);
  if (py::hasattr(tensor, "__dlpack__")) return byDlpack(tensor, what, reader);
  return byInterface(tensor, reader);
}

}  // namespace fuse_flow::python
