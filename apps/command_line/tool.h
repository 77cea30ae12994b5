#pragma once

#include "recordings/files/interrupt.h"

#include <fuse_flow/recordings/error.h>

#include <CLI/CLI.hpp>

#include <cstddef>
#include <functional>
#include <iostream>
#include <string>

namespace fuse_flow::command_line {

/** \brief Exit codes of every tool. */
enum ExitCode { kSuccess = 0, kBadInput = 1, kWrongCommandLine = 2, kInterrupted = 130 };

/** \brief Parses, runs, with standard streams that are printable(), and turns every exception into a line on the standard error stream and an exit code. */
int runTool(CLI::App& app, int argc, char** argv, const std::function<int()>& run);

/** \brief How a tool ends that has done so many frames: kSuccess, or, where it was interrupted, with a line that says so, kInterrupted. */
int endOfFrames(const std::string& tool, std::size_t done, std::size_t frames);

}  // namespace fuse_flow::command_line
