#include "../ranks.h"

#include <fuse_flow/distributed/gpu/frames_in_flight.h>
#include <fuse_flow/distributed/gpu/fuse_flow.h>
#include <fuse_flow/gpu/fuse_flow.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <memory>
#include <thread>

namespace {

using fuse_flow::FuseFlowParameters;
using fuse_flow::PointFused;
using fuse_flow::RigFrame;
using fuse_flow::distributed::Communicator;
using fuse_flow::distributed::Ownership;
using fuse_flow::distributed::PartStatistics;
using fuse_flow::distributed::RankError;
using ranks::inTurn;
using ranks::noisyRoom;
using scenes::Cloud;
using scenes::Scene;
using Gpu = fuse_flow::FuseFlow<PointFused, fuse_flow::device::Thrust>;
using Ranks = fuse_flow::distributed::FuseFlow<PointFused, fuse_flow::device::Thrust>;
using Setup = std::function<void(Ranks&)>;

using PointBytes = std::array<char, sizeof(PointFused)>;

/** \brief The points in an order that follows from their bytes alone. */
std::vector<PointBytes> bytesOf(const Cloud& cloud) {
  std::vector<PointBytes> bytes(cloud.size());
  for (std::size_t k = 0; k < cloud.size(); ++k)
    std::memcpy(bytes[k].data(), static_cast<const void*>(&cloud[k]), sizeof(PointBytes));
  std::sort(bytes.begin(), bytes.end());
  return bytes;
}

Cloud fuseOnOne(const RigFrame& frame, const FuseFlowParameters& parameters = {}) {
  Gpu fusion;
  fusion.setParameters(parameters);
  Cloud cloud;
  fusion.fuse(frame, cloud);
  return cloud;
}

/** \brief The clouds of all ranks, one after the other. \param statistics if not null, receives those of each rank */
Cloud fuseOnRanks(const std::vector<RigFrame>& frames, const std::vector<int>& rank_of, int ranks,
                  const Setup& setup = {}, std::vector<PartStatistics>* statistics = nullptr) {
  std::vector<Cloud> parts(static_cast<std::size_t>(ranks));
  std::vector<PartStatistics> of_ranks(parts.size());
  ranks::forEachRank(ranks, [&](int rank, Communicator& communicator) {
    Ranks fusion(communicator);
    fusion.setNumberOfThreads(2);
    if (setup) setup(fusion);
    for (const RigFrame& frame : frames)
      fusion.fuse(ranks::partOf(frame, rank_of, rank), parts[static_cast<std::size_t>(rank)]);
    of_ranks[static_cast<std::size_t>(rank)] = fusion.getPartStatistics();
  });
  if (statistics) *statistics = of_ranks;
  Cloud all;
  for (const Cloud& part : parts) all += part;
  return all;
}

std::vector<int> shuffled(std::size_t cameras, int ranks, unsigned int seed) {
  std::mt19937 random(seed);
  std::vector<int> rank_of;
  for (std::size_t i = 0; i < cameras; ++i)
    rank_of.push_back(static_cast<int>(random() % static_cast<unsigned int>(ranks)));
  return rank_of;
}

void expectSamePoints(const Cloud& ranks, const Cloud& one, const std::string& what) {
  EXPECT_EQ(ranks.size(), one.size()) << what;
  EXPECT_TRUE(bytesOf(ranks) == bytesOf(one)) << what;
}

TEST(DistributedGpu, GivesThePointsOfOneGpuForAnyNumberOfRanksAndAnyAssignment) {
  const Scene scene = noisyRoom(7, 1);
  const Cloud one = fuseOnOne(scene.rig);
  ASSERT_GT(one.size(), 3000u);
  for (const int n : {1, 2, 3, 5, 9}) {
    expectSamePoints(fuseOnRanks({scene.rig}, inTurn(7, n), n), one, std::to_string(n) + " ranks");
    expectSamePoints(fuseOnRanks({scene.rig}, shuffled(7, n, 5u), n), one, std::to_string(n) + " ranks, shuffled");
  }
}

TEST(DistributedGpu, GivesThePointsOfOneGpuByTheCurveAndByTheHash) {
  const Scene scene = noisyRoom(5, 2);
  const Cloud one = fuseOnOne(scene.rig);
  for (const Ownership ownership : {Ownership::Curve, Ownership::Hash})
    expectSamePoints(fuseOnRanks({scene.rig}, inTurn(5, 3), 3, [&](Ranks& fusion) { fusion.setOwnership(ownership); }),
                     one, ownership == Ownership::Curve ? "curve" : "hash");
}

TEST(DistributedGpu, KeepsNothingFromFrameToFrame) {
  std::vector<Scene> scenes;
  for (const unsigned int seed : {3u, 4u, 5u}) scenes.push_back(noisyRoom(6, seed));
  scenes[1].rig.views[2] = {};  // missing in one frame
  scenes[2].rig.views[0] = {};
  std::vector<RigFrame> frames;
  for (const Scene& scene : scenes) {
    frames.push_back(scene.rig);
    expectSamePoints(fuseOnRanks(frames, inTurn(6, 2), 2), fuseOnOne(frames.back()),
                     std::to_string(frames.size()) + " frames");
  }
}

TEST(DistributedGpu, GivesThePointsOfOneGpuForOtherParameters) {
  Scene scene = noisyRoom(7, 6);
  scene.rig.views[2] = {};  // a missing camera is no candidate
  std::vector<FuseFlowParameters> variants(10);
  variants[0].crop_box = Eigen::AlignedBox3f(Eigen::Vector3f(-0.5f, -0.4f, 0.8f), Eigen::Vector3f(0.6f, 0.4f, 2.0f));
  variants[1].smoothing.passes = 0;
  variants[2].preprocessing.fill_neighbours = 5;
  variants[3].use_distance_consistency = false;
  variants[4].use_measurement_confidence = false;
  variants[5].adapt_noise = false;
  variants[6].aggregation.consistency_at = fuse_flow::ConsistencyAt::Representatives;
  variants[7].consistency.max_views = 3;
  variants[7].consistency.max_candidates = 3;
  variants[8].min_support = 0;
  variants[9].preprocessing.bilateral = true;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const Cloud one = fuseOnOne(scene.rig, variants[v]);
    ASSERT_GT(one.size(), 300u) << v;
    expectSamePoints(
        fuseOnRanks({scene.rig}, inTurn(7, 3), 3, [&](Ranks& fusion) { fusion.setParameters(variants[v]); }), one,
        "variant " + std::to_string(v));
  }
}

