#pragma once

#include "io/method.h"
#include "io/parameter_options.h"

#include <CLI/CLI.hpp>

#include <string>

namespace fuse_flow::io {

/** \brief What makes the cloud of a frame, on the command line, with every parameter of the library. */
class MethodArguments {
 public:
  explicit MethodArguments(CLI::App& app) {
    app.add_option("--method", method_, "what makes the cloud")
        ->check(CLI::IsMember({"fuse_flow", "concatenate", "voxel_grid", "approximate_voxel_grid", "outlier_removal"}))
        ->capture_default_str();
    app.add_option("--leaf-size", options_.leaf_size, "of the voxel grids, m")
        ->check(positiveNumber())
        ->capture_default_str();
    app.add_option("--device", options_.device, "where fuse_flow runs; auto: on a GPU if there is one")
        ->check(CLI::IsMember({"auto", "cpu", "gpu"}))
        ->capture_default_str();
    app.add_option("--threads", options_.threads, "0: one per core")->check(threadCount())->capture_default_str();
    app.set_config("--config", "", "read options from this file (name = value lines)");
    app.allow_config_extras(CLI::config_extras_mode::error);
    parameters_.emplace(app);
  }
  MethodArguments(const MethodArguments&) = delete;
  MethodArguments& operator=(const MethodArguments&) = delete;

  const std::string& method() const { return method_; }
  /** \brief Throws OptionError. */
  MethodOptions options() const {
    MethodOptions result = options_;
    result.parameters = parameters_->parameters();
    return result;
  }

 private:
  std::string method_{"fuse_flow"};
  MethodOptions options_;
  std::optional<ParameterOptions> parameters_;
};

}  // namespace fuse_flow::io
