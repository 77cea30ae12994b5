#pragma once

#include <fuse_flow/quality/reprojection_quality.h>
#include <fuse_flow/quality/surface_quality.h>

#include <CLI/CLI.hpp>

namespace fuse_flow::command_line {

/** \brief What eq. 12 leaves open, on the command line; the ranges are left to the tool. */
void addQualityOptions(CLI::App& app, ReprojectionQualityParameters& parameters);

/** \brief The measures of the surface with the same visibility, radius, step and range. */
SurfaceQualityParameters surfaceParameters(const ReprojectionQualityParameters& parameters);

}  // namespace fuse_flow::command_line
