#include "ranks.h"
#include "run_lengths.h"

#include <fuse_flow/sensors/multipath.h>

namespace {

using fuse_flow::FuseFlowParameters;
using fuse_flow::PointFused;
using fuse_flow::distributed::Communicator;
using fuse_flow::distributed::Ownership;
using fuse_flow::distributed::PartStatistics;
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
  for (std::size_t i = 0; i < cameras; ++i)
    rank_of.push_back(static_cast<int>(random() % static_cast<unsigned int>(ranks)));
  return rank_of;
}

/** \brief With these parameters, of one process. */
Cloud fuseAlone(const Scene& scene, const FuseFlowParameters& parameters) {
  fuse_flow::FuseFlow<PointFused> fusion;
  fusion.setParameters(parameters);
  Cloud cloud;
  fusion.fuse(scene.rig, cloud);
  return cloud;
}

void expectSame(const Scene& scene, const FuseFlowParameters& parameters, const std::string& what) {
  const Cloud one = fuseAlone(scene, parameters);
  ASSERT_GT(one.size(), 300u) << what;
  for (const int n : {2, 3})
    EXPECT_TRUE(sameBytes(ranks::fuse(scene.rig, inTurn(scene.rig.cameras.size(), n), n,
                                      [&](Ranks& fusion) { fusion.setParameters(parameters); }),
                          one))
        << what << ", " << n << " ranks";
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

TEST(DistributedFuseFlow, GivesTheSameBytesForEveryFormAndParameter) {
  const Scene scene = noisyRoom(6, 3);
  expectSame(scene, FuseFlowParameters::published(), "published");
  FuseFlowParameters p;
  p.smoothing.passes = 0;
  expectSame(scene, p, "without smoothing");
  p = {};
  p.consistency.max_views = 3;
  p.consistency.max_candidates = 2;
  expectSame(scene, p, "few candidates");
  p = {};
  p.consistency.silhouette_radius = fuse_flow::kMaxSilhouetteRadius;
  expectSame(scene, p, "wide silhouettes");
  p = {};
  p.use_distance_consistency = false;
  expectSame(scene, p, "without consistency");
  p = {};
  p.crop_box = Eigen::AlignedBox3f(Eigen::Vector3f(-0.6f, -1, 0.7f), Eigen::Vector3f(0.7f, 0.45f, 2));
  expectSame(scene, p, "cropped");
  p = {};
  p.aggregation.cell_size = 0.3f;
  expectSame(scene, p, "large cells");
  p = {};
  p.aggregation.cell_size = 0.02f;
  expectSame(scene, p, "small cells");
}

TEST(DistributedFuseFlow, GivesTheSameBytesWhereMeasurementsNeedViewsOfOthersThatAgree) {
  Scene scene = noisyRoom(6, 4);
  scene.confidence.resize(6);
  std::mt19937 random(4);
  for (std::size_t i = 0; i < 6; ++i) {
    scene.confidence[i].resize(scene.depth[i].width, scene.depth[i].height);
    for (float& c : scene.confidence[i].data) c = static_cast<float>(random() % 5) / 4.0f;
  }
  scene.attach();
  FuseFlowParameters p = FuseFlowParameters::estimatedDepth();
  p.agreement.min_views = 1;
  p.agreement.relative = 0.1f;
  p.agreement.pixels = 4;
  p.min_confidence = 0.2f;
  expectSame(scene, p, "estimated depth");
}

TEST(DistributedFuseFlow, GivesTheSameBytesWithDistortedLensesAndColorCamerasBeside) {
  Scene scene = noisyRoom(5, 5);
  for (std::size_t i = 0; i < 5; ++i) {
    fuse_flow::Camera& camera = scene.rig.cameras[i];
    if (i % 2 == 0) camera.intrinsics.distortion.k1 = -0.12f;
    if (i == 3) camera.intrinsics.distortion.p1 = 0.004f;
    fuse_flow::ColorCamera color;
    color.intrinsics = camera.intrinsics;
    color.intrinsics.width = 60;
    color.intrinsics.height = 50;
    color.intrinsics.cx = 30;
    color.T_depth_color.translation() = scenes::Vector3d(0.05, 0.01, 0);
    if (i == 1) continue;
    camera.color = color;
    scene.color[i].resize(60, 50);
    for (std::size_t k = 0; k < scene.color[i].data.size(); ++k)
      scene.color[i].data[k] = {static_cast<std::uint8_t>(k % 251), static_cast<std::uint8_t>(k % 13), 7};
  }
  scene.attach();
  expectSame(scene, {}, "lenses");
}

TEST(DistributedFuseFlow, GivesTheSameBytesOfFewerWhereMessagesAreCompressed) {
  Scene scene = noisyRoom(6, 6);
  scene.confidence.resize(6);
  for (std::size_t i = 0; i < 6; ++i) {
    scene.confidence[i].resize(scene.depth[i].width, scene.depth[i].height);
    for (std::size_t k = 0; k < scene.confidence[i].data.size(); ++k)
      scene.confidence[i].data[k] = 0.5f + static_cast<float>(k % 7) / 14;
  }
  scene.attach();
  FuseFlowParameters agree = FuseFlowParameters::estimatedDepth();
  agree.agreement.min_views = 1;
  agree.agreement.relative = 0.1f;
  agree.agreement.pixels = 4;
  std::mutex mutex;
  std::size_t sent = 0, plain = 0;
  for (const FuseFlowParameters& parameters : {FuseFlowParameters(), agree}) {
    Cloud gathered;
    ranks::forEachRank(3, [&](int rank, Communicator& communicator) {
      Ranks fusion(communicator);
      fusion.setParameters(parameters);
      const fuse_flow::RigFrame own = ranks::partOf(scene.rig, inTurn(6, 3), rank);
      Cloud part, whole;
      fusion.fuse(own, part);
      const std::size_t without = fusion.getPartStatistics().bytes_sent;
      EXPECT_EQ(fusion.getPartStatistics().bytes_plain, without);
      fusion.setCodec(std::make_shared<ranks::RunLengths>());
      fusion.fuse(own, part);
      EXPECT_EQ(fusion.getPartStatistics().bytes_plain, without);
      const std::size_t before = fusion.getPartStatistics().bytes_sent;
      fusion.gather(part, whole, 1);
      const PartStatistics& all = fusion.getPartStatistics();
      if (rank == 1) {
        EXPECT_EQ(all.bytes_sent, before);
      } else {
        EXPECT_GT(all.bytes_plain, without + part.size() * sizeof(PointFused));
        EXPECT_LT(all.bytes_sent - before, all.bytes_plain - without) << "the points are compressed, too";
      }
      const std::lock_guard<std::mutex> lock(mutex);
      sent += before;
      plain += without;
      if (rank == 1) gathered = whole;
    });
    ASSERT_GT(gathered.size(), 1000u);
    EXPECT_TRUE(sameBytes(gathered, scenes::fuse(scene.rig, parameters)));
  }
  EXPECT_LT(static_cast<double>(sent), 0.95 * static_cast<double>(plain));
}

TEST(DistributedFuseFlow, SharesFramesOfRigsThatChange) {
  // One object a rank for all frames: cameras go and come back, move, and change from rank to rank.
  std::vector<Scene> frames;
  for (unsigned int seed = 10; seed < 14; ++seed) frames.push_back(noisyRoom(seed == 12 ? 3 : 6, seed));
  frames[1].rig.views[2] = {};
  frames[3].rig.views[0] = frames[3].rig.views[5] = {};
  std::vector<Cloud> expected;
  for (const Scene& scene : frames) expected.push_back(scenes::fuse(scene.rig));
  ranks::forEachRank(3, [&](int rank, Communicator& communicator) {
    Ranks fusion(communicator);
    for (std::size_t f = 0; f < frames.size(); ++f) {
      const fuse_flow::RigFrame& rig = frames[f].rig;
      Cloud part, whole;
      fusion.fuse(ranks::partOf(rig, shuffled(rig.cameras.size(), 3, static_cast<unsigned int>(f)), rank), part);
      fusion.gather(part, whole, 1);
      if (rank == 1) {
        EXPECT_TRUE(sameBytes(whole, expected[f])) << "frame " << f;
      } else {
        EXPECT_TRUE(whole.empty());
      }
      const fuse_flow::FrameStatistics& statistics = fusion.getStatistics();
      EXPECT_EQ(statistics.missing_cameras.size(), f == 1 ? 1u : f == 3 ? 2u : 0u);
    }
  });
}

TEST(DistributedFuseFlow, TellsOfTheWholeFrame) {
  const Scene scene = noisyRoom(5, 6);
  fuse_flow::FuseFlow<PointFused> one;
  Cloud cloud;
  one.fuse(scene.rig, cloud);
  std::size_t fused = 0, cells = 0, points = 0, sent = 0, received = 0, at_first = 0, own_cells_of_first = 0;
  std::mutex mutex;
  ranks::forEachRank(4, [&](int rank, Communicator& communicator) {
    Ranks fusion(communicator);
    Cloud part, whole;
    fusion.fuse(ranks::partOf(scene.rig, inTurn(5, 4), rank), part);
    const std::size_t fusing = fusion.getPartStatistics().bytes_received;
    fusion.gather(part, whole, 0);
    const std::lock_guard<std::mutex> lock(mutex);
    EXPECT_EQ(fusion.getStatistics().measured_points, one.getStatistics().measured_points);
    EXPECT_EQ(fusion.getStatistics().gated_points, one.getStatistics().gated_points);
    EXPECT_EQ(fusion.getStatistics().noise_scales, one.getStatistics().noise_scales);
    EXPECT_EQ(fusion.getStatistics().fused_points, part.size());
    fused += part.size();
    cells += fusion.getStatistics().coarse_cells;
    const PartStatistics& own = fusion.getPartStatistics();
    EXPECT_EQ(own.views, rank == 0 ? 2u : 1u);
    EXPECT_LE(own.bytes_of_points, own.bytes_sent);
    points += own.points;
    sent += own.bytes_sent;
    received += own.bytes_received;
    if (rank == 0) own_cells_of_first = fusion.getStatistics().coarse_cells;
    if (rank == 0)
      at_first = own.bytes_received - fusing - (cloud.size() - part.size()) * sizeof(PointFused);
    else
      EXPECT_EQ(own.bytes_received, fusing);
    EXPECT_LT(own.imbalance, 1.25);
    EXPECT_GE(own.imbalance, 1.0);
  });
  EXPECT_EQ(fused, cloud.size());
  EXPECT_EQ(cells, one.getStatistics().coarse_cells);
  EXPECT_EQ(points, one.getStatistics().gated_points);
  EXPECT_EQ(sent, received) << "with what rank 0 gathered";
  EXPECT_EQ(at_first, 3 * 17 + (cells - own_cells_of_first) * sizeof(fuse_flow::distributed::GatheredCell));
}

TEST(DistributedFuseFlow, LeavesTheFusionToThoseThatFuse) {
  const Scene scene = noisyRoom(4, 7);
  const Cloud one = scenes::fuse(scene.rig);
  const Cloud gathered = ranks::fuse(scene.rig, {0, 1, 0, 1}, 3, {}, 2);
  EXPECT_TRUE(sameBytes(gathered, one)) << "a rank without cameras";
  ranks::forEachRank(3, [&](int rank, Communicator& communicator) {
    Ranks fusion(communicator);
    fusion.setFusing(rank == 2);
    Cloud part;
    fusion.fuse(ranks::partOf(scene.rig, {0, 1, 0, 1}, rank), part);
    if (rank == 2) {
      EXPECT_TRUE(sameBytes(part, one));
    } else {
      EXPECT_TRUE(part.empty());
      EXPECT_EQ(fusion.getPartStatistics().points, 0u);
    }
  });
}

/** \brief What rank 0 says where rank 1 does something else. */
std::string complaint(const std::function<void(int, Ranks&, fuse_flow::RigFrame&)>& change) {
  const Scene scene = noisyRoom(4, 8);
  std::string said;
  ranks::forEachRank(2, [&](int rank, Communicator& communicator) {
    Ranks fusion(communicator);
    fuse_flow::RigFrame part = ranks::partOf(scene.rig, inTurn(4, 2), rank);
    change(rank, fusion, part);
    Cloud cloud;
    try {
      fusion.fuse(part, cloud);
      ADD_FAILURE() << "rank " << rank << " said nothing";
    } catch (const pcl::PCLException& error) {
      if (rank == 0) said = error.what();
    }
    // The next frame is fused.
    fusion.setParameters({});
    fusion.setComputeNormals(false);
    fusion.setCodec(nullptr);
    fusion.fuse(ranks::partOf(scene.rig, inTurn(4, 2), rank), cloud);
    EXPECT_FALSE(cloud.empty());
  });
  return said;
}

TEST(DistributedFuseFlow, SaysWhichRankHasWhatElse) {
  EXPECT_NE(complaint([](int rank, Ranks&, fuse_flow::RigFrame& part) {
              if (rank == 1) part.cameras[2].T_world_camera.translation().x() += 1e-6;
            }).find("rank 1 has other cameras than rank 0"),
            std::string::npos);
  EXPECT_NE(complaint([](int rank, Ranks& fusion, fuse_flow::RigFrame&) {
              FuseFlowParameters p;
              if (rank == 1) p.max_noise = 0.05f;
              fusion.setParameters(p);
            }).find("rank 1 has other parameters than rank 0"),
            std::string::npos);
  EXPECT_NE(complaint([](int rank, Ranks& fusion, fuse_flow::RigFrame&) {
              FuseFlowParameters p;
              if (rank == 1) p.gate_noise = 0.01f;
              fusion.setParameters(p);
            }).find("rank 1 has other parameters than rank 0"),
            std::string::npos);
  EXPECT_NE(complaint([](int rank, Ranks& fusion, fuse_flow::RigFrame&) {
              if (rank == 1) fusion.setComputeNormals(true);
            }).find("rank 1 has other parameters"),
            std::string::npos);
  EXPECT_NE(complaint([](int rank, Ranks& fusion, fuse_flow::RigFrame&) {
              fusion.setCodec(rank == 1 ? std::make_shared<ranks::RunLengths>() : nullptr);
            }).find("rank 1 compresses messages otherwise than rank 0"),
            std::string::npos);
  EXPECT_NE(complaint([](int rank, Ranks&, fuse_flow::RigFrame& part) {
              if (rank == 1) part.views[0] = part.views[3];
            }).find("rank 1 has a view of camera 'camera 0', and so has rank 0"),
            std::string::npos);
  const std::string wrong_size = complaint([](int rank, Ranks&, fuse_flow::RigFrame& part) {
    if (rank == 1) --part.views[1].depth32.width;
  });
  EXPECT_NE(wrong_size.find("rank 1 cannot do its part of the frame: "), std::string::npos) << wrong_size;
  EXPECT_NE(wrong_size.find("camera 1"), std::string::npos) << wrong_size;
}

TEST(DistributedFuseFlow, SaysWhichRankCannotDoItsPartBeforeItSharesWhatItMeasured) {
  const std::string said = complaint([](int rank, Ranks& fusion, fuse_flow::RigFrame& part) {
    FuseFlowParameters p;
    p.agreement.min_views = 1;
    fusion.setParameters(p);
    if (rank == 1) --part.views[1].depth32.width;
  });
  EXPECT_NE(said.find("rank 1 cannot do its part of the frame: "), std::string::npos) << said;
}

// D^r is shared before the summaries that say which codec a rank has: all must see it, and end the same exchange.
TEST(DistributedFuseFlow, AnotherCodecIsSeenByAllBeforeTheySharedWhatTheyMeasured) {
  const Scene scene = noisyRoom(4, 7);
  FuseFlowParameters agree;
  agree.agreement.min_views = 1;
  for (const int n : {2, 3})
    for (const int odd : {0, n - 1}) {
      std::mutex mutex;
      int named = 0;
      ranks::forEachRank(n, [&](int rank, Communicator& communicator) {
        Ranks fusion(communicator);
        fusion.setParameters(agree);
        const fuse_flow::RigFrame part = ranks::partOf(scene.rig, inTurn(4, n), rank);
        Cloud cloud;
        for (const bool other_has_it : {true, false}) {
          fusion.setCodec((rank == odd) == other_has_it ? std::make_shared<ranks::RunLengths>() : nullptr);
          try {
            fusion.fuse(part, cloud);
            ADD_FAILURE() << "rank " << rank << " of " << n;
          } catch (const RankError& error) {
            const std::lock_guard<std::mutex> lock(mutex);
            named +=
                std::string(error.what()).find("compresses messages otherwise than rank " + std::to_string(rank)) !=
                        std::string::npos
                    ? 1
                    : 0;
          }
        }
        fusion.setCodec(std::make_shared<ranks::RunLengths>());
        fusion.fuse(part, cloud);
        EXPECT_FALSE(cloud.empty());
      });
      EXPECT_EQ(named, 2 * n);
    }
}

TEST(DistributedFuseFlow, NamesARankThatDoesNotAnswer) {
  const Scene scene = noisyRoom(2, 9);
  try {
    ranks::forEachRank(
        3,
        [&](int rank, Communicator& communicator) {
          if (rank == 2) return;  // gone
          Ranks fusion(communicator);
          Cloud cloud;
          fusion.fuse(ranks::partOf(scene.rig, {0, 1}, rank), cloud);
        },
        6);  // seconds: far more than the two take that answer
    FAIL() << "nobody noticed";
  } catch (const RankError& error) {
    EXPECT_EQ(error.rank(), 2);
  }
}

TEST(DistributedFuseFlow, RefusesWhatCannotBeSharedOut) {
  fuse_flow::distributed::ThreadRanks alone(1);
  Ranks fusion(alone.communicator(0));
  FuseFlowParameters p;
  p.use_spatial_hash = false;
  EXPECT_THROW(fusion.setParameters(p), pcl::BadArgumentException);
  fusion.setFusing(false);
  Cloud cloud;
  EXPECT_THROW(fusion.fuse(noisyRoom(2, 1).rig, cloud), pcl::PCLException);
}

}  // namespace
