#include "viewer/playback.h"

#include <gtest/gtest.h>

namespace {

using fuse_flow::viewing::Playback;

TEST(Playback, PausedStaysWhereItIs) {
  Playback playback(10, 30);
  playback.advance(100);
  EXPECT_EQ(playback.frame(), 0u);
}

TEST(Playback, PlaysFramesAtTheirRate) {
  Playback playback(100, 10);
  playback.play();
  playback.advance(0.26);
  EXPECT_EQ(playback.frame(), 2u);
  playback.advance(0.25);
  EXPECT_EQ(playback.frame(), 5u) << "what is left of a frame's time is not lost";
}

TEST(Playback, ASlowWindowSkipsFramesInsteadOfFallingBehind) {
  Playback playback(100, 30);
  playback.play();
  playback.advance(1);
  EXPECT_EQ(playback.frame(), 30u);
}

TEST(Playback, SpeedMultipliesTheRateAndKeepsWithinItsLimits) {
  Playback playback(1000, 10);
  playback.play();
  playback.setSpeed(0.5);
  playback.advance(1);
  EXPECT_EQ(playback.frame(), 5u);
  playback.setSpeed(1e9);
  EXPECT_EQ(playback.speed(), Playback::kFastest);
  playback.setSpeed(0);
  EXPECT_EQ(playback.speed(), Playback::kSlowest);
}

TEST(Playback, LoopingGoesOnAtTheBeginning) {
  Playback playback(4, 1);
  playback.play();
  playback.advance(4);
  EXPECT_EQ(playback.frame(), 0u) << "the last frame had its time";
  playback.advance(9);
  EXPECT_EQ(playback.frame(), 1u);
  EXPECT_TRUE(playback.playing());
}

TEST(Playback, WithoutLoopingItPausesOnTheLastFrameAndPlaysAgainFromTheFirst) {
  Playback playback(4, 1);
  playback.setLoop(false);
  playback.play();
  playback.advance(3.9);
  EXPECT_TRUE(playback.playing());
  playback.advance(5);
  EXPECT_EQ(playback.frame(), 3u);
  EXPECT_FALSE(playback.playing());
  playback.play();
  EXPECT_EQ(playback.frame(), 0u);
}

TEST(Playback, SteppingPausesAndMovesByWholeFrames) {
  Playback playback(10, 1);
  playback.play();
  playback.advance(2.9);
  playback.step(1);
  EXPECT_FALSE(playback.playing());
  EXPECT_EQ(playback.frame(), 3u);
  playback.step(-2);
  EXPECT_EQ(playback.frame(), 1u);
}

TEST(Playback, SteppingGoesAroundTheEndsOnlyWhereItLoops) {
  Playback playback(4, 1);
  playback.step(-1);
  EXPECT_EQ(playback.frame(), 3u);
  playback.step(10);
  EXPECT_EQ(playback.frame(), 1u);
  playback.setLoop(false);
  playback.step(-10);
  EXPECT_EQ(playback.frame(), 0u);
  playback.step(10);
  EXPECT_EQ(playback.frame(), 3u);
}

TEST(Playback, SeeksNoFurtherThanTheLastFrame) {
  Playback playback(4, 1);
  playback.seek(2);
  EXPECT_EQ(playback.frame(), 2u);
  playback.seek(99);
  EXPECT_EQ(playback.frame(), 3u);
  playback.seek(0);
  playback.seekEnd();
  EXPECT_EQ(playback.frame(), 3u);
}

TEST(Playback, ASourceWithoutAnEndGoesOn) {
  Playback playback(std::nullopt, 10);
  playback.play();
  playback.advance(1000);
  EXPECT_EQ(playback.frame(), 10000u);
  playback.step(-20000);
  EXPECT_EQ(playback.frame(), 0u);
}

}  // namespace
