#include "command_line/arguments/method_arguments.h"
#include "command_line/arguments/parameter_options.h"

#include "../recordings/io_fixture.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>

namespace {

using namespace io_test;
using P = FuseFlowParameters;

/** \brief The parameters of a command line; what the command line itself refuses is thrown as CLI::ParseError. */
P parse(std::vector<std::string> arguments) {
  CLI::App app;
  const command_line::ParameterOptions options(app);
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 takes them
  app.parse(arguments);
  return options.parameters();
}

/** \brief An option, a value that is not its default, where that must arrive, and a value that it must refuse. */
struct Option {
  std::string name;
  std::string value;
  std::function<double(const P&)> member;
  double arrives;
  std::string refused;
};

const std::vector<Option>& options() {
  static const std::vector<Option> all = {
      {"--min-range", "0.7", [](const P& p) { return p.preprocessing.min_range; }, 0.7, "-1"},
      {"--max-range", "7.5", [](const P& p) { return p.preprocessing.max_range; }, 7.5, "0"},
      {"--fill-neighbours", "5", [](const P& p) { return p.preprocessing.fill_neighbours; }, 5, "2"},
      {"--fill-tolerance", "0.11", [](const P& p) { return p.preprocessing.fill_tolerance; }, 0.11, "0"},
      {"--bilateral", "true", [](const P& p) { return p.preprocessing.bilateral; }, 1, "yes"},
      {"--bilateral-sigma-s", "4.5", [](const P& p) { return p.preprocessing.bilateral_sigma_s; }, 4.5, "0"},
      {"--bilateral-sigma-r", "0.05", [](const P& p) { return p.preprocessing.bilateral_sigma_r; }, 0.05, "0"},
      {"--smoothing-passes", "1", [](const P& p) { return p.smoothing.passes; }, 1, "5"},
      {"--smoothing-tolerance", "3.5", [](const P& p) { return p.smoothing.tolerance; }, 3.5, "0"},
      {"--smoothing-shrink", "0.45", [](const P& p) { return p.smoothing.shrink; }, 0.45, "1.5"},
      {"--smoothing-wide-above", "2.5", [](const P& p) { return p.smoothing.wide_above; }, 2.5, "-1"},
      {"--smoothing-twicing", "false", [](const P& p) { return p.smoothing.twicing; }, 0, "maybe"},
      {"--smoothing-twicing-above", "0.7", [](const P& p) { return p.smoothing.twicing_above; }, 0.7, "-1"},
      {"--adapt-noise", "false", [](const P& p) { return p.adapt_noise; }, 0, "0.5"},
      {"--min-confidence", "0.25", [](const P& p) { return p.min_confidence; }, 0.25, "1.5"},
      {"--half-weight-noise", "0.5", [](const P& p) { return p.half_weight_noise; }, 0.5, "-1"},
      {"--gate-noise", "0.03", [](const P& p) { return p.gate_noise; }, 0.03, "-1"},
      {"--max-noise", "0.5", [](const P& p) { return p.max_noise; }, 0.5, "-1"},
      {"--min-support", "5", [](const P& p) { return p.min_support; }, 5, "9"},
      {"--min-agreeing-views", "3", [](const P& p) { return p.agreement.min_views; }, 3, "64"},
      {"--agreement-pixels", "1.7", [](const P& p) { return p.agreement.pixels; }, 1.7, "0"},
      {"--agreement-relative", "0.03", [](const P& p) { return p.agreement.relative; }, 0.03, "1.5"},
      {"--confidence-form", "published", [](const P& p) { return static_cast<double>(p.confidence.form); },
       static_cast<double>(ConfidenceForm::Published), "printed"},
      {"--alpha", "0.31", [](const P& p) { return p.confidence.alpha; }, 0.31, "-1"},
      {"--beta", "0.32", [](const P& p) { return p.confidence.beta; }, 0.32, "-1"},
      {"--gamma", "0.33", [](const P& p) { return p.confidence.gamma; }, 0.33, "-1"},
      {"--delta", "0.34", [](const P& p) { return p.confidence.delta; }, 0.34, "-1"},
      {"--tau", "0.35", [](const P& p) { return p.confidence.threshold; }, 0.35, "1.5"},
      {"--length-unit", "0.36", [](const P& p) { return p.confidence.length_unit; }, 0.36, "0"},
      {"--noise-floor", "0.37", [](const P& p) { return p.confidence.noise.floor; }, 0.37, "-1"},
      {"--noise-linear", "0.375", [](const P& p) { return p.confidence.noise.linear; }, 0.375, "-1"},
      {"--noise-quadratic", "0.38", [](const P& p) { return p.confidence.noise.quadratic; }, 0.38, "-1"},
      {"--noise-reference", "0.39", [](const P& p) { return p.confidence.noise_reference; }, 0.39, "0"},
      {"--max-incidence", "0.40", [](const P& p) { return p.confidence.max_incidence; }, 0.40, "1.6"},
      {"--occlusion-form", "published", [](const P& p) { return static_cast<double>(p.consistency.occlusion); },
       static_cast<double>(OcclusionForm::Published), "2"},
      {"--distance-form", "euclidean", [](const P& p) { return static_cast<double>(p.consistency.distance); },
       static_cast<double>(DistanceForm::Euclidean), "manhattan"},
      {"--sigma", "0.41", [](const P& p) { return p.consistency.sigma; }, 0.41, "0"},
      {"--sigma-per-noise", "0.42", [](const P& p) { return p.consistency.sigma_per_noise; }, 0.42, "-1"},
      {"--margin", "4.3", [](const P& p) { return p.consistency.margin; }, 4.3, "0"},
      {"--free-space-penalty", "0.44", [](const P& p) { return p.consistency.free_space_penalty; }, 0.44, "1.1"},
      {"--weigh-contradictions", "true", [](const P& p) { return p.consistency.weigh_contradictions; }, 1, "yes"},
      {"--min-facing", "0.45", [](const P& p) { return p.consistency.min_facing; }, 0.45, "1.1"},
      {"--silhouette-radius", "3", [](const P& p) { return p.consistency.silhouette_radius; }, 3, "9"},
      {"--max-views", "5", [](const P& p) { return p.consistency.max_views; }, 5, "1"},
      {"--max-candidates", "23", [](const P& p) { return p.consistency.max_candidates; }, 23, "0"},
      {"--representatives", "different_cameras",
       [](const P& p) { return static_cast<double>(p.aggregation.representatives); },
       static_cast<double>(Representatives::DifferentCameras), "cameras"},
      {"--consistency-at", "representatives",
       [](const P& p) { return static_cast<double>(p.aggregation.consistency_at); },
       static_cast<double>(ConsistencyAt::Representatives), "cell"},
      {"--cell-size", "0.45", [](const P& p) { return p.aggregation.cell_size; }, 0.45, "0"},
      {"--min-cell-size", "0.003", [](const P& p) { return p.aggregation.min_cell_size; }, 0.003, "0"},
      {"--points-per-cell", "47", [](const P& p) { return p.aggregation.points_per_cell; }, 47, "0"},
      {"--min-weight", "0.48", [](const P& p) { return p.aggregation.min_weight; }, 0.48, "1.1"},
      {"--weak-weight", "0.49", [](const P& p) { return p.aggregation.weak_weight; }, 0.49, "-0.1"},
      {"--confirmation-reach", "0.011", [](const P& p) { return p.aggregation.confirmation_reach; }, 0.011, "-0.1"},
      {"--reach-per-noise", "3.3", [](const P& p) { return p.aggregation.reach_per_noise; }, 3.3, "-0.1"},
      {"--measurement-confidence", "false", [](const P& p) { return p.use_measurement_confidence; }, 0, "off"},
      {"--distance-consistency", "false", [](const P& p) { return p.use_distance_consistency; }, 0, "2"},
      {"--spatial-hash", "false", [](const P& p) { return p.use_spatial_hash; }, 0, ""}};
  return all;
}

std::vector<double> members(const P& p) {
  std::vector<double> values;
  for (const Option& option : options()) values.push_back(option.member(p));
  return values;
}

TEST(ParameterOptions, WithoutOptionsTheyAreTheDefaults) {
  EXPECT_EQ(members(parse({})), members(P()));
  EXPECT_FALSE(parse({}).crop_box);
}

TEST(ParameterOptions, EachReachesItsMemberAndNoOther) {
  for (std::size_t i = 0; i < options().size(); ++i) {
    const Option& option = options()[i];
    std::vector<double> expected = members(P());
    ASSERT_NE(static_cast<float>(expected[i]), static_cast<float>(option.arrives)) << option.name << " is no change";
    expected[i] = option.arrives;
    const std::vector<double> arrived = members(parse({option.name, option.value}));
    for (std::size_t k = 0; k < expected.size(); ++k)
      EXPECT_FLOAT_EQ(static_cast<float>(arrived[k]), static_cast<float>(expected[k]))
          << option.name << " and " << options()[k].name;
  }
}

TEST(ParameterOptions, AllAreTestedHere) {
  CLI::App app;
  const command_line::ParameterOptions parameters(app);
  std::set<std::string> tested{"--help", "--published", "--depth-source", "--crop-box"}, offered;
  for (const Option& option : options()) tested.insert(option.name);
  for (const CLI::Option* option : app.get_options()) offered.insert("--" + option->get_lnames().at(0));
  EXPECT_EQ(offered, tested);
}

TEST(ParameterOptions, AWrongValueIsRefusedInAMessageThatNamesTheOption) {
  for (const Option& option : options()) {
    std::string message;
    try {
      parse({option.name, option.refused});
    } catch (const CLI::ParseError& error) {
      message = error.what();
    } catch (const io::OptionError& error) {
      message = error.what();
    }
    EXPECT_NE(message.find(option.name), std::string::npos) << option.name << ' ' << option.refused << ": " << message;
  }
}

TEST(ParameterOptions, WhatIsNoFiniteNumberIsRefused) {
  for (const Option& option : options())
    for (const char* value : {"nan", "inf", "-inf", "1e39", "1e999", "12x", "x", ""})
      EXPECT_ANY_THROW(parse({option.name, value})) << option.name << ' ' << value;
}

TEST(ParameterOptions, WholeNumbersAreWhole) {
  for (const char* option : {"--fill-neighbours", "--smoothing-passes", "--max-views", "--max-candidates"})
    for (const char* value : {"3.5", "3e0", "-3", "99999999999"})
      EXPECT_THROW(parse({option, value}), CLI::ParseError) << option << ' ' << value;
}

TEST(ParameterOptions, PublishedIsThePapersFormAndOptionsGoOnTop) {
  EXPECT_EQ(members(parse({"--published"})), members(P::published()));
  EXPECT_NE(members(P::published()), members(P()));
  const P changed = parse({"--sigma", "0.5", "--published", "--distance-form", "along_ray"});
  EXPECT_EQ(changed.consistency.sigma, 0.5f);
  EXPECT_EQ(changed.consistency.distance, DistanceForm::AlongRay);
  EXPECT_EQ(changed.consistency.occlusion, P::published().consistency.occlusion);
}

/** \brief Of the options that these arguments give. */
std::vector<std::string> advice(std::vector<std::string> arguments) {
  CLI::App app;
  const command_line::ParameterOptions options(app);
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  return options.advice();
}

TEST(ParameterOptions, TauThatIsNotAskedOfAllIsSaid) {
  const std::vector<std::string> said = advice({"--tau", "0.8"});
  ASSERT_EQ(said.size(), 1u);
  for (const char* part : {"--tau 0.8 is asked only of", "20 mm", "--gate-noise 0"})
    EXPECT_NE(said[0].find(part), std::string::npos) << said[0];
  EXPECT_TRUE(advice({}).empty());
  EXPECT_TRUE(advice({"--tau", "0.8", "--gate-noise", "0.03"}).empty()) << "whoever says that knows it";
  EXPECT_TRUE(advice({"--tau", "0.8", "--published"}).empty());
  EXPECT_TRUE(advice({"--tau", "0.8", "--depth-source", "network"}).empty());
  EXPECT_TRUE(advice({"--tau", "0.8", "--confidence-form", "given"}).empty());
  EXPECT_TRUE(advice({"--tau", "0.8", "--measurement-confidence", "false"}).empty());
}

TEST(ParameterOptions, LengthsThatAreMostLikelyMillimetresAreSaid) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(advice({"--max-range", "8000"}), (Lines{"--max-range 8000 is in metres; 8000 mm are 8"}));
  EXPECT_EQ(advice({"--noise-reference", "1000"}), (Lines{"--noise-reference 1000 is in metres; 1000 mm are 1"}));
  EXPECT_TRUE(advice({"--max-range", "120"}).empty());
}

