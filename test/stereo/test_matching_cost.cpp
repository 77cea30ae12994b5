#include <fuse_flow/math/stereo/matching_cost.h>
#include <fuse_flow/math/stereo/propagation.h>

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace {

using namespace fuse_flow;

/** \brief An image with its quads. */
class Image {
 public:
  template <typename Level>
  Image(int width, int height, const Level& level) : width_(width), height_(height) {
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) pixels_.push_back(static_cast<std::uint8_t>(level(u, v)));
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) quads_.push_back(quadOf(pixels_.data(), width, height, u, v));
  }
  GreyImage view() const { return {pixels_.data(), quads_.data(), width_, height_}; }

 private:
  int width_, height_;
  std::vector<std::uint8_t> pixels_;
  std::vector<std::uint32_t> quads_;
};

int speckled(int u, int v) {
  std::uint32_t h = static_cast<std::uint32_t>(u) * 2654435761u ^ static_cast<std::uint32_t>(v) * 40503u * 65537u;
  h = (h ^ h >> 15) * 0x846ca68bu;
  return static_cast<int>((h ^ h >> 16) % 100u) + 50;
}

constexpr WindowForm kForm{2, 30, 3};

LocalWarp shift(float u, float v) { return {u, v, 1, 0, 0, 1, true}; }

TEST(MatchingCost, OfAnImageWithItselfIsNone) {
  const Image image(40, 30, speckled);
  const ReferenceWindow window = referenceWindow(image.view(), 20, 15, kForm);
  EXPECT_LT(matchingCost(window, kForm, shift(20, 15), image.view()), 0.02f);  // not 0: variance of noise is added
  EXPECT_GT(matchingCost(window, kForm, shift(23, 15), image.view()), 0.3f);
}

TEST(MatchingCost, GainAndOffsetOfAnImageDoNotMatter) {
  const Image image(40, 30, speckled), darker(40, 30, [](int u, int v) { return speckled(u, v) / 2 + 20; });
  const ReferenceWindow window = referenceWindow(image.view(), 20, 15, kForm);
  EXPECT_LT(matchingCost(window, kForm, shift(20, 15), darker.view()), 0.03f);
}

TEST(MatchingCost, OfTheOppositeIsTwo) {
  const Image image(40, 30, speckled), negative(40, 30, [](int u, int v) { return 255 - speckled(u, v); });
  const ReferenceWindow window = referenceWindow(image.view(), 20, 15, kForm);
  EXPECT_GT(matchingCost(window, kForm, shift(20, 15), negative.view()), 1.95f);
}

TEST(MatchingCost, WithoutTextureNothingIsAlike) {
  const Image white(40, 30, [](int, int) { return 200; }),
      noisy(40, 30, [](int u, int v) { return 200 + speckled(u, v) % 2; });
  EXPECT_NEAR(matchingCost(referenceWindow(white.view(), 20, 15, kForm), kForm, shift(20, 15), white.view()), 1, 1e-6);
  EXPECT_GT(matchingCost(referenceWindow(noisy.view(), 20, 15, kForm), kForm, shift(20, 15), noisy.view()), 0.9f);
}

TEST(MatchingCost, BesideTheImageOrBehindTheCameraIsTheWorst) {
  const Image image(40, 30, speckled);
  const ReferenceWindow window = referenceWindow(image.view(), 20, 15, kForm);
  for (const LocalWarp& warp : {shift(-0.1f, 15), shift(39.1f, 15), shift(20, -0.1f), shift(20, 29.1f), shift(NAN, 15)})
    EXPECT_EQ(matchingCost(window, kForm, warp, image.view()), kWorstCost);
  LocalWarp behind = shift(20, 15);
  behind.in_front = false;
  EXPECT_EQ(matchingCost(window, kForm, behind, image.view()), kWorstCost);
  for (const auto& [u, v] : {std::pair(0, 0), std::pair(39, 0), std::pair(0, 29), std::pair(39, 29)}) {
    const ReferenceWindow corner = referenceWindow(image.view(), u, v, kForm);
    EXPECT_LT(matchingCost(corner, kForm, shift(static_cast<float>(u), static_cast<float>(v)), image.view()), 0.05f);
  }
}

