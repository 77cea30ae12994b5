#pragma once

#include <pybind11/pybind11.h>

/** \file
 *  \brief The parts of the module, one source each. */

namespace fuse_flow::python {

void bindErrors(pybind11::module_& module);
void bindCameras(pybind11::module_& module);
void bindFrames(pybind11::module_& module);
void bindParameters(pybind11::module_& module);
void bindStatistics(pybind11::module_& module);
void bindClouds(pybind11::module_& module);
void bindDeviceClouds(pybind11::module_& module);
void bindFusion(pybind11::module_& module);
void bindRecordings(pybind11::module_& module);
void bindRigWriter(pybind11::module_& module);
void bindPoseCheck(pybind11::module_& module);
void bindFilters(pybind11::module_& module);
void bindQuality(pybind11::module_& module);
void bindExtrinsics(pybind11::module_& module);
void bindCoarseAlignment(pybind11::module_& module);
void bindDepthCorrection(pybind11::module_& module);
void bindTracking(pybind11::module_& module);
void bindSynchronizer(pybind11::module_& module);
void bindLive(pybind11::module_& module);
void bindStereo(pybind11::module_& module);
/** \brief Where the module was built with streams. */
void bindStreams(pybind11::module_& module);

}  // namespace fuse_flow::python