TEST(MethodArguments, ALeafThatIsMostLikelyInMillimetresIsSaid) {
  const auto said = [](const std::string& leaf) {
    CLI::App app("method");
    command_line::MethodArguments method(app);
    app.parse("--method voxel_grid --leaf-size " + leaf);
    return method.advice();
  };
  EXPECT_EQ(said("10"), (std::vector<std::string>{"--leaf-size 10 is in metres; 10 mm are 0.01"}));
  EXPECT_TRUE(said("0.02").empty());
}

TEST(ParameterOptions, WhatMadeTheDepthIsWhereTheyStartFrom) {
  EXPECT_EQ(members(parse({"--depth-source", "camera"})), members(P()));
  EXPECT_EQ(members(parse({"--depth-source", "network"})), members(P::estimatedDepth()));
  EXPECT_EQ(members(parse({"--depth-source", "stereo"})), members(P::estimatedDepth()));
  const std::vector<double> estimated = members(P::estimatedDepth()), defaults = members(P());
  std::size_t different = 0;
  for (std::size_t k = 0; k < defaults.size(); ++k) different += estimated[k] != defaults[k] ? 1 : 0;
  EXPECT_EQ(different, 12u);  // those that the reference names
  const P changed = parse({"--min-agreeing-views", "1", "--depth-source", "network"});
  EXPECT_EQ(changed.agreement.min_views, 1);
  EXPECT_EQ(changed.adapt_noise, P::estimatedDepth().adapt_noise);
  EXPECT_THROW(parse({"--depth-source", "kinect"}), CLI::ParseError);
  EXPECT_THROW(parse({"--depth-source", "network", "--published"}), CLI::ParseError);
}

