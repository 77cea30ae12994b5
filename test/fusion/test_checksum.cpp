#include "../scenes.h"

namespace {

using fuse_flow::FuseFlowParameters;

/** \brief FNV-1a of all that a cloud's points hold. */
std::uint64_t checksum(const scenes::Cloud& cloud) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&hash](std::uint32_t word) {
    for (int byte = 0; byte < 4; ++byte) hash = (hash ^ (word >> 8 * byte & 255u)) * 0x100000001b3u;
  };
  const auto addFloat = [&add](float value) {
    std::uint32_t word = 0;
    std::memcpy(&word, &value, sizeof(word));
    add(word);
  };
  for (const fuse_flow::PointFused& p : cloud) {
    for (const float value : {p.x, p.y, p.z, p.confidence}) addFloat(value);
    add(p.rgba);
    add(p.view_count);
  }
  return hash;
}

/** \brief Four cameras before a ball and a slanted wall: edges, curvature, noise, colour. */
scenes::Scene noisyBallAndWall() {
  scenes::Scene scene = scenes::makeScene(scenes::cameraRow(4), scenes::ballAndWall());
  scenes::addNoise(scene, 0.004f);
  scene.paint({200, 120, 40});
  return scene;
}

// What a frame is fused into is the same to the bit for any number of threads, compiler and processor. A change that is not meant to
// change clouds leaves these numbers as they are; one that is meant to, changes them in its own commit.

TEST(Checksum, OfTheDefaultsIsThatOfBefore) {
  const scenes::Scene scene = noisyBallAndWall();
  for (const unsigned int threads : {1u, 3u})
    EXPECT_EQ(checksum(scenes::fuse(scene.rig, {}, threads)), 15990745086987315749u) << threads << " threads";
}

TEST(Checksum, WhereTheGateIsForEveryMeasurementIsThatOfBefore) {
  FuseFlowParameters parameters;
  parameters.gate_noise = 0;
  EXPECT_EQ(checksum(scenes::fuse(noisyBallAndWall().rig, parameters)), 2749984596211674045u);
}

TEST(Checksum, OfThePublishedFormIsThatOfBefore) {
  EXPECT_EQ(checksum(scenes::fuse(noisyBallAndWall().rig, FuseFlowParameters::published())), 1665348051572652093u);
}

/** \brief The smoothing of before, which made curved surfaces thinner. */
FuseFlowParameters withoutTwicing() {
  FuseFlowParameters parameters;
  parameters.smoothing.twicing = false;
  parameters.smoothing.tolerance = 2.5f;
  parameters.gate_noise = 0;
  return parameters;
}

TEST(Checksum, WithoutTwicingIsThatOfBefore) {
  EXPECT_EQ(checksum(scenes::fuse(noisyBallAndWall().rig, withoutTwicing())), 16970886969963077718u);
}

TEST(Checksum, WhereEveryViewMayJudgeEveryPointIsThatOfBefore) {
  FuseFlowParameters parameters = withoutTwicing();
  parameters.consistency.min_facing = -1;
  parameters.consistency.silhouette_radius = 0;
  EXPECT_EQ(checksum(scenes::fuse(noisyBallAndWall().rig, parameters)), 10502314255852577123u);
}

}  // namespace
