#include "viewer/fusing/latest_slot.h"

#include <gtest/gtest.h>

#include <thread>

namespace {

using fuse_flow::viewing::LatestSlot;

TEST(LatestSlot, HoldsOnlyWhatCameLast) {
  LatestSlot<int> slot;
  for (int k = 0; k < 1000; ++k) slot.put(k);
  EXPECT_EQ(slot.take(), 999);
  EXPECT_EQ(slot.take(), std::nullopt) << "the 999 before it are dropped";
}

TEST(LatestSlot, WaitingTakesWhatComes) {
  LatestSlot<int> slot;
  std::optional<int> taken;
  std::thread waiting([&] { taken = slot.waitAndTake(); });
  slot.put(7);
  waiting.join();
  EXPECT_EQ(taken, 7);
}

TEST(LatestSlot, ClosingEndsTheWait) {
  LatestSlot<int> slot;
  std::optional<int> taken = 1;
  std::thread waiting([&] { taken = slot.waitAndTake(); });
  slot.close();
  waiting.join();
  EXPECT_EQ(taken, std::nullopt);
  slot.put(3);
  EXPECT_EQ(slot.waitAndTake(), std::nullopt) << "closed stays closed";
}

}  // namespace
