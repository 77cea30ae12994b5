#include "mesh_checks.h"

#include "simulation/exposure.h"
#include "simulation/sensor.h"
#include "simulation/simulator.h"
#include "simulation/true_view.h"

#include <fuse_flow/recordings/image.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow::simulation;
using fuse_flow::io::ColorImage;
using fuse_flow::io::FloatImage;
using fuse_flow::io::LoadedFrame;
using mesh_checks::Vector3f;

const Eigen::Isometry3d kHere = Eigen::Isometry3d::Identity();

/** \brief Faces a camera at the origin that looks along z: a rectangle at a depth, from one place to another across. */
Object board(float depth, float from, float to, float half_height = 2) {
  Object object = mesh_checks::squareFacingUp(1, 0);
  for (Vector3f& v : object.mesh.vertices)
    v = Vector3f(v.x() < 0 ? from : to, v.y() < 0 ? half_height : -half_height, depth);
  object.name = "board";
  return object;
}

/** \brief A wall at 3 m, and before it a board at 2 m, from x = −10 m to an edge that moves from one place to another. */
RayScene slidingEdge(float from, float to, int steps = 2) {
  RayScene scene;
  scene.setFixed({board(3, -10, 10, 10)});
  std::vector<std::vector<Object>> motion;
  for (int step = 0; step < steps; ++step) {
    const float share = static_cast<float>(step) / static_cast<float>(steps - 1);
    motion.push_back({board(2, -10, from + share * (to - from), 10)});
  }
  scene.setMotion(motion);
  return scene;
}

TEST(RaySceneInMotion, IsAtEachMomentWhereALineBetweenTheStepsIs) {
  RayScene scene;
  scene.setFixed({board(5, -10, 10, 10)});
  scene.setMotion({{board(1, -1, 1)}, {board(2, -1, 1)}, {board(4, -1, 1)}});
  const auto depth = [&](float moment) { return scene.intersect({0, 0, 0}, {0, 0, 1}, moment).t; };
  EXPECT_FLOAT_EQ(depth(0), 1);
  EXPECT_FLOAT_EQ(depth(0.25f), 1.5f);
  EXPECT_FLOAT_EQ(depth(0.5f), 2);
  EXPECT_FLOAT_EQ(depth(0.75f), 3);
  EXPECT_FLOAT_EQ(depth(1), 4);
  EXPECT_FLOAT_EQ(depth(-0.1f), 1) << "limited to the motion";
  EXPECT_FLOAT_EQ(depth(1.1f), 4);
  EXPECT_FLOAT_EQ(depth(std::nanf("")), 1);
  const RayHit at_once = scene.intersect({3.3f, 0.7f, 0.1f}, {0.1f, 0.2f, 1}, 0);
  for (float moment = 0; moment < 1; moment += 0.037f) {
    const RayHit later = scene.intersect({3.3f, 0.7f, 0.1f}, {0.1f, 0.2f, 1}, moment);
    ASSERT_EQ(later.t, at_once.t) << "what stands still";
    ASSERT_TRUE(later.position == at_once.position && later.normal == at_once.normal);
  }
  EXPECT_TRUE(scene.occluded({0, 0, 0}, {0, 0, 1.8f}, 1e-3f, 0.25f));
  EXPECT_FALSE(scene.occluded({0, 0, 0}, {0, 0, 1.4f}, 1e-3f, 0.25f));
  EXPECT_NEAR(scene.nearest({0, 0, 1.2f}).t, 0.2f, 1e-6f) << "of the first moment";
  scene.setMoving({board(3, -1, 1)});
  EXPECT_FLOAT_EQ(depth(0.7f), 3) << "no motion any more";
  EXPECT_THROW(scene.setMotion({{board(1, -1, 1)}, {board(1, -1, 1), board(2, -1, 1)}}), std::invalid_argument);
  EXPECT_THROW(scene.setMotion(std::vector<std::vector<Object>>(200, {board(1, -1, 1)})), std::invalid_argument);
  EXPECT_FLOAT_EQ(depth(0.7f), 3) << "as before";
  scene.setMotion({});
  EXPECT_FLOAT_EQ(depth(0.7f), 5) << "nothing moves";
}

