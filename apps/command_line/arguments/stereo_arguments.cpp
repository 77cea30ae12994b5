#include "command_line/arguments/stereo_arguments.h"

#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"

#include <fuse_flow/recordings/error.h>

#include <pcl/exceptions.h>

#include <limits>

namespace fuse_flow::command_line {

StereoArguments::StereoArguments(CLI::App& app, bool may_be_off) {
  const std::string group = "Depth of cameras without depth";
  const auto add = [&](const std::string& name, const std::string& parameter, auto& member, const std::string& help) {
    CLI::Option* option = app.add_option(name, member, help)->capture_default_str()->group(group);
    if constexpr (std::is_floating_point_v<std::remove_reference_t<decltype(member)>>)
      option->check(finiteNumber());
    else
      option->check(wholeNumber(0, std::numeric_limits<int>::max()));
    option_of_[parameter] = name;
  };
  if (may_be_off) app.add_flag("!--no-stereo", estimate_, "do not estimate it: their views are missing")->group(group);
  add("--stereo-sources", "max_sources", parameters_.max_sources,
      "match each view with so many others, 1-8; those with the best angle");
  add("--stereo-best-sources", "best_sources", parameters_.best_sources,
      "so many of them must match, 1-4; others may not see the surface");
  add("--stereo-min-depth", "min_depth", parameters_.min_depth,
      "smallest depth that is looked for, m; 0: as follows from the poses");
  add("--stereo-max-depth", "max_depth", parameters_.max_depth, "largest, m; 0: as follows from the poses");
  add("--stereo-levels", "levels", parameters_.levels, "sizes of the images, each half of the one before, 1-5");
  add("--stereo-passes", "fine_passes", parameters_.fine_passes,
      "over the images in full size, 0-16; more is slower and finer, 0 leaves it at half size");
  add("--stereo-window", "window_spacing", parameters_.window_spacing,
      "between the 5 x 5 samples that are compared, 1-8 pixels; more blurs details");
  add("--stereo-edge-step", "edge_step", parameters_.edge_step,
      "doubt pixels that look as what lies beyond an edge of at least this share of the depth, and a pixel, 0-0.99, 0: "
      "none; more "
      "keeps thin things whole, and wrong points");
  add("--stereo-repetition-reach", "repetition_reach", parameters_.repetition_reach,
      "doubt patterns that look the same at another depth, up to so many pixels of the widest baseline away, 0-256, 0: "
      "none");
}

io::StereoOptions StereoArguments::options(const std::string& tool) const {
  try {
    checkParameters(parameters_);
  } catch (const pcl::PCLException& error) {
    throw io::OptionError(withOptionNames(error.what(), option_of_));
  }
  io::StereoOptions options;
  options.estimate = estimate_;
  options.parameters = parameters_;
  options.warn = [tool](const std::string& line) { printWarnings(tool, {line}); };
  return options;
}

}  // namespace fuse_flow::command_line
