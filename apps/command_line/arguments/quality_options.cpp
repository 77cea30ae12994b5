#include "command_line/arguments/quality_options.h"

#include "command_line/arguments/option_checks.h"

#include <algorithm>

namespace fuse_flow::command_line {

void addQualityOptions(CLI::App& app, ReprojectionQualityParameters& parameters) {
  app.add_option("--visibility", parameters.visibility, "largest |z - D| at which a view sees a point, m")
      ->check(lengthUpTo(10))
      ->capture_default_str();
  app.add_option("--coverage-radius", parameters.coverage_radius, "a measurement is covered by a point this near, m")
      ->check(lengthUpTo(10))
      ->capture_default_str();
  app.add_option("--coverage-step", parameters.coverage_step, "every how many pixels, each way, coverage looks at")
      ->check(wholeNumber(1, 65535))
      ->capture_default_str();
}

SurfaceQualityParameters surfaceParameters(const ReprojectionQualityParameters& parameters) {
  SurfaceQualityParameters surface;
  surface.visibility = parameters.visibility;
  surface.coverage_radius = parameters.coverage_radius;
  surface.max_coverage_radius = std::max(surface.max_coverage_radius, parameters.coverage_radius);
  surface.coverage_step = std::max(surface.coverage_step, parameters.coverage_step);
  surface.min_range = parameters.min_range;
  surface.max_range = parameters.max_range;
  return surface;
}

}  // namespace fuse_flow::command_line
