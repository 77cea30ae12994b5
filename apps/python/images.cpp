#include "images.h"

#include <limits>
#include <string>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

std::string described(const py::array& array) {
  return std::string(py::str(array.dtype())) + " of shape " + std::string(py::str(array.attr("shape")));
}

[[noreturn]] void refuse(const py::array& array, const char* what, const char* right) {
  throw py::value_error("fuse_flow.DepthView: " + std::string(what) + " is " + described(array) + ", must be " + right);
}

/** \brief Whether an array is of Ts, in the byte order of this machine. */
template <typename T>
bool isOf(const py::array& array) {
  // Nearly always numpy's own description of the type, of which there is one.
  static const PyObject* const type = py::dtype::of<T>().release().ptr();
  return py::detail::array_proxy(array.ptr())->descr == type || py::isinstance<py::array_t<T>>(array);
}

/** \brief Rows of pixels, whatever a pixel is made of. */
template <typename Pixel>
ImageView<Pixel> rowsOf(const py::array& array, const char* what, py::ssize_t dimensions) {
  const py::ssize_t height = array.shape(0), width = array.shape(1);
  constexpr py::ssize_t most = std::numeric_limits<int>::max();
  if (width == 0 || height == 0 || width > most || height > most)
    throw py::value_error("fuse_flow.DepthView: " + std::string(what) + " is " + described(array) +
                          ", an image without pixels");
  const auto pixel = static_cast<py::ssize_t>(sizeof(Pixel));
  // A stride along an axis of one element says nothing.
  const bool follow_each_other =
      (width == 1 || array.strides(1) == pixel) && (dimensions == 2 || array.strides(2) == 1);
  const py::ssize_t stride = height == 1 ? width * pixel : array.strides(0);
  if (!follow_each_other || stride < width * pixel)
    throw py::value_error(
        "fuse_flow.DepthView: " + std::string(what) + " has strides " + std::string(py::str(array.attr("strides"))) +
        " bytes: the pixels of a row must follow each other, and row follow row; numpy.ascontiguousarray(" + what +
        ") makes a copy that fits");
  const auto address = reinterpret_cast<std::uintptr_t>(array.data());
  if (address % alignof(Pixel) != 0 || static_cast<std::size_t>(stride) % alignof(Pixel) != 0)
    throw py::value_error("fuse_flow.DepthView: " + std::string(what) + " is not aligned to " +
                          std::to_string(alignof(Pixel)) + " bytes; " + what + ".copy() is");
  return {static_cast<const Pixel*>(array.data()), static_cast<int>(width), static_cast<int>(height),
          static_cast<std::size_t>(stride)};
}

template <typename T, typename Pixel>
py::array pixelsOf(const ImageView<Pixel>& image, const py::object& owner, bool of_three) {
  const auto row = static_cast<py::ssize_t>(image.row_stride), pixel = static_cast<py::ssize_t>(sizeof(Pixel));
  std::vector<py::ssize_t> shape{image.height, image.width}, strides{row, pixel};
  if (of_three) {
    shape.push_back(3);
    strides.push_back(1);
  }
  return py::array(py::dtype::of<T>(), shape, strides, image.data, owner);
}

}  // namespace

py::array arrayOf(const py::object& object) {
  if (py::isinstance<py::array>(object)) return py::reinterpret_borrow<py::array>(object);
  return py::array::ensure(py::module_::import("numpy").attr("asarray")(object));
}

ImageView<float> floatImageOf(const py::array& array, const char* what) {
  if (array.ndim() != 2 || !isOf<float>(array)) refuse(array, what, "float32 of shape (height, width)");
  return rowsOf<float>(array, what, 2);
}

ImageView<Rgb8> colorImageOf(const py::array& array) {
  if (array.ndim() != 3 || array.shape(2) != 3 || !isOf<std::uint8_t>(array))
    refuse(array, "color", "uint8 of shape (height, width, 3): red, green, blue");
  return rowsOf<Rgb8>(array, "color", 3);
}

void setDepth(const py::array& array, DepthView& view) {
  if (array.ndim() == 2 && isOf<std::uint16_t>(array)) {
    view.depth16 = rowsOf<std::uint16_t>(array, "depth", 2);
  } else if (array.ndim() == 2 && isOf<float>(array)) {
    view.depth32 = rowsOf<float>(array, "depth", 2);
  } else {
    refuse(array, "depth", "uint16 (in units of Camera.depth_scale) or float32 (metres) of shape (height, width)");
  }
}

py::array arrayOf(const ImageView<std::uint16_t>& image, const py::object& owner) {
  return pixelsOf<std::uint16_t>(image, owner, false);
}

py::array arrayOf(const ImageView<float>& image, const py::object& owner) {
  return pixelsOf<float>(image, owner, false);
}

py::array arrayOf(const ImageView<Rgb8>& image, const py::object& owner) {
  return pixelsOf<std::uint8_t>(image, owner, true);
}

}  // namespace fuse_flow::python
