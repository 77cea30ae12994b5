#include "ranks.h"

#include <fuse_flow/distributed/calibration/extrinsic_tracking.h>

namespace {

using fuse_flow::Camera;
using fuse_flow::ExtrinsicParameters;
using fuse_flow::ExtrinsicResult;
using fuse_flow::PointFused;
using fuse_flow::RigFrame;
using fuse_flow::TrackedPoses;
using fuse_flow::distributed::Communicator;
using fuse_flow::distributed::ExtrinsicEstimation;
using fuse_flow::distributed::ExtrinsicTracking;
using fuse_flow::distributed::Message;
using fuse_flow::distributed::MessageReader;
using fuse_flow::distributed::MessageWriter;
using fuse_flow::distributed::PoseMessages;
using fuse_flow::distributed::RankError;
using ranks::forEachRank;
using ranks::inTurn;
using ranks::partOf;
using scenes::Scene;
using Poses = std::vector<Eigen::Isometry3d>;
using Alone = fuse_flow::ExtrinsicEstimation<PointFused>;

/** \brief Five cameras, textured surfaces, noise, one view missing; poses some centimetres off. */
struct Rig {
  explicit Rig(bool with_color = true, std::size_t missing = 99) {
    cameras = scenes::cornerCameras(5);
    scene = scenes::makeScene(cameras, scenes::cornerAndBall());
    std::mt19937 random(7);
    std::normal_distribution<float> noise(0, 0.002f);
    for (auto& image : scene.depth)
      for (float& z : image.data)
        if (z > 0) z += noise(random);
    if (with_color)
      scenes::paintWorld(scene, [](const scenes::Vector3d& x) {
        return 128 + 50 * std::sin(19 * x.x() + 4 * x.y()) + 40 * std::sin(23 * x.z() - 9 * x.y());
      });
    scene.attach();
    scene.rig.stamp = 1000000;
    if (missing < 5) scene.rig.views[missing] = {};
    initial = scenes::poses(cameras);
    initial[1] = scenes::moved(initial[1], {0.012, -0.011, 0.012}, 1.0, {1, 2, -1});
    initial[2] = scenes::moved(initial[2], {-0.01, 0.014, -0.009}, -0.8, {2, 1, 1});
    initial[4] = scenes::moved(initial[4], {0.006, 0.004, -0.007}, 0.5, {0, 1, 1});
  }
  std::vector<Camera> cameras;
  Scene scene;
  Poses initial;
};

ExtrinsicResult alone(const std::vector<RigFrame>& frames, const Poses& initial,
                      const ExtrinsicParameters& parameters) {
  Alone estimation;
  estimation.setParameters(parameters);
  estimation.setNumberOfThreads(2);
  for (const RigFrame& frame : frames) estimation.addFrame(frame);
  return estimation.estimate(initial);
}

std::vector<char> bytesOf(const ExtrinsicResult& result) {
  Message message;
  MessageWriter writer(message);
  PoseMessages::put(writer, result);
  return {message.begin(), message.end()};
}

/** \brief That every rank finds what one process finds. */
void expectSame(const std::vector<RigFrame>& frames, const Poses& initial, const ExtrinsicParameters& parameters,
                const std::vector<int>& rank_of, int n) {
  const std::vector<char> one = bytesOf(alone(frames, initial, parameters));
  std::vector<std::vector<char>> found(static_cast<std::size_t>(n));
  forEachRank(n, [&](int rank, Communicator& communicator) {
    ExtrinsicEstimation estimation(communicator);
    estimation.setParameters(parameters);
    estimation.setNumberOfThreads(rank % 2 == 0 ? 2 : 1);
    for (const RigFrame& frame : frames) estimation.addFrame(partOf(frame, rank_of, rank));
    // Those of rank 0 count.
    found[static_cast<std::size_t>(rank)] =
        bytesOf(estimation.estimate(rank == 0 ? initial : scenes::poses(frames[0].cameras)));
  });
  for (int rank = 0; rank < n; ++rank) EXPECT_EQ(found[static_cast<std::size_t>(rank)], one) << rank << " of " << n;
}

TEST(DistributedExtrinsics, FindsTheBytesOfOneProcessForAnyNumberOfRanksAndAnyAssignment) {
  const Rig rig;
  const ExtrinsicResult one = alone({rig.scene.rig}, rig.initial, {});
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_LT(scenes::apart(one.T_world_camera[i], rig.cameras[i].T_world_camera), 0.002) << "or it shows nothing";
  for (const int n : {1, 2, 3, 6}) expectSame({rig.scene.rig}, rig.initial, {}, inTurn(5, n), n);
  expectSame({rig.scene.rig}, rig.initial, {}, {1, 1, 0, 1, 0}, 2);
  expectSame({rig.scene.rig}, rig.initial, {}, {1, 1, 2, 1, 2}, 3);  // rank 0 has no camera
}

TEST(DistributedExtrinsics, FindsTheSameOfSeveralInstantsOneOfThemWithoutAView) {
  const Rig rig(true, 3);
  const Rig whole(false);
  expectSame({rig.scene.rig, whole.scene.rig}, rig.initial, {}, inTurn(5, 2), 2);
  ExtrinsicParameters p;
  p.gauge = fuse_flow::Gauge::Mean;
  p.max_neighbours = 2;
  p.use_color = false;
  p.max_iterations = 7;
  expectSame({whole.scene.rig, rig.scene.rig, whole.scene.rig}, rig.initial, p, inTurn(5, 3), 3);
}

TEST(DistributedExtrinsics, DirectionsThatNoViewTellsAreTheSame) {
  // All see one wall, and nothing else.
  std::vector<Camera> cameras = scenes::cornerCameras(3);
  const Scene scene = scenes::makeScene(cameras, scenes::plane({0, 0, -1}, -2));
  Poses initial = scenes::poses(cameras);
  initial[1] = scenes::moved(initial[1], {0.01, 0.01, 0.01});
  EXPECT_FALSE(alone({scene.rig}, initial, {}).corrections[1].free_directions.empty());
  expectSame({scene.rig}, initial, {}, inTurn(3, 2), 2);
}

TEST(DistributedExtrinsics, FollowsABumpedCameraAsOneProcessDoes) {
  const std::vector<Camera> cameras = scenes::cornerCameras(4);
  const Scene scene = scenes::makeScene(cameras, scenes::cornerAndBall());
  Camera bumped = cameras[2];
  bumped.T_world_camera = scenes::moved(bumped.T_world_camera, {0.03, 0.0, -0.04}, 1.0);
  Scene after = scenes::makeScene(cameras, scenes::cornerAndBall());
  after.depth[2] = scenes::render(bumped, scenes::cornerAndBall());
  after.attach();
  std::vector<RigFrame> frames;
  for (std::uint64_t k = 0; k < 9; ++k) {
    frames.push_back(k < 3 ? scene.rig : after.rig);
    frames.back().stamp = 33333 * (k + 1) - (k == 5 ? 10000 : 0);
  }
  fuse_flow::ExtrinsicTracking<PointFused> tracking(cameras, 0.002);
  std::vector<TrackedPoses> expected;
  std::vector<bool> accepted;
  for (const RigFrame& frame : frames) {
    accepted.push_back(tracking.push(frame));
    tracking.finish();
    expected.push_back(*tracking.poses());
  }
  EXPECT_EQ(std::count(accepted.begin(), accepted.end(), false), 1) << "one comes too soon after the one before";
  forEachRank(3, [&](int rank, Communicator& communicator) {
    ExtrinsicTracking shared(communicator, cameras, 0.002);
    std::size_t told = 0;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      EXPECT_EQ(shared.push(partOf(frames[k], inTurn(4, 3), rank)), accepted[k]) << k;
      EXPECT_EQ(shared.poses().updates, expected[k].updates);
      EXPECT_EQ(shared.poses().stamp, expected[k].stamp);
      ASSERT_EQ(shared.poses().moved.size(), expected[k].moved.size()) << k;
      if (accepted[k]) told += shared.poses().moved.size();
      RigFrame placed = frames[k];
      shared.apply(placed);
      for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ(placed.cameras[i].T_world_camera.matrix(), expected[k].T_world_camera[i].matrix()) << k << " " << i;
    }
    EXPECT_EQ(told, 1u);
  });
}