TEST(MatchingCost, BetweenPixelsLevelsAreInterpolated) {
  const Image texture(40, 30, speckled);
  const Image half(40, 30, [](int u, int v) { return (speckled(u, v) + speckled(u + 1, v) + 1) / 2; });
  const ReferenceWindow window = referenceWindow(half.view(), 20, 15, kForm);
  EXPECT_LT(matchingCost(window, kForm, shift(20.5f, 15), texture.view()), 0.02f);
  EXPECT_GT(matchingCost(window, kForm, shift(20, 15), texture.view()), 0.1f);
}

TEST(BestCosts, AreTheSmallest) {
  BestCosts best;
  for (const float cost : {0.9f, 0.3f, 1.5f, 0.1f, 0.7f, 2.0f}) best.add(cost);
  EXPECT_FLOAT_EQ(best.mean(1), 0.1f);
  EXPECT_FLOAT_EQ(best.mean(2), 0.2f);
  EXPECT_FLOAT_EQ(best.mean(4), 0.5f);
}

TEST(InversePlane, IsThatOfThePlane) {
  // n · X = d with n = (0.6, 0, 0.8), d = 1.6: on the optical axis at z = 2.
  const InversePlane plane{0.6f / 1.6f, 0, 0.8f / 1.6f};
  EXPECT_FLOAT_EQ(1 / inverseDepth(plane, {0, 0}), 2.0f);
  const Ray ray{0.5f, -0.2f};
  const float z = 1 / inverseDepth(plane, ray);
  EXPECT_NEAR(0.6f * ray.x * z + 0.8f * z, 1.6f, 1e-6f);
  const Vec3 normal = normalOf(plane);
  EXPECT_FLOAT_EQ(normal.x, -0.6f);
  EXPECT_FLOAT_EQ(normal.z, -0.8f);
  EXPECT_FLOAT_EQ(incidenceCosine(plane, {0, 0}, 0.5f), 0.8f);
  const InversePlane through = planeThrough(ray, 1 / z, plane.x, plane.y);
  EXPECT_NEAR(through.w, plane.w, 1e-6f);
}

TEST(LocalWarp, IsTheHomographyNearThePixel) {
  Intrinsics K;
  K.fx = K.fy = 500;
  K.cx = 320, K.cy = 240;
  // Another view, 0.3 m to the right, turned by 0.1 rad about the vertical axis, with the same lens.
  const float c = std::cos(0.1f), s = std::sin(0.1f);
  const Vec3 r[3] = {{c, 0, s}, {0, 1, 0}, {-s, 0, c}}, t{-0.3f, 0.02f, 0.05f};
  const auto row = [&](float f, float o, int k) { return f * r[k] + o * r[2]; };
  const ViewWarp warp{row(500, 320, 0), row(500, 240, 1), r[2], {500 * t.x + 320 * t.z, 500 * t.y + 240 * t.z, t.z}};
  const InversePlane plane{0.05f, -0.1f, 0.5f};
  const auto exact = [&](float u, float v) {
    const Ray ray{(u - K.cx) / K.fx, (v - K.cy) / K.fy};
    const Vec3 p = pointOnRay(ray, 1 / inverseDepth(plane, ray));
    const Vec3 q{dot(r[0], p) + t.x, dot(r[1], p) + t.y, dot(r[2], p) + t.z};
    return Pixel{500 * q.x / q.z + 320, 500 * q.y / q.z + 240};
  };
  const float u = 400, v = 150;
  const LocalWarp local = localWarp(warp, plane, {(u - K.cx) / K.fx, (v - K.cy) / K.fy}, 1 / K.fx, 1 / K.fy);
  EXPECT_TRUE(local.in_front);
  EXPECT_NEAR(local.u, exact(u, v).u, 1e-3f);
  EXPECT_NEAR(local.v, exact(u, v).v, 1e-3f);
  for (const float du : {-4.0f, 4.0f})
    for (const float dv : {-4.0f, 4.0f}) {
      EXPECT_NEAR(local.u + local.u_du * du + local.u_dv * dv, exact(u + du, v + dv).u, 0.03f);
      EXPECT_NEAR(local.v + local.v_du * du + local.v_dv * dv, exact(u + du, v + dv).v, 0.03f);
    }
}

