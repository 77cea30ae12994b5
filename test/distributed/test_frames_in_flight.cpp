#include "ranks.h"

#include <fuse_flow/distributed/frames_in_flight.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace {

using fuse_flow::RigFrame;
using fuse_flow::distributed::Communicator;
using ranks::inTurn;
using ranks::noisyRoom;
using scenes::Cloud;
using scenes::Scene;
using InFlight = fuse_flow::distributed::FramesInFlight<fuse_flow::PointFused>;
using Lanes = std::vector<Communicator*>;

constexpr int kCameras = 5;

/** \brief Frames that differ, in their points and in how many there are: one of a single view, one of none. */
std::vector<Scene> differentScenes() {
  std::vector<Scene> scenes;
  for (unsigned int seed = 1; seed <= 8; ++seed) scenes.push_back(noisyRoom(kCameras, seed));
  for (std::size_t i = 1; i < kCameras; ++i) scenes[2].rig.views[i] = {};
  for (std::size_t i = 0; i < kCameras; ++i) scenes[5].rig.views[i] = {};
  return scenes;
}

Cloud fuseAlone(const RigFrame& frame) {
  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
  Cloud cloud;
  fusion.fuse(frame, cloud);
  return cloud;
}

/** \brief Always as many in flight as may be; take() one after the other. */
void fuseAll(InFlight& fusion, std::size_t lanes, const std::vector<Scene>& scenes, int ranks, int rank,
             const std::function<void(std::size_t)>& take) {
  std::size_t taken = 0;
  for (const Scene& scene : scenes) {
    if (fusion.inFlight() == lanes) take(taken++);
    fusion.submit(ranks::partOf(scene.rig, inTurn(kCameras, ranks), rank));
  }
  while (fusion.inFlight() > 0) take(taken++);
  EXPECT_EQ(taken, scenes.size());
}

TEST(FramesInFlight, GivesTheFramesOfOneProcessInTheirOrder) {
  const std::vector<Scene> scenes = differentScenes();
  std::vector<Cloud> alone;
  for (const Scene& scene : scenes) alone.push_back(fuseAlone(scene.rig));
  ASSERT_GT(alone[0].size(), 3000u);
  for (const auto& [ranks, lanes] : {std::pair<int, std::size_t>{1, 2}, {2, 1}, {2, 3}, {3, 2}, {4, 5}})
    ranks::forEachRankWithLanes(ranks, lanes, [&, ranks = ranks, lanes = lanes](int rank, const Lanes& communicators) {
      InFlight fusion(communicators);
      fusion.forEachLane([](InFlight::Fusion& lane) { lane.setNumberOfThreads(1); });
      fusion.setGatherAt(ranks - 1);
      Cloud cloud;
      fuseAll(fusion, lanes, scenes, ranks, rank, [&](std::size_t frame) {
        fusion.next(cloud);
        const std::string what = std::to_string(ranks) + " ranks, frame " + std::to_string(frame);
        if (rank + 1 == ranks) {
          EXPECT_TRUE(ranks::sameBytes(cloud, alone[frame])) << what;
        } else {
          EXPECT_TRUE(cloud.empty()) << what;
        }
        std::vector<std::size_t> missing;
        for (std::size_t i = 0; i < kCameras; ++i)
          if (scenes[frame].rig.views[i].missing()) missing.push_back(i);
        EXPECT_EQ(fusion.getStatistics().missing_cameras, missing) << what << ": statistics of another frame";
      });
    });
}

TEST(FramesInFlight, LeavesToEachRankThePointsOfItsCells) {
  const std::vector<Scene> scenes = differentScenes();
  std::vector<std::vector<Cloud>> parts(3, std::vector<Cloud>(scenes.size()));
  ranks::forEachRankWithLanes(3, 2, [&](int rank, const Lanes& communicators) {
    InFlight fusion(communicators);
    fuseAll(fusion, 2, scenes, 3, rank,
            [&](std::size_t frame) { fusion.next(parts[static_cast<std::size_t>(rank)][frame]); });
    EXPECT_GT(fusion.getPartStatistics().points, 0u);
  });
  using Bytes = std::array<char, sizeof(fuse_flow::PointFused)>;
  const auto sorted = [](const Cloud& cloud) {
    std::vector<Bytes> bytes(cloud.size());
    for (std::size_t k = 0; k < cloud.size(); ++k)
      std::memcpy(bytes[k].data(), static_cast<const void*>(&cloud[k]), sizeof(Bytes));
    std::sort(bytes.begin(), bytes.end());
    return bytes;
  };
  for (std::size_t frame = 0; frame < scenes.size(); ++frame)
    EXPECT_TRUE(sorted(parts[0][frame] + parts[1][frame] + parts[2][frame]) == sorted(fuseAlone(scenes[frame].rig)))
        << frame;
}