TEST(DistributedExtrinsics, ARankThatCannotTakePartEndsTheSearchAtAll) {
  const Rig rig;
  using Fault = std::function<void(RigFrame&, ExtrinsicEstimation&)>;
  for (const auto& [what, said, fault] :
       std::vector<std::tuple<std::string, std::string, Fault>>{{"a frame that contradicts itself",
                                                                 "cannot search for poses",
                                                                 [](RigFrame&frame, ExtrinsicEstimation&) {
                                                                   frame.views.pop_back();
                                                                 }},
                                                                {"another calibration",
                                                                 "other cameras or other parameters",
                                                                 [](RigFrame&frame, ExtrinsicEstimation&) {
                                                                   frame.cameras[0].intrinsics.fx *= 1.01f;
                                                                 }},
                                                                {"other parameters",
                                                                 "other cameras or other parameters",
                                                                 [](RigFrame&, ExtrinsicEstimation&estimation) {
                                                                   ExtrinsicParameters p;
                                                                   p.samples = 500;
                                                                   estimation.setParameters(p);
                                                                 }},
                                                                {"another's view", "and so has rank",
                                                                 [&](RigFrame&frame, ExtrinsicEstimation&) {
                                                                   frame.views[0] = rig.scene.rig.views[0];
                                                                 }},
                                                                {"more frames", "frames",
                                                                 [&](RigFrame&frame, ExtrinsicEstimation&e) {
                                                                   e.addFrame(frame);
                                                                 }}}) {
    std::vector<std::string> messages(3);
    forEachRank(3, [&, &fault = fault](int rank, Communicator& communicator) {
      ExtrinsicEstimation estimation(communicator);
      RigFrame frame = partOf(rig.scene.rig, inTurn(5, 3), rank);
      if (rank == 1) fault(frame, estimation);
      estimation.addFrame(frame);
      try {
        (void)estimation.estimate(rig.initial);
      } catch (const pcl::PCLException& error) {
        messages[static_cast<std::size_t>(rank)] = error.what();
      }
      // And then they go on.
      estimation.clear();
      estimation.setParameters({});
      estimation.addFrame(partOf(rig.scene.rig, inTurn(5, 3), rank));
      EXPECT_EQ(estimation.estimate(rig.initial).T_world_camera.size(), 5u);
    });
    for (const int rank : {0, 2}) {
      EXPECT_NE(messages[static_cast<std::size_t>(rank)].find("rank 1"), std::string::npos) << what;
      EXPECT_NE(messages[static_cast<std::size_t>(rank)].find(said), std::string::npos)
          << what << ": " << messages[static_cast<std::size_t>(rank)];
    }
    EXPECT_FALSE(messages[1].empty()) << what;
  }
  forEachRank(2, [&](int, Communicator& communicator) {
    ExtrinsicEstimation estimation(communicator);
    EXPECT_THROW(estimation.estimate(), pcl::PCLException) << "without a frame";
  });
}

