#include "recordings/streams/frame_sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace {

using namespace fuse_flow::io;
using Stamps = std::vector<Nanoseconds>;
using Images = std::vector<std::optional<std::size_t>>;

constexpr Nanoseconds kMs = 1'000'000;

Stamps every(Nanoseconds period, std::size_t count, Nanoseconds start = 0) {
  Stamps stamps;
  for (std::size_t k = 0; k < count; ++k) stamps.push_back(start + static_cast<Nanoseconds>(k) * period);
  return stamps;
}

Stamps without(Stamps stamps, std::size_t image) {
  stamps.erase(stamps.begin() + static_cast<std::ptrdiff_t>(image));
  return stamps;
}

TEST(FrameSets, ImagesOfOneTimeGoTogether) {
  const FrameSets grouped =
      groupByTime({every(33 * kMs, 4), every(33 * kMs, 4, 2 * kMs), every(33 * kMs, 4, -3 * kMs)});
  ASSERT_EQ(grouped.sets.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(grouped.sets[k].images, (Images{k, k, k}));
    EXPECT_EQ(grouped.sets[k].stamp, static_cast<Nanoseconds>(k) * 33 * kMs - kMs / 2);  // between -3 and 2
    EXPECT_EQ(grouped.sets[k].spread, 5 * kMs);
  }
  EXPECT_EQ(grouped.unused, (std::vector<std::size_t>{0, 0, 0}));
  EXPECT_EQ(grouped.tolerance, 33 * kMs / 2);
}

TEST(FrameSets, ALostFrameLeavesItsSetWithoutTheCamera) {
  const FrameSets grouped = groupByTime({every(33 * kMs, 5), without(every(33 * kMs, 5, kMs), 2)});
  ASSERT_EQ(grouped.sets.size(), 5u);
  EXPECT_EQ(grouped.sets[2].images, (Images{2, std::nullopt}));
  EXPECT_EQ(grouped.sets[2].spread, 0);  // the lost one was not taken at any time
  EXPECT_EQ(grouped.sets[3].images, (Images{3, 2}));
  EXPECT_EQ(grouped.unused, (std::vector<std::size_t>{0, 0}));
}

TEST(FrameSets, TheSlowestCameraSetsTheRateAndTakesTheNearestOfTheOthers) {
  // 15 Hz beside 30 Hz: the images at 66, 132 and 198 are nearer to those at 62, 128 and 194 than those between.
  const FrameSets grouped = groupByTime({every(33 * kMs, 8), every(66 * kMs, 3, 62 * kMs)});
  ASSERT_EQ(grouped.sets.size(), 6u);
  EXPECT_EQ(grouped.sets[0].images, (Images{0, std::nullopt}));  // before the slow one begins, nobody waits for it
  EXPECT_EQ(grouped.sets[1].images, (Images{1, std::nullopt}));
  EXPECT_EQ(grouped.sets[2].images, (Images{2, 0}));
  EXPECT_EQ(grouped.sets[3].images, (Images{4, 1}));
  EXPECT_EQ(grouped.sets[4].images, (Images{6, 2}));
  EXPECT_EQ(grouped.sets[5].images, (Images{7, std::nullopt}));  // nor behind its last image
  EXPECT_EQ(grouped.unused, (std::vector<std::size_t>{2, 0}));
}

TEST(FrameSets, ACameraThatStartsLateOrEndsEarlyIsNotWaitedFor) {
  const FrameSets grouped = groupByTime({every(100 * kMs, 6), every(100 * kMs, 3, 200 * kMs)});
  ASSERT_EQ(grouped.sets.size(), 6u);
  EXPECT_EQ(grouped.sets[0].images, (Images{0, std::nullopt}));
  EXPECT_EQ(grouped.sets[2].images, (Images{2, 0}));
  EXPECT_EQ(grouped.sets[4].images, (Images{4, 2}));
  EXPECT_EQ(grouped.sets[5].images, (Images{5, std::nullopt}));
}

