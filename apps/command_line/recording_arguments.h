#pragma once

#include "io/recording.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace fuse_flow::command_line {

/** \brief Which recording, and how to look at it, on the command line. */
class RecordingArguments {
 public:
  explicit RecordingArguments(CLI::App& app);
  RecordingArguments(const RecordingArguments&) = delete;
  RecordingArguments& operator=(const RecordingArguments&) = delete;

  CLI::Option* input() { return input_; }
  const std::vector<std::string>& inputs() const { return inputs_; }
  io::RecordingOptions options() const;

 private:
  CLI::Option* input_;
  std::vector<std::string> inputs_;
  io::RecordingOptions options_;
};

}  // namespace fuse_flow::command_line
