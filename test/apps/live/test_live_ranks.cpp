#include "live/live_ranks.h"

#include "../recordings/io_fixture.h"
#include "hand_fed_cameras.h"

#include <fuse_flow/distributed/message.h>
#include <fuse_flow/distributed/thread_ranks.h>

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace live_test;
using io_test::refuses;
using namespace std::chrono_literals;
using distributed::Communicator;
using distributed::Message;
using distributed::MessageWriter;
using distributed::ThreadRanks;
using Sources = std::vector<std::unique_ptr<io::CameraSource>>;

/** \brief Rank 0 in this thread, the others each in one of their own; their cameras deliver when a test says so. */
class LiveRanks : public testing::Test {
 protected:
  struct Other {
    HandFedCameras* cameras{nullptr};
    std::vector<io::LiveInstant> fused;  ///< when its thread has ended
    std::vector<bool> refined;           ///< whether poses were to be searched in it
    std::vector<Camera> told;
    std::thread thread;
  };

  /** \brief Names of the cameras of each rank; a rank may have none. */
  void start(std::vector<std::vector<std::string>> names, ClockModel clocks = ClockModel::Shared) {
    ranks_ = std::make_unique<ThreadRanks>(static_cast<int>(names.size()), 20);
    others_.resize(names.size() - 1);
    const auto sourcesOf = [&](std::size_t rank, HandFedCameras*& cameras) {
      Sources sources;
      if (names[rank].empty()) return sources;
      auto owned = std::make_unique<HandFedCameras>(names[rank], clocks);
      cameras = owned.get();
      sources.push_back(std::move(owned));
      return sources;
    };
    for (std::size_t k = 0; k < others_.size(); ++k) {
      Other& other = others_[k];
      Sources sources = sourcesOf(k + 1, other.cameras);
      other.thread = std::thread([this, k, &other, its = std::move(sources)]() mutable {
        Communicator& communicator = ranks_->communicator(static_cast<int>(k) + 1);
        io::FollowingRank rank(communicator, std::move(its));
        rank.meet(communicator);
        other.told = rank.cameras();
        rank.run([&](const io::LiveInstant& instant, bool refines) {
          other.fused.push_back(instant);
          other.refined.push_back(refines);
        });
      });
    }
    leader_ = std::make_unique<io::LeadingRank>(ranks_->communicator(0));
    Sources all = leader_->meet(sourcesOf(0, first_), ranks_->communicator(0));
    io::LiveRig::Options options;
    options.one_clock = clocks == ClockModel::Shared;
    options.clock = [this] { return time_; };
    rig_ = std::make_unique<io::LiveRig>(std::move(all), options);
    leader_->begin(rig_->cameras(), ranks_->communicator(0));
    rig_->start();
    leader_->awaitOthers(ranks_->communicator(0));
  }
  void stop() {
    leader_->stop();
    for (Other& other : others_) other.thread.join();
    rig_->stop();
  }
  void TearDown() override {
    for (Other& other : others_) ASSERT_FALSE(other.thread.joinable()) << "stop() was not called";
  }

  std::unique_ptr<ThreadRanks> ranks_;
  std::deque<Other> others_;
  std::unique_ptr<io::LeadingRank> leader_;
  std::unique_ptr<io::LiveRig> rig_;
  HandFedCameras* first_{nullptr};
  std::chrono::microseconds time_{100s};
  io::LiveInstant instant_;
};

TEST_F(LiveRanks, CamerasWithoutDepthAreKnownOfAllRanks) {
  start({{"a"}, {"rgb", "c"}});
  EXPECT_EQ(rig_->lacksDepth(), (std::vector<bool>{false, true, false}));
  stop();
}

TEST_F(LiveRanks, TheFirstSaysInWhichInstantsPosesAreSearched) {
  start({{"a"}, {"b"}});
  for (const std::uint64_t k : {1, 2, 3}) {
    first_->deliver(0, 1000000 * k, 7);
    others_[0].cameras->deliver(0, 1000000 * k, 7);
    leader_->poll();
    ASSERT_TRUE(rig_->next(0ms, instant_));
    leader_->fuse(instant_, k == 2);
  }
  stop();
  EXPECT_EQ(others_[0].refined, (std::vector<bool>{false, true, false}));
}

