#include "command_line/arguments/method_arguments.h"

#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/config_file.h"

#include <memory>
#include <sstream>

namespace fuse_flow::command_line {

void addDeviceOption(CLI::App& app, std::string& device, const std::string& what, const std::string& until) {
  app.add_option("--device", device, "where " + what + "; auto: on a GPU if there is one" + until)
      ->check(CLI::IsMember({"auto", "cpu", "gpu"}))
      ->capture_default_str();
}

void addCameraMaskOption(CLI::App& app, bool& camera_mask) {
  app.add_flag("--camera-mask", camera_mask,
               "write which cameras each point is from: camera_mask, a bit for each in two numbers of 32");
}

std::string cameraMaskAdvice(bool camera_mask, std::size_t cameras) {
  constexpr std::size_t bits = 64;
  if (!camera_mask || cameras <= bits) return "";
  return "--camera-mask: has bits for " + std::to_string(bits) + " cameras, and there are " + std::to_string(cameras) +
         ": of those from the 65th on nothing is written; --views chooses others";
}

MethodArguments::MethodArguments(CLI::App& app) {
  app.add_option("--method", method_, "what makes the cloud")
      ->check(CLI::IsMember({"fuse_flow", "concatenate", "voxel_grid", "approximate_voxel_grid", "outlier_removal"}))
      ->capture_default_str();
  app.add_option("--leaf-size", options_.leaf_size, "of the voxel grids, m")
      ->check(lengthUpTo(10))
      ->capture_default_str();
  options_.warn = [tool = app.get_name()](const std::string& message) { printWarnings(tool, {message}); };
  addDeviceOption(app, options_.device, "fuse_flow runs, poses are refined, and depth is estimated",
                  ", until it fails; then on the CPU");
  app.add_option("--threads", options_.threads, "0: one per core")->check(threadCount())->capture_default_str();
  app.set_config("--config", "", "read options from this file (name = value lines)")->check(path());
  app.config_formatter(std::make_shared<ConfigFile>());
  app.allow_config_extras(CLI::config_extras_mode::error);
  parameters_.emplace(app);
}

io::MethodOptions MethodArguments::options() const {
  io::MethodOptions result = options_;
  result.parameters = parameters_->parameters();
  return result;
}

std::vector<std::string> MethodArguments::advice() const {
  if (method_ == "fuse_flow") return parameters_->advice();
  std::vector<std::string> lines;
  if (const float leaf = options_.leaf_size; leaf >= 1) {  // no voxel grid of a room
    std::ostringstream line;
    line << "--leaf-size " << leaf << " is in metres; " << leaf << " mm are " << leaf / 1000;
    lines.push_back(line.str());
  }
  return lines;
}

std::string MethodArguments::assumeStereo(std::size_t views) {
  return method_ == "fuse_flow" ? parameters_->assumeStereo(views) : "";
}

}  // namespace fuse_flow::command_line