TEST(DistributedGpu, AsksTheNearestViewThatIsThereAndNoMore) {
  FuseFlowParameters parameters;
  parameters.consistency.max_views = 2;
  parameters.consistency.max_candidates = 1;
  for (std::size_t missing = 0; missing < 7; ++missing) {
    Scene scene = noisyRoom(7, 20 + static_cast<unsigned int>(missing));
    scene.rig.views[missing] = {};
    scene.rig.views[(missing + 2) % 7] = {};
    expectSamePoints(
        fuseOnRanks({scene.rig}, inTurn(7, 7), 7, [&](Ranks& fusion) { fusion.setParameters(parameters); }),
        fuseOnOne(scene.rig, parameters), "without camera " + std::to_string(missing));
  }
}

TEST(DistributedGpu, GivesThePointsOfOneGpuWithLensDistortionAndWithoutColor) {
  Scene scene = noisyRoom(6, 7);
  for (std::size_t i = 0; i < 6; i += 2) {
    scene.rig.cameras[i].intrinsics.distortion.k1 = -0.12f + 0.02f * static_cast<float>(i);
    scene.rig.cameras[i].intrinsics.distortion.p1 = 0.003f;
  }
  scene.rig.views[3].color = {};
  expectSamePoints(fuseOnRanks({scene.rig}, inTurn(6, 2), 2), fuseOnOne(scene.rig), "one view without colour");
  for (fuse_flow::DepthView& view : scene.rig.views) view.color = {};
  expectSamePoints(fuseOnRanks({scene.rig}, inTurn(6, 3), 3), fuseOnOne(scene.rig), "no colour");
}