TEST_F(LiveRanks, EachFusesTheImagesThatAreThereOfOneInstant) {
  start({{"a"}, {"b", "c"}, {"d"}});
  others_[0].cameras->deliver(1, 1000400, 7);
  first_->deliver(0, 1000000, 7);
  others_[1].cameras->deliver(0, 1000200, 7);
  others_[0].cameras->deliver(0, 999000, 6);
  others_[0].cameras->deliver(0, 1000100, 7);
  EXPECT_FALSE(rig_->next(0ms, instant_)) << "nobody has asked the others yet";
  leader_->poll();
  ASSERT_TRUE(rig_->next(0ms, instant_));
  EXPECT_EQ(instant_.stamps, (std::vector<std::optional<std::uint64_t>>{1000000, 1000100, 1000400, 1000200}));
  EXPECT_FALSE(instant_.rig.views[0].missing());
  for (const std::size_t camera : {1, 2, 3}) {
    EXPECT_EQ(instant_.held[camera], nullptr);
    EXPECT_TRUE(instant_.rig.views[camera].missing());
  }
  leader_->fuse(instant_);
  stop();
  for (std::size_t rank = 0; rank < 2; ++rank) {
    ASSERT_EQ(others_[rank].fused.size(), 1u);
    const io::LiveInstant& there = others_[rank].fused[0];
    EXPECT_EQ(there.rig.stamp, instant_.rig.stamp);
    ASSERT_EQ(there.rig.views.size(), 4u);
    ASSERT_EQ(there.rig.cameras.size(), 4u);
    const std::size_t first = rank == 0 ? 1 : 3, end = rank == 0 ? 3 : 4;
    for (std::size_t camera = 0; camera < 4; ++camera) {
      EXPECT_EQ(there.rig.cameras[camera].name, rig_->cameras()[camera].name);
      const bool own = camera >= first && camera < end;
      ASSERT_EQ(there.rig.views[camera].missing(), !own) << rank << ' ' << camera;
      if (!own) continue;
      EXPECT_EQ(there.rig.views[camera].depth16.row(1)[1], NumberedRig::valueOf(camera - first, 7));
    }
  }
}

TEST_F(LiveRanks, CamerasAreThoseOfAllInTheOrderOfTheRanks) {
  start({{"left"}, {"left", "right"}});
  const std::vector<Camera> expected = rig_->cameras();
  ASSERT_EQ(expected.size(), 3u);
  EXPECT_EQ(expected[1].name, "left_2");
  stop();
  ASSERT_EQ(others_[0].told.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(others_[0].told[k].name, expected[k].name);
    EXPECT_TRUE(sameCalibration(others_[0].told[k], expected[k]));
  }
}

TEST_F(LiveRanks, ARankMayHaveNoCamera) {
  start({{}, {"a"}, {}});
  others_[0].cameras->deliver(0, 5000, 3);
  leader_->poll();
  ASSERT_TRUE(rig_->next(0ms, instant_));
  leader_->fuse(instant_);
  stop();
  ASSERT_EQ(others_[1].fused.size(), 1u) << "it takes its share of the fusion";
  EXPECT_TRUE(others_[1].fused[0].rig.views[0].missing());
  EXPECT_EQ(others_[0].fused[0].rig.views[0].depth16.row(0)[0], NumberedRig::valueOf(0, 3));
}

TEST_F(LiveRanks, ACameraThatDeliversNothingIsMissingAndSaid) {
  start({{"a"}, {"b"}});
  first_->deliver(0, 1000000);
  leader_->poll();
  EXPECT_FALSE(rig_->next(0ms, instant_));
  time_ += 101ms;  // max_wait
  ASSERT_TRUE(rig_->next(0ms, instant_));
  EXPECT_FALSE(instant_.stamps[1]);
  leader_->fuse(instant_);
  time_ += 2s;
  others_[0].cameras->notice("b: was unplugged");
  leader_->poll();
  std::string lines;
  for (const std::string& line : rig_->takeNotices()) lines += line + "\n";
  EXPECT_NE(lines.find("rank 1: b: was unplugged"), std::string::npos) << lines;
  EXPECT_NE(lines.find("camera 'b' has not delivered anything yet"), std::string::npos) << lines;
  stop();
  ASSERT_EQ(others_[0].fused.size(), 1u);
  EXPECT_TRUE(others_[0].fused[0].rig.views[1].missing());
}

// Whose clock is how far ahead is told by when views came, not by when rank 0 heard of them.
TEST_F(LiveRanks, TimeOnTheWayIsNoOffsetOfTheClock) {
  start({{"a"}, {"b"}}, ClockModel::Separate);
  first_->deliver(0, 1000000);
  others_[0].cameras->deliver(0, 1000000, 0, 40s);
  leader_->poll();
  const std::chrono::microseconds offset = rig_->status()[1].clock_offset;
  EXPECT_LT(offset, -35s);
  EXPECT_GT(offset, -45s);
  stop();
}