TEST(RaySceneInMotion, MeetsATurningBodyAsOneThatStandsAsItDoesAtThatMoment) {
  // The corners of a turning body move on lines between the steps: the answer at half the way is that of the mesh with the
  // middles of its corners.
  const auto turned = [](float angle) {
    Object object = board(2, -0.4f, 0.5f, 0.3f);
    const Eigen::Affine3f T = Eigen::Translation3f(0, 0, 2) * Eigen::AngleAxisf(angle, Vector3f(0.3f, 0.9f, 0.1f)) *
                              Eigen::Translation3f(0, 0, -2);
    for (Vector3f& v : object.mesh.vertices) v = T * v;
    return object;
  };
  const Object begin = turned(0), end = turned(0.8f);
  Object middle = begin;
  for (std::size_t i = 0; i < middle.mesh.vertices.size(); ++i)
    middle.mesh.vertices[i] = 0.5f * begin.mesh.vertices[i] + 0.5f * end.mesh.vertices[i];
  RayScene moving, still;
  moving.setMotion({{begin}, {end}});
  still.setMoving({middle});
  int hits = 0;
  for (int k = 0; k < 400; ++k) {
    const Vector3f direction(0.02f * static_cast<float>(k % 20 - 10), 0.02f * static_cast<float>(k / 20 - 10), 1);
    const RayHit a = moving.intersect({0, 0, 0}, direction, 0.5f), b = still.intersect({0, 0, 0}, direction);
    ASSERT_EQ(static_cast<bool>(a), static_cast<bool>(b));
    if (!a) continue;
    ++hits;
    ASSERT_EQ(a.t, b.t);
    ASSERT_TRUE(a.normal.isApprox(b.normal, 1e-5f));
    ASSERT_TRUE(a.position.isApprox(b.position, 1e-5f));
  }
  EXPECT_GT(hits, 100);
}

TEST(Exposure, OfARollingShutterIsRowAfterRow) {
  const RayScene scene;
  const Exposure rolling(scene, {0.1f, 0.9f, 0.2f});
  EXPECT_FLOAT_EQ(rolling.moment(0, 5), 0.1f);
  EXPECT_FLOAT_EQ(rolling.moment(2, 5), 0.5f);
  EXPECT_FLOAT_EQ(rolling.moment(4, 5), 0.9f);
  EXPECT_FLOAT_EQ(rolling.moment(4, 5, 0.5f), 1.0f);
  EXPECT_FLOAT_EQ(rolling.moment(0, 5, -0.5f), 0.0f);
  EXPECT_FLOAT_EQ(rolling.moment(0, 1), 0.5f) << "a single row is in the middle";
  EXPECT_TRUE(Exposure(scene).instant());
  EXPECT_FALSE(rolling.instant());
}

TEST(Exposure, SlantsAnEdgeThatMovesAcrossARollingShutter) {
  // 0.4 m to the right, at 2 m, while the rows are read out: the edge of the board leans by K.fx · 0.4 / 2 pixels.
  const RayScene scene = slidingEdge(-0.2f, 0.2f, 5);
  const auto sensor = makeSensor("ideal", 0.5);
  const fuse_flow::Intrinsics K = sensor->intrinsics();
  FloatImage depth;
  sensor->measure({scene, {0, 1, 0}}, kHere, {1, 0, 0}, 2, depth);
  for (int v = 0; v < K.height; ++v) {
    const float place = -0.2f + 0.4f * static_cast<float>(v) / static_cast<float>(K.height - 1);
    const float edge = K.cx + K.fx * place / 2;
    for (int u = 0; u < K.width; ++u) {
      if (std::fabs(static_cast<float>(u) - edge) < 0.01f) continue;
      ASSERT_NEAR(depth.at(u, v), static_cast<float>(u) < edge ? 2 : 3, 1e-5f) << u << " " << v;
    }
  }
}