TEST(DistributedGpu, WeighsContradictionsByTheConfidenceOfViewsOfOthers) {
  Scene scene = noisyRoom(6, 8);
  std::mt19937 random(8);
  std::vector<std::vector<float>> confidence(5);
  for (std::size_t i = 0; i < confidence.size(); ++i) {  // one view has none
    const int width = scene.depth[i].width, height = scene.depth[i].height;
    for (int k = 0; k < width * height; ++k) confidence[i].push_back(static_cast<float>(random() % 1000) / 1000);
    scene.rig.views[i].confidence = {confidence[i].data(), width, height};
  }
  FuseFlowParameters parameters;
  parameters.consistency.weigh_contradictions = true;
  expectSamePoints(fuseOnRanks({scene.rig}, inTurn(6, 3), 3, [&](Ranks& fusion) { fusion.setParameters(parameters); }),
                   fuseOnOne(scene.rig, parameters), "weighed");
}

TEST(DistributedGpu, LetsARankThatDoesNotFuseGiveItsViews) {
  const Scene scene = noisyRoom(5, 9);
  std::vector<PartStatistics> statistics;
  ranks::forEachRank(2, [&](int rank, Communicator& communicator) {
    Ranks fusion(communicator);
    fusion.setFusing(rank == 1);
    Cloud part;
    fusion.fuse(ranks::partOf(scene.rig, {0, 0, 0, 0, 0}, rank), part);
    if (rank == 0) {
      EXPECT_TRUE(part.empty());
      EXPECT_GT(fusion.getPartStatistics().bytes_sent, 0u);
      EXPECT_EQ(fusion.getPartStatistics().bytes_plain, fusion.getPartStatistics().bytes_sent);
    } else {
      expectSamePoints(part, fuseOnOne(scene.rig), "all at the other");
      EXPECT_EQ(part.header.stamp, scene.rig.stamp);
      EXPECT_EQ(fusion.getPartStatistics().foreign_points, fusion.getPartStatistics().points);
    }
  });
}

TEST(DistributedGpu, FusesAtOneRankWhatOneGpuCountsInAll) {
  const Scene scene = noisyRoom(6, 10);
  Gpu one;
  Cloud cloud;
  one.fuse(scene.rig, cloud);
  std::vector<PartStatistics> statistics;
  fuseOnRanks({scene.rig}, inTurn(6, 4), 4, {}, &statistics);
  std::size_t points = 0, cells = 0, sent = 0, received = 0;
  for (const PartStatistics& part : statistics) {
    points += part.points;
    cells += part.cells;
    sent += part.bytes_sent;
    received += part.bytes_received;
  }
  EXPECT_EQ(points, one.getStatistics().gated_points);
  EXPECT_EQ(cells, one.getStatistics().coarse_cells);
  EXPECT_EQ(sent, received);
}

using InFlight = fuse_flow::distributed::FramesInFlight<PointFused, fuse_flow::device::Thrust>;
using Lanes = std::vector<Communicator*>;

/** \brief Frames of which some have few views, or none: these exchange nothing. */
std::vector<Scene> differentScenes() {
  std::vector<Scene> scenes;
  for (unsigned int seed = 1; seed <= 7; ++seed) scenes.push_back(noisyRoom(5, seed));
  for (std::size_t i = 0; i < 5; ++i) scenes[4].rig.views[i] = {};
  for (std::size_t i = 1; i < 5; ++i) scenes[2].rig.views[i] = {};
  return scenes;
}

/** \brief What all ranks together give of each frame. \param make an object of a rank  \param take its oldest frame */
void expectFramesInFlight(
    const std::vector<Scene>& scenes, int ranks, std::size_t lanes,
    const std::function<void(const Lanes&, Communicator&, const std::function<void(InFlight&)>&)>& make,
    const std::function<void(InFlight&, Cloud&)>& take) {
  std::vector<std::vector<Cloud>> parts(scenes.size(), std::vector<Cloud>(static_cast<std::size_t>(ranks)));
  // One communicator more than lanes, for what the exchange may need.
  ranks::forEachRankWithLanes(ranks, lanes + 1, [&](int rank, const Lanes& all) {
    const Lanes own(all.begin(), all.end() - 1);
    make(own, *all.back(), [&](InFlight& fusion) {
      fusion.forEachLane([](Ranks& lane) { lane.setNumberOfThreads(1); });
      std::size_t taken = 0;
      const auto next = [&] { take(fusion, parts[taken++][static_cast<std::size_t>(rank)]); };
      for (const Scene& scene : scenes) {
        if (fusion.inFlight() == lanes) next();
        fusion.submit(ranks::partOf(scene.rig, inTurn(5, ranks), rank));
      }
      while (fusion.inFlight() > 0) next();
    });
  });
  for (std::size_t frame = 0; frame < scenes.size(); ++frame) {
    Cloud all;
    for (const Cloud& part : parts[frame]) all += part;
    expectSamePoints(all, fuseOnOne(scenes[frame].rig), "frame " + std::to_string(frame));
  }
}

