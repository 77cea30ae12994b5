#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

namespace fuse_flow::python {

/** \brief A str or an os.PathLike. */
inline std::string pathOf(const pybind11::handle& path) {
  return pybind11::str(pybind11::module_::import("os").attr("fspath")(path));
}

/** \brief A path, or several. */
inline std::vector<std::string> pathsOf(const pybind11::object& paths) {
  if (pybind11::isinstance<pybind11::str>(paths) || pybind11::hasattr(paths, "__fspath__")) return {pathOf(paths)};
  std::vector<std::string> all;
  for (const pybind11::handle path : paths) all.push_back(pathOf(path));
  return all;
}

}  // namespace fuse_flow::python