TEST_F(LiveRanks, WhatEndsASourceElsewhereIsSaidWithItsRank) {
  start({{"a"}, {"b"}});
  others_[0].cameras->runs = false;
  first_->runs = false;
  leader_->poll();
  EXPECT_FALSE(rig_->running());
  others_[0].cameras->why = "its file is damaged";
  leader_->poll();
  EXPECT_TRUE(refuses([&] { rig_->running(); }, {"rank 1: its file is damaged"}));
  stop();
}

TEST_F(LiveRanks, ViewsThatWaitForLongAreGivenUpAndSaid) {
  start({{"a"}, {"b"}});
  others_[0].cameras->deliver(0, 1000, 1);
  first_->deliver(0, 1000, 1);
  leader_->poll();
  ASSERT_TRUE(rig_->next(0ms, instant_));
  for (std::uint64_t k = 2; k < 100; ++k) others_[0].cameras->deliver(0, 1000 * k, k);
  leader_->fuse(instant_);  // late: its view has gone
  for (std::uint64_t k = 80; k < 100; ++k) first_->deliver(0, 1000 * k, k);
  leader_->poll();
  std::string lines;
  for (const std::string& line : rig_->takeNotices()) lines += line + "\n";
  EXPECT_NE(lines.find("rank 1: camera 'b': its view of one instant was no more there"), std::string::npos) << lines;
  ASSERT_TRUE(rig_->next(0ms, instant_));  // the newest are there
  EXPECT_EQ(instant_.stamps[1], 99000u);
  leader_->fuse(instant_);
  stop();
  ASSERT_EQ(others_[0].fused.size(), 2u);
  EXPECT_TRUE(others_[0].fused[0].rig.views[1].missing());
  EXPECT_EQ(others_[0].fused[1].rig.views[1].depth16.row(0)[0], NumberedRig::valueOf(0, 99));
}

/** \brief What a rank sends to rank 0 as it is, beside rank 0's meet() and, if it comes so far, poll(). */
void meetWith(const std::vector<Message>& sent) {
  ThreadRanks ranks(2, 20);
  std::thread other([&] {
    std::vector<Message> in;
    Communicator& communicator = ranks.communicator(1);
    communicator.exchange({{0, sent[0].data(), sent[0].size()}}, {}, in);
  });
  other.join();
  io::LeadingRank leader(ranks.communicator(0));
  leader.meet({}, ranks.communicator(0));
}

TEST(LiveRankMessages, ARecordingIsSharedOutAmongTheRanksThatPlayIt) {
  const auto partsOf = [](const std::vector<std::string>& played) {
    ThreadRanks ranks(static_cast<int>(played.size()), 20);
    std::vector<std::pair<int, int>> parts(played.size());
    std::vector<std::thread> threads;
    for (std::size_t k = 0; k < played.size(); ++k)
      threads.emplace_back([&, k] {
        try {
          const io::RankPart part = io::partOfPlayed(ranks.communicator(static_cast<int>(k)), played[k]);
          parts[k] = {part.part, part.parts};
        } catch (const distributed::RankError&) {
          parts[k] = {-1, -1};
        }
      });
    for (std::thread& thread : threads) thread.join();
    return parts;
  };
  using Parts = std::vector<std::pair<int, int>>;
  EXPECT_EQ(partsOf({"a", "a", "a"}), (Parts{{0, 3}, {1, 3}, {2, 3}}));
  EXPECT_EQ(partsOf({"", "a", "", "a"}), (Parts{{0, 0}, {0, 2}, {0, 0}, {1, 2}}));
  EXPECT_EQ(partsOf({"", ""}), (Parts{{0, 0}, {0, 0}}));
  EXPECT_EQ(partsOf({"a", "b"}), (Parts{{-1, -1}, {-1, -1}}));
  EXPECT_EQ(partsOf({"", "a", "b"}), (Parts{{-1, -1}, {-1, -1}, {-1, -1}})) << "all must hear of it";
}

TEST(LiveRankMessages, AnotherVersionAndGarbageAreRefusedWithTheRank) {
  Message other_version;
  MessageWriter(other_version).put(std::uint32_t{99});
  Message many;
  MessageWriter writer(many);
  writer.put(std::uint32_t{3});  // as it should be
  writer.put(std::uint32_t{4000000000u});
  for (const Message& message : {Message(), other_version, many}) {
    try {
      meetWith({message});
      ADD_FAILURE() << "was believed";
    } catch (const distributed::RankError& error) {
      EXPECT_EQ(error.rank(), 1);
    }
  }
  EXPECT_TRUE(refuses<distributed::RankError>([&] { meetWith({other_version}); },
                                              {"rank 1", "another version", "99", "must be 3"}));
}

}  // namespace