TEST(DistributedGpu, HasSeveralFramesInFlight) {
  const std::vector<Scene> scenes = differentScenes();
  for (const auto& [ranks, lanes] : {std::pair<int, std::size_t>{1, 2}, {2, 3}, {3, 2}})
    expectFramesInFlight(
        scenes, ranks, lanes,
        [](const Lanes& own, Communicator&, const auto& use) {
          InFlight fusion(own);
          use(fusion);
        },
        [](InFlight& fusion, Cloud& cloud) {
          fusion.next(cloud);
          EXPECT_EQ(fusion.getStatistics().fused_points, cloud.size());
        });
}

TEST(DistributedGpu, LetsFramesInFlightTakeTurnsInOneExchange) {
  expectFramesInFlight(
      differentScenes(), 2, 3,
      [](const Lanes& own, Communicator& more, const auto& use) {
        fuse_flow::distributed::StagedExchange exchange(more);
        InFlight fusion(own, exchange);
        fusion.setCopyAhead(false);
        Cloud cloud;
        EXPECT_THROW(fusion.next(cloud), pcl::PCLException) << "without setCopyAhead()";
        use(fusion);
      },
      [](InFlight& fusion, Cloud& cloud) {
        fusion.nextPinned([&](const fuse_flow::gpu::PointSpan<PointFused>& points) {
          cloud.points.assign(points.points, points.points + points.size);
        });
      });
}

TEST(DistributedGpu, LosesAFrameInFlightThatARankCannotFuseAndNoOther) {
  const std::vector<Scene> scenes = differentScenes();
  std::vector<std::vector<Cloud>> parts(4, std::vector<Cloud>(2));
  ranks::forEachRankWithLanes(2, 4, [&](int rank, const Lanes& all) {
    fuse_flow::distributed::StagedExchange exchange(*all.back());
    InFlight fusion(Lanes(all.begin(), all.end() - 1), exchange);
    fusion.forEachLane([](Ranks& lane) { lane.setNumberOfThreads(1); });
    std::size_t taken = 0;
    const auto next = [&] {
      Cloud& cloud = parts[taken][static_cast<std::size_t>(rank)];
      if (taken++ == 1) {
        EXPECT_THROW(fusion.next(cloud), pcl::PCLException);
        EXPECT_EQ(fusion.getStatistics().fused_points, 0u);
      } else {
        fusion.next(cloud);
      }
    };
    std::vector<RigFrame> frames;
    for (std::size_t k = 0; k < 4; ++k) frames.push_back(ranks::partOf(scenes[k].rig, inTurn(5, 2), rank));
    if (rank == 1) --frames[1].views[1].depth32.width;
    for (const RigFrame& frame : frames) {
      if (fusion.inFlight() == 3) next();
      fusion.submit(frame);
    }
    while (fusion.inFlight() > 0) next();
  });
  for (const std::size_t k : {0u, 2u, 3u})
    expectSamePoints(parts[k][0] + parts[k][1], fuseOnOne(scenes[k].rig), "frame " + std::to_string(k));
}

TEST(DistributedGpu, EndsWithItsFramesWhateverIsInFlight) {
  const Scene scene = noisyRoom(3, 1);
  for (int k = 0; k < 20; ++k)
    ranks::forEachRankWithLanes(2, 4, [&](int rank, const Lanes& all) {
      fuse_flow::distributed::StagedExchange exchange(*all.back());
      InFlight fusion(Lanes(all.begin(), all.end() - 1), exchange);
      const RigFrame part = ranks::partOf(scene.rig, inTurn(3, 2), rank);
      for (int frame = 0; frame < 3; ++frame) fusion.submit(part);
    });
}

