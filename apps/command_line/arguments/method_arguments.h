#pragma once

#include "command_line/arguments/parameter_options.h"
#include "methods/method.h"

#include <CLI/CLI.hpp>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::command_line {

/** \brief --device. \param what runs there, for the help  \param until what auto means besides, behind "on a GPU if there is one" */
void addDeviceOption(CLI::App& app, std::string& device, const std::string& what, const std::string& until = "");

/** \brief --camera-mask, of tools that write clouds. */
void addCameraMaskOption(CLI::App& app, bool& camera_mask);
/** \brief What is to be said of it, a line; empty: nothing. */
std::string cameraMaskAdvice(bool camera_mask, std::size_t cameras);

/** \brief What makes the cloud of a frame, on the command line, with every parameter of the library. */
class MethodArguments {
 public:
  explicit MethodArguments(CLI::App& app);
  MethodArguments(const MethodArguments&) = delete;
  MethodArguments& operator=(const MethodArguments&) = delete;

  const std::string& method() const { return method_; }
  /** \brief Throws OptionError. */
  io::MethodOptions options() const;
  /** \brief See ParameterOptions::advice(); of other methods about their leaf. */
  std::vector<std::string> advice() const;
  /** \brief See ParameterOptions::assumeStereo(); empty for methods that ask for no parameters of ours. */
  std::string assumeStereo(std::size_t views);
  /** \brief See --depth-source. */
  const std::string& depthSource() const { return parameters_->depthSource(); }

 private:
  std::string method_{"fuse_flow"};
  io::MethodOptions options_;
  std::optional<ParameterOptions> parameters_;
};

}  // namespace fuse_flow::command_line
