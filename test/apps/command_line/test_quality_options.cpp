#include "command_line/arguments/quality_options.h"

#include "../recordings/io_fixture.h"

#include <algorithm>

namespace {

using namespace io_test;

ReprojectionQualityParameters parseQuality(std::vector<std::string> arguments) {
  CLI::App app;
  ReprojectionQualityParameters parameters;
  command_line::addQualityOptions(app, parameters);
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 takes them
  app.parse(arguments);
  return parameters;
}

TEST(QualityOptions, EveryParameterButTheRangesHasAnOption) {
  // Does not compile once there is another member, which then needs an option.
  const auto [visibility, radius, step, min_range, max_range] =
      parseQuality({"--visibility", "0.07", "--coverage-radius", "0.03", "--coverage-step", "4"});
  EXPECT_EQ(visibility, 0.07f);
  EXPECT_EQ(radius, 0.03f);
  EXPECT_EQ(step, 4);
  EXPECT_EQ(min_range, ReprojectionQualityParameters().min_range);
  EXPECT_EQ(max_range, ReprojectionQualityParameters().max_range);
}

TEST(QualityOptions, WithoutOptionsItIsTheLibrarysDefaults) {
  const auto [visibility, radius, step, min_range, max_range] = parseQuality({});
  const ReprojectionQualityParameters defaults;
  EXPECT_EQ(visibility, defaults.visibility);
  EXPECT_EQ(radius, defaults.coverage_radius);
  EXPECT_EQ(step, defaults.coverage_step);
  EXPECT_EQ(min_range, defaults.min_range);
  EXPECT_EQ(max_range, defaults.max_range);
}

TEST(QualityOptions, WrongValuesAreRefused) {
  for (const char* option : {"--visibility", "--coverage-radius", "--coverage-step"})
    for (const char* value : {"0", "-1", "nan", "x", ""})
      EXPECT_THROW(parseQuality({option, value}), CLI::ParseError) << option << ' ' << value;
  EXPECT_THROW(parseQuality({"--coverage-step", "1.5"}), CLI::ParseError);
}

}  // namespace