// Exchanges in another order than that of the frames would let two ranks wait for each other: the first frames of the ranks take unequally long.
TEST(DistributedGpu, ExchangesInTheOrderOfTheFramesWhateverIsReadyFirst) {
  struct Recorder : fuse_flow::distributed::DeviceExchange {
    std::vector<int> order;
    int next{-1};
    void exchange(fuse_flow::gpu::Execution&, const std::vector<fuse_flow::distributed::DeviceMessage>& sends,
                  const std::vector<fuse_flow::distributed::DeviceMessage>&) override {
      order.push_back(sends[0].rank);
    }
  } recorder;
  fuse_flow::distributed::ExchangeTurns turns(recorder);
  std::vector<std::unique_ptr<fuse_flow::distributed::ExchangeTurns::Lane>> lanes;
  for (int k = 0; k < 4; ++k) lanes.push_back(std::make_unique<fuse_flow::distributed::ExchangeTurns::Lane>(turns));
  std::vector<std::thread> threads;
  for (int k = 3; k >= 0; --k) {  // the last comes first
    lanes[static_cast<std::size_t>(k)]->enter(static_cast<std::uint64_t>(k));
    threads.emplace_back([&, k] {
      fuse_flow::distributed::ExchangeTurns::Lane& lane = *lanes[static_cast<std::size_t>(k)];
      fuse_flow::gpu::Execution run;
      if (k != 1) lane.exchange(run, {{k, nullptr, 0}}, {});  // frame 1 has nothing to exchange
      lane.leave();
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(recorder.order, (std::vector<int>{0, 2, 3}));
}

TEST(DistributedGpu, PassesTheTurnOfAnExchangeThatFails) {
  struct FailsOnce : fuse_flow::distributed::DeviceExchange {
    int calls{0};
    void exchange(fuse_flow::gpu::Execution&, const std::vector<fuse_flow::distributed::DeviceMessage>&,
                  const std::vector<fuse_flow::distributed::DeviceMessage>&) override {
      if (++calls == 1) throw pcl::PCLException("no exchange");
    }
  } inner;
  fuse_flow::distributed::ExchangeTurns turns(inner);
  fuse_flow::distributed::ExchangeTurns::Lane first(turns), second(turns);
  fuse_flow::gpu::Execution run;
  first.enter(0);
  second.enter(1);
  EXPECT_THROW(first.exchange(run, {}, {}), pcl::PCLException);
  EXPECT_THROW(first.exchange(run, {}, {}), pcl::PCLException) << "a second time";
  first.leave();
  second.exchange(run, {}, {});  // would wait for ever
  second.leave();
  first.enter(2);
  first.exchange(run, {}, {});
  EXPECT_EQ(inner.calls, 3);
}

TEST(DistributedGpu, SaysWhatItDoesNotDoAndWhatWouldBeRight) {
  fuse_flow::distributed::ThreadRanks group(1);
  Ranks fusion(group.communicator(0));
  FuseFlowParameters parameters;
  parameters.use_spatial_hash = false;
  EXPECT_THROW(fusion.setParameters(parameters), pcl::BadArgumentException);
  parameters = {};
  parameters.agreement.min_views = 1;
  EXPECT_THROW(fusion.setParameters(parameters), pcl::BadArgumentException);
  Scene scene = noisyRoom(2, 11);
  scene.rig.cameras[1].color.emplace();
  scene.rig.cameras[1].color->intrinsics = scene.rig.cameras[1].intrinsics;
  Cloud cloud;
  EXPECT_THROW(fusion.fuse(scene.rig, cloud), pcl::PCLException);
  scene.rig.cameras[1].color.reset();
  fusion.fuse(scene.rig, cloud);
  expectSamePoints(cloud, fuseOnOne(scene.rig), "after a refusal");
}

TEST(DistributedGpu, SaysWhichRankHasTheSameCameraOrOtherSettings) {
  const Scene scene = noisyRoom(4, 12);
  const auto fuse = [&](int rank, Communicator& communicator, bool normals, bool all_views) {
    Ranks fusion(communicator);
    fusion.setComputeNormals(normals);
    Cloud part;
    fusion.fuse(all_views ? scene.rig : ranks::partOf(scene.rig, inTurn(4, 2), rank), part);
  };
  const auto expectError = [&](bool normals, bool all_views) {
    ranks::forEachRank(2, [&](int rank, Communicator& communicator) {
      EXPECT_THROW(fuse(rank, communicator, normals && rank == 1, all_views), RankError);
    });
  };
  expectError(true, false);
  expectError(false, true);
}

}  // namespace
