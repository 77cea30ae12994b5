#include "ranks.h"

namespace {

using fuse_flow::FuseFlowParameters;
using fuse_flow::PointFused;
using fuse_flow::distributed::Communicator;
using fuse_flow::distributed::Ownership;
using fuse_flow::distributed::RankError;
using ranks::inTurn;
using ranks::noisyRoom;
using ranks::sameBytes;
using scenes::Cloud;
using scenes::Scene;
using Ranks = fuse_flow::distributed::FuseFlow<PointFused>;

std::vector<int> shuffled(std::size_t cameras, int ranks, unsigned int seed) {
  std::mt19937 random(seed);
  std::vector<int> rank_of;
  for (std::size_t i = 0; i < cameras; ++i) rank_of.push_back(static_cast<int>(random() % static_cast<unsigned int>(ranks)));
  return rank_of;
}

TEST(DistributedFuseFlow, GivesTheBytesOfOneProcessForAnyNumberOfRanksAndAnyAssignment) {
  const Scene scene = noisyRoom(7, 1);
  const Cloud one = scenes::fuse(scene.rig);
  ASSERT_GT(one.size(), 3000u);
  for (const int n : {1, 2, 3, 5, 9}) {
    EXPECT_TRUE(sameBytes(ranks::fuse(scene.rig, inTurn(7, n), n), one)) << n << " ranks";
    EXPECT_TRUE(sameBytes(ranks::fuse(scene.rig, shuffled(7, n, 5u), n), one)) << n << " ranks, shuffled";
  }
}

TEST(DistributedFuseFlow, GivesTheSameBytesByTheCurveAndByTheHash) {
  const Scene scene = noisyRoom(5, 2);
  const Cloud one = scenes::fuse(scene.rig);
  for (const Ownership ownership : {Ownership::Curve, Ownership::Hash})
    EXPECT_TRUE(sameBytes(
        ranks::fuse(scene.rig, inTurn(5, 3), 3, [&](Ranks& fusion) { fusion.setOwnership(ownership); }), one));
}

}  // namespace