TEST(ParameterOptions, AnOptionWithItsDefaultOverrulesThePublishedForm) {
  const P defaults, published = P::published();
  ASSERT_NE(defaults.consistency.occlusion, published.consistency.occlusion);
  EXPECT_EQ(parse({"--published", "--occlusion-form", "occlusion_aware"}).consistency.occlusion,
            defaults.consistency.occlusion);
}

TEST(ParameterOptions, EveryFormHasAName) {
  EXPECT_EQ(parse({"--confidence-form", "slope_compensated"}).confidence.form, ConfidenceForm::SlopeCompensated);
  EXPECT_EQ(parse({"--occlusion-form", "occlusion_aware"}).consistency.occlusion, OcclusionForm::OcclusionAware);
  EXPECT_EQ(parse({"--distance-form", "along_ray"}).consistency.distance, DistanceForm::AlongRay);
  EXPECT_EQ(parse({"--representatives", "highest_confidence"}).aggregation.representatives,
            Representatives::HighestConfidence);
  EXPECT_EQ(parse({"--representatives", "camera_means"}).aggregation.representatives, Representatives::CameraMeans);
  EXPECT_EQ(parse({"--consistency-at", "cell_mean"}).aggregation.consistency_at, ConsistencyAt::CellMean);
}

TEST(ParameterOptions, TheCropBoxIsItsTwoCorners) {
  const auto box = parse({"--crop-box", "-1", "-2", "-3", "4", "5", "6"}).crop_box;
  ASSERT_TRUE(box);
  EXPECT_EQ(box->min(), Eigen::Vector3f(-1, -2, -3));
  EXPECT_EQ(box->max(), Eigen::Vector3f(4, 5, 6));
  EXPECT_TRUE(refuses<io::OptionError>(
      [] {
        parse({"--crop-box", "0", "0", "2", "1", "1", "1"});
      },
      {"--crop-box: a minimum exceeds its maximum"}));
  EXPECT_THROW(parse({"--crop-box", "0", "0", "0", "1", "1"}), CLI::ParseError);
  EXPECT_THROW(parse({"--crop-box", "0", "0", "0", "1", "1", "nan"}), CLI::ParseError);
}

