#pragma once

#include <fuse_flow/depth_view.h>

#include <pybind11/numpy.h>

namespace fuse_flow::python {

/** \brief What Python gave, as an array that has the same memory. A numpy array stays what it is; of anything else, such as a memoryview or a
 *  tensor in host memory, numpy makes one. */
pybind11::array arrayOf(const pybind11::object& object);

///@{
/** \brief An array as an image, without a copy: rows may be any number of bytes apart, pixels of a row must follow each other.
 *  \throws pybind11::value_error that says what was given, and what would be right */
ImageView<float> floatImageOf(const pybind11::array& array, const char* what);
ImageView<Rgb8> colorImageOf(const pybind11::array& array);
///@}

/** \brief A depth image: uint16 as depth16, float32 as depth32. \throws as floatImageOf() */
void setDepth(const pybind11::array& array, DepthView& view);

///@{
/** \brief An array that has the memory of an image. \param owner what keeps this memory */
pybind11::array arrayOf(const ImageView<std::uint16_t>& image, const pybind11::object& owner);
pybind11::array arrayOf(const ImageView<float>& image, const pybind11::object& owner);
pybind11::array arrayOf(const ImageView<Rgb8>& image, const pybind11::object& owner);
///@}

}  // namespace fuse_flow::python