TEST(TrueView, ShowsTheSurfaceThatAPixelSawTheLongest) {
  const RayScene scene = slidingEdge(-0.3f, 0.3f);
  fuse_flow::Intrinsics K;
  K.width = 61;
  K.height = 3;
  K.fx = K.fy = 100;
  K.cx = 30;
  K.cy = 1;
  const TrueView view = renderTrueView({scene, {0.5f, 0.5f, 1}}, K, kHere, Vector3f::Zero(), 2);
  // Five parts of the exposure: the edge stands at −0.24, −0.12, 0, 0.12 and 0.24 m, pixels 18, 24, 30, 36 and 42.
  EXPECT_FLOAT_EQ(view.depth.at(10, 1), 2);
  EXPECT_FLOAT_EQ(view.steadiness.at(10, 1), 1);
  EXPECT_FLOAT_EQ(view.depth.at(21, 1), 2);
  EXPECT_FLOAT_EQ(view.steadiness.at(21, 1), 0.8f);
  EXPECT_FLOAT_EQ(view.depth.at(27, 1), 2);
  EXPECT_FLOAT_EQ(view.steadiness.at(27, 1), 0.6f);
  EXPECT_FLOAT_EQ(view.depth.at(33, 1), 3);
  EXPECT_FLOAT_EQ(view.steadiness.at(33, 1), 0.6f);
  EXPECT_FLOAT_EQ(view.depth.at(50, 1), 3);
  EXPECT_FLOAT_EQ(view.steadiness.at(50, 1), 1);
}

TEST(TrueView, HasTheMeanDepthOfWhatComesNearer) {
  RayScene scene;
  scene.setMotion({{board(2.02f, -5, 5, 5)}, {board(1.98f, -5, 5, 5)}});
  fuse_flow::Intrinsics K;
  K.width = K.height = 3;
  K.fx = K.fy = 100;
  K.cx = K.cy = 1;
  const TrueView view = renderTrueView({scene, {0.5f, 0.5f, 1}}, K, kHere, Vector3f::Zero(), 1);
  for (const float z : view.depth.data) EXPECT_NEAR(z, 2, 1e-6f);
  for (const float share : view.steadiness.data) EXPECT_EQ(share, 1);
}

/** \brief Depths of the columns around the middle of the way of an edge, from −0.2 to 0.2 m at 2 m, while the image is exposed. */
std::vector<float> besideTheEdge(const std::string& name) {
  const auto sensor = makeSensor(name, 0.5);
  const RayScene scene = slidingEdge(-0.2f, 0.2f);
  FloatImage depth;
  sensor->measure({scene, {0.5f, 0.5f, 1}}, kHere, {1, 0, 0}, 2, depth);
  const fuse_flow::Intrinsics K = sensor->intrinsics();
  const int reach = static_cast<int>(K.fx * 0.15f / 2);
  std::vector<float> values;
  for (int v = K.height / 4; v < 3 * K.height / 4; ++v)
    for (int u = static_cast<int>(K.cx) - reach; u < static_cast<int>(K.cx) + reach; ++u)
      values.push_back(depth.at(u, v));
  return values;
}

double shareOf(const std::vector<float>& values, const std::function<bool(float)>& of) {
  return static_cast<double>(std::count_if(values.begin(), values.end(), of)) / static_cast<double>(values.size());
}

TEST(Sensor, WithAPatternLosesWhatPassesWhileItIsExposed) {
  for (const char* name : {"structured_light", "active_stereo"}) {
    const std::vector<float> values = besideTheEdge(name);
    // Of the fifths of the exposure one or two are of the other surface: 0.2 or 0.4 of the measurements are lost there.
    const double lost = shareOf(values, [](float z) { return z == 0; });
    EXPECT_GT(lost, 0.15) << name;
    EXPECT_LT(lost, 0.5) << name;
    EXPECT_LT(shareOf(values, [](float z) { return z > 2.2f && z < 2.8f; }), 0.02) << name << ": nothing in between";
  }
}

TEST(Sensor, ByTimeOfFlightMixesWhatPassesWhileItIsExposed) {
  const std::vector<float> values = besideTheEdge("time_of_flight");
  const auto between = [](float z) { return z > 0 && !(z > 1.95f && z < 2.05f) && !(z > 2.95f && z < 3.05f); };
  EXPECT_GT(shareOf(values, between), 0.1);
  EXPECT_GT(shareOf(values, [](float z) { return z == 0; }), 0.4) << "phases that contradict each other";
}

