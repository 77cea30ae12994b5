#pragma once

#include <fuse_flow/stream/description.h>
#include <fuse_flow/stream/streamed_cloud.h>

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::python {

/** \brief A cloud as it arrived; the arrays that are made of it keep it. */
using Received = std::shared_ptr<stream::StreamedCloud>;

void bindStreamedClouds(pybind11::module_& module);
void bindStreamServer(pybind11::module_& module);
void bindStreamClient(pybind11::module_& module);
void bindStreamFiles(pybind11::module_& module);

/** \brief In one expression. \param step of the clouds that are sent */
inline stream::Description describedAs(const std::string& name, const std::vector<Camera>& cameras,
                                       const std::string& frame, double step) {
  return {name, frame, step, cameras};
}

}  // namespace fuse_flow::python