TEST(FramesInFlight, LosesAFrameThatARankCannotFuseAndNoOther) {
  const std::vector<Scene> scenes = differentScenes();
  ranks::forEachRankWithLanes(3, 3, [&](int rank, const Lanes& communicators) {
    InFlight fusion(communicators);
    fusion.setGatherAt(0);
    std::vector<RigFrame> frames;
    for (std::size_t k = 0; k < 6; ++k) frames.push_back(ranks::partOf(scenes[k].rig, inTurn(kCameras, 3), rank));
    if (rank == 1) --frames[1].views[1].depth32.width;
    std::size_t taken = 0;
    Cloud cloud;
    const auto take = [&] {
      if (taken == 1) {
        EXPECT_THROW(fusion.next(cloud), pcl::PCLException) << "rank " << rank;
      } else {
        fusion.next(cloud);
        if (rank == 0) {
          EXPECT_TRUE(ranks::sameBytes(cloud, fuseAlone(scenes[taken].rig))) << taken;
        }
      }
      ++taken;
    };
    for (const RigFrame& frame : frames) {
      if (fusion.inFlight() == 3) take();
      fusion.submit(frame);
    }
    while (fusion.inFlight() > 0) take();
  });
}

TEST(FramesInFlight, EndsWithItsFramesWhateverIsInFlight) {
  const Scene scene = noisyRoom(3, 1);
  for (int k = 0; k < 20; ++k)
    ranks::forEachRankWithLanes(2, 3, [&](int rank, const Lanes& communicators) {
      InFlight fusion(communicators);
      fusion.forEachLane([](InFlight::Fusion& lane) { lane.setNumberOfThreads(1); });
      const RigFrame part = ranks::partOf(scene.rig, inTurn(3, 2), rank);
      for (int frame = 0; frame < 3; ++frame) fusion.submit(part);
    });
}

TEST(FramesInFlight, SaysWhatItRefuses) {
  EXPECT_THROW(InFlight({}), pcl::BadArgumentException);
  EXPECT_THROW(InFlight({nullptr}), pcl::BadArgumentException);
  fuse_flow::distributed::ThreadRanks two(2), three(3);
  EXPECT_THROW(InFlight({&two.communicator(0), &two.communicator(0)}), pcl::BadArgumentException);
  EXPECT_THROW(InFlight({&two.communicator(0), &three.communicator(0)}), pcl::BadArgumentException);
  EXPECT_THROW(InFlight({&two.communicator(0)}).setGatherAt(2), pcl::BadArgumentException);
  const Scene scene = noisyRoom(kCameras, 1);
  ranks::forEachRankWithLanes(1, 2, [&](int, const Lanes& communicators) {
    InFlight fusion(communicators);
    Cloud cloud;
    const auto refusal = [](const auto& call) -> std::string {
      try {
        call();
      } catch (const pcl::PCLException& error) {
        return error.detailedMessage();
      }
      return "none";
    };
    EXPECT_NE(refusal([&] { fusion.next(cloud); }).find("no frame is in flight"), std::string::npos);
    fusion.submit(scene.rig);
    fusion.submit(scene.rig);
    EXPECT_NE(refusal([&] { fusion.submit(scene.rig); }).find("2 frames are in flight; call next() first"),
              std::string::npos);
    EXPECT_NE(refusal([&] { fusion.setGatherAt(0); }).find("frames are in flight"), std::string::npos);
    EXPECT_NE(refusal([&] { fusion.forEachLane([](InFlight::Fusion&) {}); }).find("frames are in flight"),
              std::string::npos);
    fusion.next(cloud);
    EXPECT_TRUE(ranks::sameBytes(cloud, fuseAlone(scene.rig)));
    // What is still in flight ends with the object.
  });
}

}  // namespace
