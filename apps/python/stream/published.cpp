#include "published.h"

#include "../point_arrays.h"
#include "streams.h"

#include <pybind11/stl.h>

#include <array>
#include <cstring>
#include <string>
#include <utility>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

stream::CloudView viewOf(const Cloud& cloud) {
  stream::CloudView view;
  view.points = reinterpret_cast<const unsigned char*>(cloud.points);
  view.size = cloud.size;
  view.stride = cloud.layout.size;
  view.color = static_cast<int>(cloud.layout.rgba);
  view.confidence = static_cast<int>(cloud.layout.confidence);
  view.view_count = static_cast<int>(cloud.layout.view_count);
  if (cloud.layout.normal) view.normal = static_cast<int>(*cloud.layout.normal);
  if (cloud.layout.camera_mask) view.camera_mask = static_cast<int>(*cloud.layout.camera_mask);
  return view;
}

/** \brief (points, length) of exactly this type, in rows without gaps: 1.0 is no colour, and no bits. */
template <typename T>
py::array_t<T> exactly(const py::object& object, const char* what, std::size_t points, py::ssize_t length) {
  const py::array array = py::array::ensure(py::module_::import("numpy").attr("asarray")(object));
  if (!py::isinstance<py::array_t<T>>(array) || array.ndim() != 2 ||
      array.shape(0) != static_cast<py::ssize_t>(points) || array.shape(1) != length)
    throw py::value_error("fuse_flow: " + std::string(what) + " is " + std::string(py::str(array.dtype())) +
                          " of shape " + std::string(py::str(array.attr("shape"))) + ", must be " +
                          std::string(py::str(py::dtype::of<T>())) + " of shape (" + std::to_string(points) + ", " +
                          std::to_string(length) + ")");
  return py::array_t<T, py::array::c_style | py::array::forcecast>::ensure(array);
}

/** \brief Writes a field of all points. \param word where it begins in a point \param length words of it */
template <typename T>
void pack(const T* values, std::size_t points, std::size_t word, std::size_t length, std::size_t stride,
          std::vector<std::uint32_t>& packed) {
  static_assert(sizeof(T) == sizeof(std::uint32_t));
  for (std::size_t i = 0; i < points; ++i)
    std::memcpy(&packed[i * stride + word], values + i * length, length * sizeof(T));
}

}  // namespace

PublishedCloud::PublishedCloud(const py::object& cloud, const Fields& fields) {
  const bool streamed = py::isinstance<stream::StreamedCloud>(cloud);
  if (py::isinstance<Cloud>(cloud) || streamed) {
    for (const py::object& field :
         {fields.colors, fields.confidence, fields.view_count, fields.normals, fields.camera_mask})
      if (!field.is_none())
        throw py::value_error(
            "fuse_flow: a cloud has its own colors, confidence, view_count, normals and camera_mask; "
            "give them with an array of points only");
  }
  if (py::isinstance<Cloud>(cloud)) {
    kept_ = cloud;
    fused_ = &py::cast<const Cloud&>(cloud);
    return;
  }
  points_ = tripletsOf(streamed ? py::object(cloud.attr("points")) : cloud, "cloud");
  size_ = static_cast<std::size_t>(points_->shape(0));
  if (streamed) {
    setFields({cloud.attr("colors"), cloud.attr("confidence"), cloud.attr("view_count"), cloud.attr("normals"),
               cloud.attr("camera_mask")});
  } else {
    setFields(fields);
  }
}

void PublishedCloud::setFields(const Fields& fields) {
  if (!fields.colors.is_none()) colors_ = exactly<std::uint8_t>(fields.colors, "colors", size_, 3);
  if (!fields.confidence.is_none()) confidence_ = numbersOf<float>(fields.confidence, "confidence", size_);
  if (!fields.view_count.is_none()) view_count_ = numbersOf<std::uint32_t>(fields.view_count, "view_count", size_);
  if (!fields.camera_mask.is_none()) camera_mask_ = exactly<std::uint32_t>(fields.camera_mask, "camera_mask", size_, 2);
  if (fields.normals.is_none()) return;
  normals_ = tripletsOf(fields.normals, "normals");
  if (static_cast<std::size_t>(normals_->shape(0)) != size_)
    throw py::value_error("fuse_flow: normals are " + std::to_string(normals_->shape(0)) + ", must be as many as the " +
                          std::to_string(size_) + " points");
}

stream::CloudView PublishedCloud::view() {
  if (fused_ != nullptr) return viewOf(*fused_);
  stream::CloudView view;
  view.size = size_;
  std::size_t stride = 3;  // words
  const auto place = [&](bool there, std::size_t length) {
    return there ? static_cast<int>(sizeof(std::uint32_t) * (std::exchange(stride, stride + length))) : -1;
  };
  view.color = place(colors_.has_value(), 1);
  view.confidence = place(confidence_.has_value(), 1);
  view.view_count = place(view_count_.has_value(), 1);
  view.normal = place(normals_.has_value(), 3);
  view.camera_mask = place(camera_mask_.has_value(), 2);
  view.stride = stride * sizeof(std::uint32_t);
  if (stride == 3) {
    view.points = reinterpret_cast<const unsigned char*>(points_->data());
    return view;
  }
  packed_.resize(size_ * stride);
  const auto word = [](int offset) { return static_cast<std::size_t>(offset) / sizeof(std::uint32_t); };
  pack(points_->data(), size_, 0, 3, stride, packed_);
  if (colors_) {
    const std::uint8_t* rgb = colors_->data();
    for (std::size_t i = 0; i < size_; ++i, rgb += 3) {
      const std::array<std::uint8_t, 4> bgra{rgb[2], rgb[1], rgb[0], 255};
      std::memcpy(&packed_[i * stride + word(view.color)], bgra.data(), bgra.size());
    }
  }
  if (confidence_) pack(confidence_->data(), size_, word(view.confidence), 1, stride, packed_);
  if (view_count_) pack(view_count_->data(), size_, word(view.view_count), 1, stride, packed_);
  if (normals_) pack(normals_->data(), size_, word(view.normal), 3, stride, packed_);
  if (camera_mask_) pack(camera_mask_->data(), size_, word(view.camera_mask), 2, stride, packed_);
  view.points = reinterpret_cast<const unsigned char*>(packed_.data());
  return view;
}

stream::FrameTimes FrameNumbers::timesOf(const py::object& cloud, const std::optional<std::uint64_t>& number,
                                         const std::optional<std::int64_t>& captured) {
  stream::FrameTimes times;
  times.number = next_;
  if (py::isinstance<stream::StreamedCloud>(cloud)) times = py::cast<const stream::StreamedCloud&>(cloud).times;
  if (number) times.number = *number;
  if (captured) times.captured = *captured;
  next_ = times.number + 1;
  return times;
}

}  // namespace fuse_flow::python