/** \brief Cuts the last byte off what a rank sends in its n-th exchange that sends something. */
class Cutting : public Communicator {
 public:
  Cutting(Communicator& rank, int n) : rank_(rank), left_(n) {}
  int rank() const override { return rank_.rank(); }
  int size() const override { return rank_.size(); }
  void exchange(const std::vector<Outgoing>& out, const std::vector<int>& from, std::vector<Message>& in) override {
    std::vector<Outgoing> sent = out;
    if (!out.empty() && left_-- == 0)
      for (Outgoing& message : sent) --message.size;
    rank_.exchange(sent, from, in);
  }

 private:
  Communicator& rank_;
  int left_;
};

// All ranks end the search in the same exchange, or the next one would find messages of this one.
TEST(DistributedExtrinsics, WhatIsWrongInTheMiddleOfASearchEndsItAtAllRanks) {
  const Rig rig;
  const std::vector<int> rank_of = inTurn(5, 3);
  const std::vector<char> one = bytesOf(alone({rig.scene.rig}, rig.initial, {}));
  for (const int culprit : {0, 1, 2})
    for (const int n : {1, 2, 3, 5}) {  // 0 is what they tell each other before the search
      std::vector<std::string> messages(3);
      forEachRank(3, [&](int rank, Communicator& communicator) {
        const RigFrame frame = partOf(rig.scene.rig, rank_of, rank);
        Cutting cutting(communicator, rank == culprit ? n : -1);
        ExtrinsicEstimation estimation(cutting);
        estimation.addFrame(frame);
        try {
          (void)estimation.estimate(rig.initial);
        } catch (const pcl::PCLException& error) {
          messages[static_cast<std::size_t>(rank)] = error.what();
        }
        EXPECT_EQ(bytesOf(estimation.estimate(rig.initial)), one) << culprit << " " << n;
      });
      for (const std::string& message : messages) {
        EXPECT_FALSE(message.empty()) << culprit << " " << n;
        EXPECT_EQ(message.find("has not answered"), std::string::npos) << message;
      }
    }
}

