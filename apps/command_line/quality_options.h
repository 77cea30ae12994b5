#pragma once

#include <fuse_flow/multi_camera_consistency.h>

#include <CLI/CLI.hpp>

namespace fuse_flow::command_line {

/** \brief What eq. 12 leaves open, on the command line; the ranges are left to the tool. */
void addQualityOptions(CLI::App& app, QualityParameters& parameters);

}  // namespace fuse_flow::command_line
