#include "streams.h"

#include "../bindings.h"
#include "../plain.h"

#include <fuse_flow/stream/encoded_frame.h>

#include <pybind11/stl.h>

namespace fuse_flow::python {

namespace py = pybind11;

void bindStreams(py::module_& module) {
  using stream::Description;
  using stream::EncodingOptions;
  py::class_<EncodingOptions> encoding(module, "StreamEncoding", doc("EncodingOptions"));
  plain(encoding)
      .FUSE_FLOW_FIELD(EncodingOptions, step)
      .FUSE_FLOW_FIELD(EncodingOptions, chroma_step)
      .FUSE_FLOW_FIELD(EncodingOptions, layers)
      .FUSE_FLOW_FIELD(EncodingOptions, chunk_points)
      .FUSE_FLOW_FIELD(EncodingOptions, confidence)
      .def_readwrite("view_count", &EncodingOptions::view_count, "As confidence, of the number of cameras.")
      .def_readwrite("normals", &EncodingOptions::normals, "As confidence, of normals.")
      .def_readwrite("camera_mask", &EncodingOptions::camera_masks, "As confidence, of which cameras contributed.")
      .FUSE_FLOW_FIELD(EncodingOptions, threads);
  py::class_<Description>(module, "StreamDescription", doc("Description"))
      .FUSE_FLOW_RESULT(Description, name)
      .FUSE_FLOW_RESULT(Description, frame)
      .FUSE_FLOW_RESULT(Description, step)
      .FUSE_FLOW_RESULT(Description, cameras);
  bindStreamedClouds(module);
  bindStreamServer(module);
  bindStreamClient(module);
  bindStreamFiles(module);
}

}  // namespace fuse_flow::python