TEST(DistributedExtrinsics, TheWorldsOriginMayBeFarAway) {
  Rig rig;
  const Eigen::Vector3d away(4.5e6, 5.4e6, 300);  // as of a map
  for (Camera& camera : rig.scene.rig.cameras) camera.T_world_camera.pretranslate(away);
  for (Eigen::Isometry3d& T : rig.initial) T.pretranslate(away);
  expectSame({rig.scene.rig}, rig.initial, {}, inTurn(5, 2), 2);
}

TEST(DistributedExtrinsics, ACameraThatOneRankAloneHasGivesTheSameAsOneProcess) {
  std::vector<Camera> cameras = scenes::cornerCameras(1);
  const Scene scene = scenes::makeScene(cameras, scenes::cornerAndBall());
  expectSame({scene.rig}, scenes::poses(cameras), {}, {1}, 2);
  forEachRank(2, [&](int rank, Communicator& communicator) {
    ExtrinsicTracking tracking(communicator, cameras);
    EXPECT_FALSE(tracking.push(partOf(scene.rig, {1}, rank))) << "nobody to agree with";
  });
}

// What a rank sends may be anything. Where bytes are missing RankError comes of it, and where they are wrong nothing but that.
TEST(DistributedExtrinsics, DamagedMessagesAreRefused) {
  const Rig rig;
  const ExtrinsicResult result = alone({rig.scene.rig}, rig.initial, {});
  Message message;
  MessageWriter writer(message);
  PoseMessages::put(writer, result);
  for (std::size_t size = 0; size < message.size(); size += 7) {
    Message cut = message;
    cut.resize(size);
    MessageReader in(cut, 1);
    EXPECT_THROW(PoseMessages::getResult(in, 5), RankError) << size;
  }
  std::mt19937 random(3);
  for (int k = 0; k < 2000; ++k) {
    Message other = message;
    for (int n = 0; n < 3; ++n) other[random() % other.size()] = static_cast<char>(random());
    MessageReader in(other, 1);
    try {
      (void)PoseMessages::getResult(in, 5);
    } catch (const RankError&) {
    }
  }
}

}  // namespace