TEST(Propagation, CandidatesHaveTheOtherColourOfTheCheckerboard) {
  std::set<std::pair<int, int>> all;
  for (int area = 0; area < kPropagationAreas; ++area)
    for (int k = 0; k < (area < kNearAreas ? kNearOffsets : kFarOffsets); ++k) {
      const PixelOffset offset = candidateOffset(area, k);
      EXPECT_NE((offset.u + offset.v) % 2, 0) << area << " " << k;
      all.emplace(offset.u, offset.v);
    }
  // The pixel's own four neighbours are among them, and as much to the right as to the left, above as below.
  EXPECT_EQ(all.count({1, 0}) + all.count({-1, 0}) + all.count({0, 1}) + all.count({0, -1}), 4u);
  for (const auto& [u, v] : all) EXPECT_EQ(all.count({-u, -v}), 1u);
}

TEST(PixelRandom, IsUniformAndDependsOnEachOfItsSeeds) {
  double sum = 0, squares = 0;
  constexpr int n = 40000;
  for (std::uint32_t k = 0; k < n; ++k) {
    PixelRandom random(1, 2, k, 3);
    random.next();
    const double x = static_cast<double>(random.next());
    EXPECT_GE(x, -1);
    EXPECT_LT(x, 1);
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / n, 0, 0.01);
  EXPECT_NEAR(squares / n, 1.0 / 3, 0.01);
  const float first = PixelRandom(1, 2, 3, 4).next();
  EXPECT_EQ(first, PixelRandom(1, 2, 3, 4).next());
  EXPECT_NE(first, PixelRandom(2, 2, 3, 4).next());
  EXPECT_NE(first, PixelRandom(1, 3, 3, 4).next());
  EXPECT_NE(first, PixelRandom(1, 2, 4, 4).next());
  EXPECT_NE(first, PixelRandom(1, 2, 3, 5).next());
}

TEST(GreyAround, IsTheSumOfNinePixelsOfWhichTheBorderCountsForThoseBeside) {
  const std::uint8_t pixels[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 200};  // four columns
  const GreyImage image{pixels, nullptr, 4, 3};
  EXPECT_EQ(greyAround(image, 1, 1), 1 + 2 + 3 + 5 + 6 + 7 + 9 + 10 + 11);
  EXPECT_EQ(greyAround(image, 0, 0), 1 + 1 + 2 + 1 + 1 + 2 + 5 + 5 + 6);
  EXPECT_EQ(greyAround(image, 3, 2), 7 + 8 + 8 + 11 + 200 + 200 + 11 + 200 + 200);
}

TEST(SurfaceEnds, WhereTheOtherPixelIsFartherThanThePlaneGoesOn) {
  // Here at 2 m: 0.5 in inverse depth. The opposite pixel shows the same plane.
  EXPECT_FALSE(surfaceEnds(0.5f, 0.5f, 0.5f, 0.01f));
  EXPECT_TRUE(surfaceEnds(0.5f, 0.25f, 0.5f, 0.01f)) << "4 m";
  EXPECT_FALSE(surfaceEnds(0.5f, 1.0f, 0.5f, 0.01f)) << "something nearer is another surface's edge";
  EXPECT_FALSE(surfaceEnds(0.5f, 0.496f, 0.5f, 0.01f)) << "less than a hundredth";
  EXPECT_TRUE(surfaceEnds(0.5f, 0.494f, 0.5f, 0.01f));
  // A floor that is seen at a small angle goes on as it comes; one that turns away by less than a hundredth, too.
  EXPECT_FALSE(surfaceEnds(0.5f, 0.48f, 0.52f, 0.01f));
  EXPECT_FALSE(surfaceEnds(0.5f, 0.478f, 0.518f, 0.01f));
  EXPECT_TRUE(surfaceEnds(0.5f, 0.46f, 0.52f, 0.01f));
  // Steps of a tenth.
  EXPECT_FALSE(surfaceEnds(0.5f, 0.46f, 0.5f, 0.1f));
  EXPECT_TRUE(surfaceEnds(0.5f, 0.44f, 0.5f, 0.1f));
  // A thin thing: the opposite pixel is beyond its other edge, or something is before it.
  EXPECT_FALSE(surfaceEnds(0.5f, 0.25f, 0.25f, 0.01f));
  EXPECT_FALSE(surfaceEnds(0.5f, 0.25f, 1.0f, 0.01f));
}

}  // namespace
