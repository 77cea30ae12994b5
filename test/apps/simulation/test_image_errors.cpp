#include "mesh_checks.h"

#include "evaluation/truth.h"
#include "recordings/files/json_file.h"
#include "simulation/image_errors.h"
#include "simulation/random.h"
#include "simulation/sensor.h"
#include "simulation/simulator.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow::simulation;
using fuse_flow::Intrinsics;
using fuse_flow::io::ColorImage;
using mesh_checks::Vector3f;

const Material kGrey{Material::Plain, {120, 120, 120}, {}, 0.1f, 0.7f};
const Vector3f kTowardsCamera = -Vector3f::UnitZ();

/** \brief What all of an image of the wall shows before noise, grey levels. */
double wallLevel() { return static_cast<double>(litColor(kGrey, kTowardsCamera, Vector3f::Zero()).x()); }

/** \brief Channels are rounded down. */
constexpr double kRounding = -0.5;

const Intrinsics kWide{64, 48, 40.0f, 40.0f, 31.5f, 23.5f, {}};

/** \brief A camera 1 m before a grey wall that fills its image. */
ColorImage wallImage(const ImageErrors& errors, std::uint64_t frame = 0, int threads = 1) {
  Object wall = mesh_checks::squareFacingUp(9, 0);
  for (Vector3f& v : wall.mesh.vertices) v = Vector3f(v.x(), -v.y(), 1);
  wall.material = kGrey;
  RayScene scene;
  scene.setFixed({wall});
  ColorImage color;
  renderColor(scene, kWide, Eigen::Isometry3d::Identity(), {1, frame, 0}, threads, errors, color);
  return color;
}

