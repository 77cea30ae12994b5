#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace fuse_flow::python {

/** \brief A UserWarning, which may be an exception. */
inline void warn(const std::string& line) {
  if (PyErr_WarnEx(PyExc_UserWarning, line.c_str(), 1) != 0) throw pybind11::error_already_set();
}

}  // namespace fuse_flow::python