TEST(FrameSets, CamerasHalfAPeriodApartKeepTheirPartnersWhenStampsJitter) {
  std::mt19937 random(1);
  std::uniform_int_distribution<Nanoseconds> jitter(-kMs, kMs);
  Stamps left = every(33 * kMs, 300), right = every(33 * kMs, 300, 16 * kMs);
  for (Stamps* stamps : {&left, &right})
    for (Nanoseconds& stamp : *stamps) stamp += jitter(random);
  const FrameSets grouped = groupByTime({left, right});
  EXPECT_LE(grouped.unused[0] + grouped.unused[1], 2u);
  EXPECT_GE(grouped.sets.size(), 299u);
}

TEST(FrameSets, NeitherTheOrderOfCamerasNorTheStartOfTheClockMatters) {
  std::mt19937 random(2);
  std::uniform_int_distribution<Nanoseconds> jitter(-4 * kMs, 4 * kMs);
  std::vector<Stamps> cameras;
  for (int c = 0; c < 4; ++c) {
    Stamps stamps;
    for (int k = 0; k < 50; ++k)
      if (random() % 10 != 0) stamps.push_back(33 * kMs * k + jitter(random));
    cameras.push_back(stamps);
  }
  const FrameSets grouped = groupByTime(cameras, 10 * kMs);
  std::vector<Stamps> moved(cameras.rbegin(), cameras.rend());
  for (Stamps& stamps : moved)
    for (Nanoseconds& stamp : stamps) stamp += 1'700'000'000'000'000'000;
  const FrameSets other = groupByTime(moved, 10 * kMs);
  ASSERT_EQ(grouped.sets.size(), other.sets.size());
  std::size_t images = 0;
  for (std::size_t k = 0; k < grouped.sets.size(); ++k) {
    Images back(other.sets[k].images.rbegin(), other.sets[k].images.rend());
    EXPECT_EQ(grouped.sets[k].images, back) << k;
    EXPECT_EQ(grouped.sets[k].stamp + 1'700'000'000'000'000'000, other.sets[k].stamp);
    for (std::size_t c = 0; c < 4; ++c)
      if (grouped.sets[k].images[c]) {
        ++images;
        EXPECT_LE(std::abs(cameras[c][*grouped.sets[k].images[c]] - grouped.sets[k].stamp), 10 * kMs);
      }
    if (k > 0) {
      EXPECT_GT(grouped.sets[k].stamp, grouped.sets[k - 1].stamp);
    }
  }
  // Every image is in one set or counted.
  const std::size_t unused = std::accumulate(grouped.unused.begin(), grouped.unused.end(), std::size_t{0});
  std::size_t all = 0;
  for (const Stamps& stamps : cameras) all += stamps.size();
  EXPECT_EQ(images + unused, all);
}

TEST(FrameSets, APauseOfADayIsNoMillionLostFrames) {
  Stamps stamps = every(kMs, 3);
  stamps.push_back(86'400'000 * kMs);
  const FrameSets grouped = groupByTime({stamps, stamps});
  EXPECT_EQ(grouped.sets.size(), 4u);
}

TEST(FrameSets, OneCameraAndNoImages) {
  EXPECT_EQ(groupByTime({every(kMs, 3)}).sets.size(), 3u);
  EXPECT_EQ(groupByTime({{}}).sets.size(), 0u);
  const FrameSets grouped = groupByTime({{}, {5}});
  ASSERT_EQ(grouped.sets.size(), 1u);
  EXPECT_EQ(grouped.sets[0].images, (Images{std::nullopt, 0}));
}

TEST(FrameSets, NearestInTime) {
  const Stamps stamps{10, 20, 40};
  EXPECT_EQ(nearestInTime(stamps, 15, 5), std::optional<std::size_t>(0));  // the earlier of two as near
  EXPECT_EQ(nearestInTime(stamps, 16, 5), std::optional<std::size_t>(1));
  EXPECT_EQ(nearestInTime(stamps, 30, 9), std::nullopt);
  EXPECT_EQ(nearestInTime(stamps, 45, 5), std::optional<std::size_t>(2));
  EXPECT_EQ(nearestInTime(stamps, 46, 5), std::nullopt);
  EXPECT_EQ(nearestInTime(stamps, 5, 5), std::optional<std::size_t>(0));
  EXPECT_EQ(nearestInTime({}, 5, 5), std::nullopt);
}

}  // namespace
