#include "ranks.h"

namespace {

using fuse_flow::PointFused;
using fuse_flow::distributed::BlockPoints;
using fuse_flow::distributed::Communicator;
using fuse_flow::distributed::Message;
using fuse_flow::distributed::PartSummary;
using fuse_flow::distributed::RankError;

PartSummary summary() {
  PartSummary part;
  part.rig = 11;
  part.parameters = 12;
  part.stamp = 13;
  part.gated = 14;
  part.views.resize(2);
  part.views[1].view = 2;
  part.views[1].noise_scale = 1.5f;
  part.blocks = {{77, 0b101, 0, 9}, {78, 0b100, 0, 1}};
  return part;
}

/** \brief As another rank reads it, of a rig of three cameras. */
PartSummary readBack(const Message& message) {
  PartSummary part;
  part.read(message, 4, 3);
  return part;
}
Message written(const PartSummary& part) {
  Message message;
  part.write(message);
  return message;
}

TEST(RankMessages, ASummaryIsReadAsItWasWritten) {
  const PartSummary part = readBack(written(summary()));
  EXPECT_EQ(part.rig, 11u);
  EXPECT_EQ(part.parameters, 12u);
  EXPECT_EQ(part.stamp, 13u);
  EXPECT_EQ(part.gated, 14u);
  ASSERT_EQ(part.views.size(), 2u);
  EXPECT_EQ(part.views[1].view, 2u);
  EXPECT_EQ(part.views[1].noise_scale, 1.5f);
  ASSERT_EQ(part.blocks.size(), 2u);
  EXPECT_EQ(part.blocks[0].block, 77u);
  EXPECT_EQ(part.blocks[0].views, 0b101u);
  EXPECT_EQ(part.blocks[0].points, 9u);
}

TEST(RankMessages, ASummaryOfAnotherLengthIsRefusedWhateverItSays) {
  const Message whole = written(summary());
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THROW(readBack(Message(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))), RankError)
        << size;
  Message longer = whole;
  longer.push_back(0);
  EXPECT_THROW(readBack(longer), RankError);
}

TEST(RankMessages, ASummaryThatCannotBeIsRefusedAndNamesTheRank) {
  const auto refuses = [](const PartSummary& part) {
    try {
      readBack(written(part));
    } catch (const RankError& error) {
      return error.rank() == 4;
    }
    return false;
  };
  EXPECT_FALSE(refuses(summary()));
  PartSummary part = summary();
  part.views[1].view = 3;
  EXPECT_TRUE(refuses(part)) << "a camera that the rig does not have";
  part = summary();
  part.views.resize(4);
  EXPECT_TRUE(refuses(part)) << "more views than cameras";
  part = summary();
  part.blocks[1].views = 0b1000;
  EXPECT_TRUE(refuses(part)) << "points of a camera that the rig does not have";
  part.blocks[1] = {78, 1, 1, 1};
  EXPECT_TRUE(refuses(part)) << "a group of views that the rig does not have";
  part.blocks[1] = {78, 0b100, 0, 0};
  EXPECT_TRUE(refuses(part)) << "no points, by which work would be divided";
  Message other_version = written(summary());
  ++other_version[4];
  EXPECT_THROW(readBack(other_version), RankError);
}

/** \brief Changes what comes in one of the exchanges, counted from 0. */
class Lying : public Communicator {
 public:
  Lying(Communicator& ranks, int exchange, std::function<void(Message&)> change)
      : ranks_(ranks), exchange_(exchange), change_(std::move(change)) {}
  int rank() const override { return ranks_.rank(); }
  int size() const override { return ranks_.size(); }
  void exchange(const std::vector<Outgoing>& out, const std::vector<int>& from, std::vector<Message>& in) override {
    ranks_.exchange(out, from, in);
    if (exchange_-- == 0)
      for (Message& message : in) change_(message);
  }

 private:
  Communicator& ranks_;
  int exchange_;
  std::function<void(Message&)> change_;
};

TEST(RankMessages, WindowsThatCannotBeAreRefused) {
  const scenes::Scene scene = ranks::noisyRoom(4, 20);
  const auto refuses = [&](const std::function<void(Message&)>& change) {
    bool refused = false;
    ranks::forEachRank(2, [&](int rank, Communicator& communicator) {
      Lying lying(communicator, rank == 0 ? 1 : -1, change);
      fuse_flow::distributed::FuseFlow<PointFused> fusion(lying);
      scenes::Cloud cloud;
      try {
        fusion.fuse(ranks::partOf(scene.rig, ranks::inTurn(4, 2), rank), cloud);
      } catch (const RankError& error) {
        refused = rank == 0 && error.rank() == 1;
      }
    });
    return refused;
  };
  const auto put = [](std::size_t place, std::uint32_t value) {
    return [=](Message& message) { std::memcpy(message.data() + place, &value, sizeof value); };
  };
  // The number of windows; of the first its view, left, top, right, bottom and points.
  EXPECT_FALSE(refuses([](Message&) {}));
  EXPECT_TRUE(refuses(put(0, 0xffffffffu)));
  EXPECT_TRUE(refuses(put(0, 1)));
  EXPECT_TRUE(refuses(put(4, 0))) << "a view of rank 0";
  EXPECT_TRUE(refuses(put(4, 4000)));
  EXPECT_TRUE(refuses(put(8, 0x80000000u)));
  EXPECT_TRUE(refuses(put(16, 100000)));
  EXPECT_TRUE(refuses(put(20, 0)));
  EXPECT_TRUE(refuses(put(24, 0xfffffffu)));
  EXPECT_TRUE(refuses(put(24, 1)));
  EXPECT_TRUE(refuses([](Message& message) { message.pop_back(); }));
  EXPECT_TRUE(refuses([](Message& message) { message.clear(); }));
}

}  // namespace