TEST(Sensor, ByTimeOfFlightMeasuresSteadilyWhatStandsStill) {
  // The three images of a static scene have one phase: the depth of an instant, but for rounding.
  RayScene scene;
  scene.setFixed({board(2, -0.3f, 0.4f, 0.3f), board(2.2f, -10, 10, 10)});
  const auto sensor = makeSensor("time_of_flight", 0.3);
  FloatImage instant, exposed;
  sensor->measure(scene, kHere, {1, 0, 0}, 2, instant);
  sensor->measure({scene, {0.5f, 0.5f, 1}}, kHere, {1, 0, 0}, 2, exposed);
  for (std::size_t i = 0; i < instant.data.size(); ++i) ASSERT_NEAR(instant.data[i], exposed.data[i], 1e-5f) << i;
}

TEST(Sensor, ByTimeOfFlightTakesTheMeanOfWhatComesSlowlyNearer) {
  // 8 mm within the exposure: a hundredth of the period, where the phase is nearly linear in the depth.
  RayScene scene;
  scene.setMotion({{board(2.004f, -5, 5, 5)}, {board(1.996f, -5, 5, 5)}});
  const auto sensor = makeSensor("time_of_flight", 0.3);
  FloatImage depth;
  sensor->measure({scene, {0.5f, 0.5f, 1}}, kHere, {1, 0, 0}, 2, depth);
  double sum = 0;
  for (int v = 60; v < 110; ++v)
    for (int u = 70; u < 120; ++u) sum += static_cast<double>(depth.at(u, v)) / 2500;
  EXPECT_NEAR(sum, 2, 0.002);
}

TEST(ColorImage, IsTheMeanOverTheExposure) {
  RayScene scene;
  Object white = board(3, -10, 10, 10), black = board(2, -10, -0.2f, 10);
  white.material = {Material::Plain, {250, 250, 250}, {}, 1, 0.7f};
  black.material = {Material::Plain, {0, 0, 0}, {}, 1, 0.7f};
  Object later = black;
  for (Vector3f& v : later.mesh.vertices)
    if (v.x() > -1) v.x() = 0.2f;
  scene.setFixed({white});
  scene.setMotion({{black}, {later}});
  const fuse_flow::Intrinsics K = makeSensor("ideal", 0.5)->intrinsics();
  ColorImage color;
  renderColor({scene, {0.5f, 0.5f, 1}}, K, kHere, {1, 0, 0}, 2, {}, color);
  const auto mean = [&](float place) {  // of a column
    const int u = static_cast<int>(K.cx + K.fx * place / 2);
    double sum = 0;
    for (int v = 0; v < K.height; ++v) sum += color.at(u, v).r;
    return sum / K.height;
  };
  const double bright = mean(0.4f);
  EXPECT_LT(mean(-0.4f), 3);
  EXPECT_NEAR(mean(-0.12f) / bright, 0.2, 0.02);
  EXPECT_NEAR(mean(0.04f) / bright, 0.6, 0.02);
  EXPECT_NEAR(mean(0.12f) / bright, 0.8, 0.02);
}

LoadedFrame measured(const SimulationOptions& options, std::size_t frame) {
  LoadedFrame out;
  Simulator(options).measure(frame, out);
  return out;
}

TEST(Simulator, HasARollingShutterAndBlursOnlyWhatMoves) {
  SimulationOptions options;
  options.scene = "punch";
  options.rig = "ring-3";
  options.sensor = "ideal";
  options.scale = 0.25;
  options.frames_per_second = 1000;
  const LoadedFrame instant = measured(options, 455);
  options.faults.readout_time = 0.03;
  const LoadedFrame rolling = measured(options, 455), again = measured(options, 455);
  options.faults.exposure_time = 0.01;
  const LoadedFrame blurred = measured(options, 455);
  const auto changed = [](const LoadedFrame& a, const LoadedFrame& b) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < a.images.size(); ++k)
      for (std::size_t i = 0; i < a.images[k].depth16.data.size(); ++i)
        count += a.images[k].depth16.data[i] != b.images[k].depth16.data[i] ? 1 : 0;
    return count;
  };
  EXPECT_GT(changed(instant, rolling), 50u);
  EXPECT_GT(changed(rolling, blurred), 20u);
  EXPECT_EQ(changed(rolling, again), 0u);
  // Most of the images is walls, which stand still.
  EXPECT_LT(changed(instant, blurred), instant.images[0].depth16.data.size() * 3 / 10);
  EXPECT_EQ(rolling.rig.stamp, instant.rig.stamp);
  // Nothing moves on the table.
  options.scene = "table";
  const LoadedFrame still = measured(options, 455);
  options.faults.readout_time = options.faults.exposure_time = 0;
  EXPECT_EQ(changed(still, measured(options, 455)), 0u);
}