/** \brief The cells of a Markdown table's line. */
std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> result;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, '|');) {
    const std::size_t begin = cell.find_first_not_of(' ');
    result.push_back(begin == std::string::npos ? "" : cell.substr(begin, cell.find_last_not_of(' ') + 1 - begin));
  }
  return result;
}

TEST(ParameterOptions, TheDocumentationHasTheirDefaults) {
  std::map<std::string, std::vector<std::string>> rows;
  std::ifstream page(std::filesystem::path(FUSE_FLOW_TEST_SOURCE_DIR) / "doc/reference/parameters.md");
  for (std::string line; std::getline(page, line);)
    if (line.rfind("| `--", 0) == 0 && cells(line).size() == 9) rows[cells(line)[1]] = cells(line);
  for (const Option& option : options()) {
    const auto row = rows.find("`" + option.name + "`");
    ASSERT_NE(row, rows.end()) << option.name;
    const std::string& value = row->second[3];
    const std::string& published = row->second[4].empty() ? value : row->second[4];
    EXPECT_EQ(option.member(parse({option.name, value})), option.member(P())) << option.name;
    EXPECT_EQ(option.member(parse({option.name, published})), option.member(P::published())) << option.name;
  }
}

TEST(ParameterOptions, WhatContradictsAnotherOptionIsNamedAsOnTheCommandLine) {
  EXPECT_TRUE(refuses<io::OptionError>(
      [] {
        parse({"--min-range", "3", "--max-range", "2"});
      },
      {"--max-range is 2, must exceed --min-range, 3"}));
  EXPECT_TRUE(refuses<io::OptionError>(
      [] {
        parse({"--max-views", "6", "--max-candidates", "3"});
      },
      {"--max-candidates is 3"}));
  EXPECT_TRUE(refuses<io::OptionError>([] { parse({"--alpha", "0", "--gamma", "0"}); }, {"--alpha + --gamma is 0"}));
}

}  // namespace
