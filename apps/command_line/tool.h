#pragma once

#include "recordings/files/interrupt.h"

#include <fuse_flow/recordings/error.h>

#include <CLI/CLI.hpp>

#include <functional>
#include <iostream>

namespace fuse_flow::command_line {

/** \brief Exit codes of every tool. */
enum ExitCode { kSuccess = 0, kBadInput = 1, kWrongCommandLine = 2, kInterrupted = 130 };

/** \brief Parses, runs, with standard streams that are printable(), and turns every exception into a line on the standard error stream and an exit code. */
int runTool(CLI::App& app, int argc, char** argv, const std::function<int()>& run);

}  // namespace fuse_flow::command_line