/** \brief In the middle of a punch, a frame each millisecond. */
SimulationOptions midPunch() {
  SimulationOptions options;
  options.scene = "punch";
  options.rig = "ring-3";
  options.sensor = "ideal";
  options.scale = 0.25;
  options.color = false;
  options.frames_per_second = 1000;
  return options;
}
constexpr std::size_t kPunch = 455;  // ms

/** \brief Pixels of some rows of all cameras whose depth differs by more than 5 mm. */
std::size_t differing(const LoadedFrame& a, const LoadedFrame& b, int first, int last) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < a.images.size(); ++k)
    for (int v = first; v <= last; ++v)
      for (int u = 0; u < a.images[k].depth16.width; ++u)
        count += std::abs(a.images[k].depth16.at(u, v) - b.images[k].depth16.at(u, v)) > 50 ? 1 : 0;
  return count;
}

TEST(Simulator, RollsAboutTheTimeOfTheImage) {
  SimulationOptions options = midPunch();
  const LoadedFrame middle = measured(options, kPunch);
  const int rows = middle.images[0].depth16.height;
  ASSERT_EQ(rows, 120);
  options.faults.readout_time = 0.04;
  const LoadedFrame rolling = measured(options, kPunch);
  options.faults.readout_time = 0;
  std::size_t as_at_its_time = 0, as_in_the_middle = 0, as_upside_down = 0;
  for (int ms = -18; ms <= 18; ms += 4) {  // rows that are exposed within a millisecond and a half of it
    const int row = static_cast<int>(std::lround((ms / 40.0 + 0.5) * (rows - 1)));
    const LoadedFrame then = measured(options, kPunch + static_cast<std::size_t>(ms + 20) - 20);
    const LoadedFrame mirrored = measured(options, kPunch + static_cast<std::size_t>(20 - ms) - 20);
    as_at_its_time += differing(rolling, then, row - 1, row + 1);
    as_in_the_middle += differing(rolling, middle, row - 1, row + 1);
    as_upside_down += differing(rolling, mirrored, row - 1, row + 1);
  }
  EXPECT_GT(as_in_the_middle, 40u);
  EXPECT_LT(3 * as_at_its_time, as_in_the_middle);
  EXPECT_LT(3 * as_at_its_time, as_upside_down);
}

TEST(Simulator, ExposesAboutTheTimeOfTheImage) {
  // Five parts of 20 ms: where a pixel saw one surface in all of them, its depth is the mean of five instants.
  SimulationOptions options = midPunch();
  options.faults.exposure_time = 0.02;
  const LoadedFrame exposed = measured(options, kPunch);
  options.faults.exposure_time = 0;
  std::vector<LoadedFrame> instants;
  for (const std::size_t ms : {447u, 451u, 455u, 459u, 463u}) instants.push_back(measured(options, ms));
  std::size_t compared = 0, wrong = 0;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < exposed.images[k].depth16.data.size(); ++i) {
      double sum = 0;
      int least = 65535, most = 0;
      for (const LoadedFrame& frame : instants) {
        const int depth = frame.images[k].depth16.data[i];
        sum += depth / 5.0;
        least = std::min(least, depth);
        most = std::max(most, depth);
      }
      if (least == 0 || most - least < 100 || most > least * 1.04) continue;  // moves by more than a centimetre
      ++compared;
      wrong += std::abs(exposed.images[k].depth16.data[i] - sum) > 15 ? 1 : 0;
    }
  EXPECT_GT(compared, 40u);
  EXPECT_LT(wrong * 20, compared);
}

}  // namespace
