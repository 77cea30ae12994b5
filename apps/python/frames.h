#pragma once

#include "gpu/device_images.h"

#include <fuse_flow/rig_frame.h>

#include <pybind11/pybind11.h>

#include <cstdint>
#include <vector>

namespace fuse_flow::python {

/** \brief DepthView of Python: the arrays, or tensors of a GPU, that its images are in; None where there is no image. */
struct ViewArrays {
  pybind11::object depth, color, confidence;

  /** \brief As C++ reads it. The arrays are looked at each time, since they may have changed. \param kept receives what keeps them
   *  \param reader who reads what is on a GPU; null: nobody can, which is an error */
  DepthView view(std::vector<pybind11::object>& kept, DeviceReader* reader = nullptr) const;

  template <typename Visit>
  int visit(const Visit& with) {
    for (pybind11::object* object : {&depth, &color, &confidence})
      if (const int result = with(*object)) return result;
    return 0;
  }
};

/** \brief RigFrame of Python: lists of Camera, and of DepthView or None. */
struct FrameLists {
  pybind11::object cameras, views;
  std::uint64_t stamp{0};

  template <typename Visit>
  int visit(const Visit& with) {
    for (pybind11::object* object : {&cameras, &views})
      if (const int result = with(*object)) return result;
    return 0;
  }
};

/** \brief A frame of Python as C++ reads it, from when this is filled: the lists may change meanwhile, and the arrays are kept. To be used
 *  with the interpreter's lock, but for reading the frame. */
class FrameInput {
 public:
  FrameInput() = default;
  /** \throws pybind11::type_error, or pybind11::value_error for an array that does not fit */
  explicit FrameInput(const FrameLists& lists) { fill(lists); }

  /** \brief Reuses memory. \param reader as for ViewArrays::view() \throws as the constructor */
  void fill(const FrameLists& lists, DeviceReader* reader = nullptr);
  /** \brief Lets go of the arrays. */
  void release() { kept_.clear(); }

  /** \brief The frame for messages: a camera without a name is called by its number. */
  RigFrame named() const;

  RigFrame frame;

 private:
  std::vector<pybind11::object> kept_;
};

}  // namespace fuse_flow::python