std::vector<double> channels(const ColorImage& image) {
  std::vector<double> values;
  for (const fuse_flow::Rgb8& c : image.data)
    for (const std::uint8_t value : {c.r, c.g, c.b}) values.push_back(value);
  return values;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
  const double middle = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/** \brief Mean level of a pixel over many shots. */
double meanAt(const ImageErrors& errors, int u, int v) {
  std::vector<double> values;
  for (std::uint64_t frame = 0; frame < 200; ++frame) {
    const fuse_flow::Rgb8 c = wallImage(errors, frame).at(u, v);
    for (const std::uint8_t value : {c.r, c.g, c.b}) values.push_back(value);
  }
  return mean(values);
}

TEST(ImageErrors, WithoutThemAnImageHasTheNoiseThatItAlwaysHad) {
  const ColorImage image = wallImage({});
  const auto level = static_cast<float>(wallLevel());
  for (int v = 0; v < kWide.height; ++v)
    for (int u = 0; u < kWide.width; ++u) {
      Random random(1 + 0x5bd1e995, 0, 0, static_cast<std::uint64_t>(v * kWide.width + u));
      for (const std::uint8_t channel : {image.at(u, v).r, image.at(u, v).g, image.at(u, v).b})
        ASSERT_EQ(channel, static_cast<std::uint8_t>(level + 2.0f * static_cast<float>(random.gaussian())));
    }
}

TEST(ImageErrors, NoiseHasTheStatedDeviationBesideTheTwoLevelsOfEveryImage) {
  for (const float sigma : {0.0f, 3.0f, 8.0f}) {
    ImageErrors errors;
    errors.noise = sigma;
    const std::vector<double> values = channels(wallImage(errors));
    const double rounding = 1.0 / 12;  // variance
    EXPECT_NEAR(deviation(values) / std::sqrt(4 + sigma * sigma + rounding), 1, 0.03) << sigma;
    EXPECT_NEAR(mean(values), wallLevel() + kRounding, 0.05 * (2 + sigma)) << sigma;
  }
}

TEST(ImageErrors, NoiseIsEachPixelsAndEachChannelsOwn) {
  ImageErrors errors;
  errors.noise = 6;
  const std::vector<double> values = channels(wallImage(errors));
  const double middle = mean(values), variance = deviation(values) * deviation(values);
  for (const std::size_t step : {1u, 2u, 3u, 3u * 64u}) {  // the next channels, the pixel beside, the pixel below
    double sum = 0;
    for (std::size_t i = 0; i + step < values.size(); ++i) sum += (values[i] - middle) * (values[i + step] - middle);
    EXPECT_NEAR(sum / static_cast<double>(values.size()) / variance, 0, 0.05) << step;
  }
}

TEST(ImageErrors, GainMultipliesAndBlackLevelAdds) {
  ImageErrors errors;
  errors.gain = 0.8f;
  errors.black_level = 7;
  EXPECT_NEAR(mean(channels(wallImage(errors))), 0.8 * wallLevel() + 7 + kRounding, 0.1);
  errors.gain = 5;
  for (const double value : channels(wallImage(errors))) ASSERT_EQ(value, 255) << "overexposed";
}

TEST(ImageErrors, VignettingGrowsWithTheSquareOfTheDistanceFromTheMiddle) {
  ImageErrors errors;
  errors.vignetting = 0.4f;
  errors.gain = 1.5f;
  EXPECT_EQ(errors.fallOff(kWide, 0, 0), 0.6f);
  const double level = 1.5 * wallLevel();
  for (const int u : {0, 63})
    for (const int v : {0, 47}) EXPECT_NEAR(meanAt(errors, u, v), 0.6 * level + kRounding, 0.4) << u << ", " << v;
  EXPECT_NEAR(meanAt(errors, 31, 23), level + kRounding, 0.4) << "the middle";
  // At the middle of the left side: 31.5² of the corner's 31.5² + 23.5², of which the middle itself is half a pixel off.
  const double share = (31.5 * 31.5 + 0.25) / (31.5 * 31.5 + 23.5 * 23.5);
  EXPECT_NEAR(meanAt(errors, 0, 23), (1 - 0.4 * share) * level + kRounding, 0.4);
}

TEST(ImageErrors, GiveTheSameImageForAnyNumberOfThreads) {
  const ImageErrors errors{0.9f, 3, 0.3f, 4};
  const std::vector<double> one = channels(wallImage(errors));
  EXPECT_EQ(one, channels(wallImage(errors, 0, 3)));
  EXPECT_NE(one, channels(wallImage(errors, 1)));
}

SimulationOptions smallTable() {
  SimulationOptions options;
  options.scene = "table";
  options.rig = "arc-20";
  options.sensor = "structured_light";
  options.scale = 0.05;
  options.threads = 1;
  return options;
}

TEST(ImageErrors, OfEachCameraAreItsOwnAndWithinTheStatedBounds) {
  SimulationOptions options = smallTable();
  options.faults.image = {3, 0.15, 0.3};
  const Simulator simulator(options);
  std::set<float> gains, black_levels, vignettings;
  for (std::size_t k = 0; k < 20; ++k) {
    const ImageErrors& errors = simulator.imageErrors(k);
    gains.insert(errors.gain);
    black_levels.insert(errors.black_level);
    vignettings.insert(errors.vignetting);
    EXPECT_EQ(errors.noise, 3);
  }
  EXPECT_EQ(gains.size(), 20u);
  EXPECT_EQ(black_levels.size(), 20u);
  EXPECT_EQ(vignettings.size(), 20u);
  // Of twenty uniform numbers some are in the outer quarters: all but 2 · 0.75^20 = 0.6 % of the seeds.
  EXPECT_GE(*gains.begin(), 0.85f);
  EXPECT_LT(*gains.begin(), 0.925f);
  EXPECT_GT(*gains.rbegin(), 1.075f);
  EXPECT_LE(*gains.rbegin(), 1.15f);
  EXPECT_GE(*black_levels.begin(), -3);
  EXPECT_LE(*black_levels.rbegin(), 3);
  EXPECT_GE(*vignettings.begin(), 0);
  EXPECT_GT(*vignettings.rbegin(), 0.225f);
  EXPECT_LE(*vignettings.rbegin(), 0.3f);
}

TEST(ImageErrors, FollowTheSeedAndEachItsOwnOption) {
  SimulationOptions options = smallTable();
  options.faults.image = {3, 0.15, 0.3};
  const ImageErrors all = Simulator(options).imageErrors(4);
  options.faults.image = {0, 0.15, 0};
  EXPECT_EQ(Simulator(options).imageErrors(4).gain, all.gain);
  EXPECT_EQ(Simulator(options).imageErrors(4).vignetting, 0);
  options.faults.image = {0, 0, 0.3};
  EXPECT_EQ(Simulator(options).imageErrors(4).vignetting, all.vignetting);
  EXPECT_EQ(Simulator(options).imageErrors(4).gain, 1);
  options.seed = 2;
  EXPECT_NE(Simulator(options).imageErrors(4).vignetting, all.vignetting);
}

TEST(ImageErrors, LeaveDepthAlone) {
  SimulationOptions options = smallTable();
  options.rig = "arc-2";
  fuse_flow::io::LoadedFrame clean, wrong;
  Simulator(options).measure(0, clean);
  options.faults.image = {3, 0.15, 0.3};
  Simulator(options).measure(0, wrong);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_TRUE(clean.images[k].depth16.data == wrong.images[k].depth16.data);
    EXPECT_NE(channels(clean.images[k].color), channels(wrong.images[k].color));
  }
}

TEST(ImageErrors, StandInTheTruth) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "fuse_flow_image_errors";
  std::filesystem::remove_all(folder);
  SimulationOptions options = smallTable();
  options.rig = "arc-3";
  options.faults.image = {3, 0.15, 0.3};
  const Simulator simulator(options);
  writeTruth(folder.string(), simulator);
  const auto truth = fuse_flow::io::readJson<nlohmann::json>((folder / "truth" / "simulation.json").string(), "");
  std::filesystem::remove_all(folder);
  EXPECT_EQ(truth["image_noise"], 3.0);
  EXPECT_EQ(truth["exposure"], 0.15);
  EXPECT_EQ(truth["vignetting"], 0.3);
  ASSERT_EQ(truth["image_errors"].size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const nlohmann::json& camera = truth["image_errors"][k];
    EXPECT_EQ(camera["gain"].get<float>(), simulator.imageErrors(k).gain);
    EXPECT_EQ(camera["black_level"].get<float>(), simulator.imageErrors(k).black_level);
    EXPECT_EQ(camera["vignetting"].get<float>(), simulator.imageErrors(k).vignetting);
  }
}

}  // namespace
