#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <vector>

namespace fuse_flow::python {

/** \brief Who reads tensors of a GPU, and on which stream. */
struct DeviceReader {
  int device{0};                        ///< number of the GPU; −1: any
  std::uintptr_t stream{0};             ///< a cudaStream_t; 0: nobody reads yet, the tensors are only looked at
  std::vector<std::uintptr_t> waiting;  ///< receives the streams whose work must be done first
};

/** \brief Whether an object is in the memory of a GPU, by DLPack or by __cuda_array_interface__. */
bool onDevice(const pybind11::object& object);

/** \brief Its shape, strides, type and address, as an array that nobody may read on the CPU. The library's work on
 *  the tensor is done before what follows on the reader's stream once the reader has waited for reader.waiting.
 *  \throws pybind11::value_error for a tensor of another GPU, or of a type that numpy does not know */
pybind11::array addressesOf(const pybind11::object& tensor, const char* what, DeviceReader& reader);

}  // namespace fuse_flow::python
