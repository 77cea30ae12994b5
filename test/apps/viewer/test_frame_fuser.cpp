#include "methods/gpu_method.h"
#include "viewer/controls/fusion_controls.h"
#include "viewer/fusing/frame_fuser.h"
#include "viewer/fusing/fusion_worker.h"
#include "viewer/world/point_data.h"
#include "wall_source.h"

#include <gtest/gtest.h>

#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>

#include <condition_variable>
#include <mutex>
#include <set>

namespace viewer_test {
namespace {

using namespace viewing;

FusionRequest requestOf(const FusionControls& controls, std::size_t frame = 0) {
  FusionRequest request;
  request.number = 1;
  request.frame = frame;
  request.settings = {controls.fused(), controls.comparison()};
  return request;
}

class FrameFusing : public testing::Test {
 protected:
  void SetUp() override {
    io::MethodOptions options;
    options.device = "cpu";
    options.threads = 1;
    controls_ = std::make_unique<FusionControls>("fuse_flow", options);
    auto source = std::make_unique<WallSource>(20, 5);
    source_ = source.get();
    fuser_ = std::make_unique<FrameFuser>(std::move(source));
  }

  std::unique_ptr<FusionControls> controls_;
  WallSource* source_{nullptr};
  std::unique_ptr<FrameFuser> fuser_;
  std::atomic<bool> stop_{false};
};

TEST_F(FrameFusing, TheAnswerHasTheCloudItsFiguresAndTheCameras) {
  const auto answer = fuser_->fuse(requestOf(*controls_), stop_);
  ASSERT_TRUE(answer->clouds[0]);
  EXPECT_EQ(answer->clouds[1], nullptr) << "nothing to compare with";
  EXPECT_EQ(answer->cameras.size(), 2u);
  EXPECT_EQ(answer->thumbnails.size(), 2u);
  for (const PointFused& p : *answer->clouds[0]->cloud) EXPECT_NEAR(p.z, 2, 0.005);
  EXPECT_LT(answer->clouds[0]->quality->error, 0.005);
  vtkIdType drawn = 0;
  for (const auto& slice : answer->clouds[0]->slices) drawn += slice->GetNumberOfPoints();
  EXPECT_EQ(drawn, static_cast<vtkIdType>(answer->clouds[0]->cloud->size()));
}

TEST_F(FrameFusing, AnotherColorFusesNothingAgain) {
  FusionRequest request = requestOf(*controls_);
  const auto first = fuser_->fuse(request, stop_);
  request.color_by = ColorBy::Camera;
  const auto second = fuser_->fuse(request, stop_);
  EXPECT_EQ(source_->reads, 1);
  EXPECT_EQ(second->clouds[0]->cloud, first->clouds[0]->cloud);
  EXPECT_NE(second->clouds[0]->slices, first->clouds[0]->slices);
}

TEST_F(FrameFusing, AnotherSettingReadsNothingAgain) {
  const auto first = fuser_->fuse(requestOf(*controls_), stop_);
  controls_->toggle(Component::SpatialHash);
  const auto second = fuser_->fuse(requestOf(*controls_), stop_);
  EXPECT_EQ(source_->reads, 1);
  EXPECT_EQ(second->clouds[0]->cloud->size(), second->clouds[0]->statistics.gated_points)
      << "without aggregation every confident pixel is a point";
  EXPECT_LT(first->clouds[0]->cloud->size(), second->clouds[0]->cloud->size());
}

TEST_F(FrameFusing, AWallThatStandsStillDoesNotFlicker) {
  EXPECT_EQ(fuser_->fuse(requestOf(*controls_, 1), stop_)->clouds[0]->surface->flicker.points, 0u) << "nothing before";
  const auto second = fuser_->fuse(requestOf(*controls_, 2), stop_);
  EXPECT_GT(second->clouds[0]->surface->flicker.points, 100u);
  EXPECT_NEAR(second->clouds[0]->surface->flicker.mean(), 0, 1e-4);
}

TEST_F(FrameFusing, FlickerIsFromTheFrameBeforeAlone) {
  const auto flicker = [&](std::size_t frame) {
    return fuser_->fuse(requestOf(*controls_, frame), stop_)->clouds[0]->surface->flicker;
  };
  flicker(0);
  EXPECT_EQ(flicker(2).points, 0u) << "a frame was left out";
  EXPECT_EQ(flicker(1).points, 0u) << "backwards";
  EXPECT_GT(flicker(2).points, 0u);
  controls_->toggle(Component::SpatialHash);
  EXPECT_EQ(flicker(2).points, 0u) << "another setting had no cloud before";
  EXPECT_GT(flicker(3).points, 0u);
  EXPECT_FALSE(fuser_->fuse(requestOf(*controls_, 5), stop_)->error.empty());
  EXPECT_EQ(flicker(4).points, 0u) << "after a frame that could not be read";
}

TEST_F(FrameFusing, FlickerIsHowFarASurfaceJumps) {
  source_->shift(3, 0.004f);  // less than the motion that is no noise
  fuser_->fuse(requestOf(*controls_, 2), stop_);
  const auto answer = fuser_->fuse(requestOf(*controls_, 3), stop_);
  EXPECT_NEAR(answer->clouds[0]->surface->flicker.mean(), 0.004, 5e-4);
}

TEST_F(FrameFusing, TheComparisonIsMadeOfTheSameFrame) {
  controls_->compareWith("concatenate");
  const auto answer = fuser_->fuse(requestOf(*controls_, 3), stop_);
  EXPECT_EQ(answer->frame, 3u);
  EXPECT_EQ(answer->clouds[1]->cloud->size(), 2u * WallSource::kWidth * WallSource::kHeight);
  EXPECT_EQ(source_->reads, 1);
}

TEST_F(FrameFusing, AFrameThatCannotBeReadIsAnAnswerThatSaysSo) {
  const auto answer = fuser_->fuse(requestOf(*controls_, 5), stop_);
  EXPECT_EQ(answer->clouds[0], nullptr);
  EXPECT_EQ(answer->error, "frame 6 (000005): 000002.png: is cut short");
  EXPECT_TRUE(fuser_->fuse(requestOf(*controls_, 4), stop_)->error.empty()) << "the others can still be read";
}

TEST_F(FrameFusing, ACameraWithADamagedImageIsMissingAndNamed) {
  source_->damageRight(3);
  const auto answer = fuser_->fuse(requestOf(*controls_, 3), stop_);
  EXPECT_TRUE(answer->error.empty()) << answer->error;
  EXPECT_EQ(answer->damaged,
            (std::vector<std::string>{"camera 'right' is missing: right/depth/000003.png: is cut short"}));
  EXPECT_EQ(answer->clouds[0]->statistics.missing_cameras, (std::vector<std::size_t>{1}));
  EXPECT_TRUE(answer->thumbnails[1].empty());
  EXPECT_TRUE(fuser_->fuse(requestOf(*controls_, 4), stop_)->damaged.empty());
}

TEST_F(FrameFusing, TheSettingThatLeavesNoPointIsFound) {
  const auto reason = [&](const std::function<void(FuseFlowParameters&)>& change) {
    controls_->reset();
    controls_->change([](FuseFlowParameters& p) {
      p.crop_box.reset();
      p.gate_noise = 0;  // tau is asked of all
    });
    controls_->change(change);
    const auto answer = fuser_->fuse(requestOf(*controls_), stop_);
    EXPECT_TRUE(answer->clouds[0]->cloud->empty());
    return answer->clouds[0]->why_empty;
  };
  EXPECT_EQ(reason([](FuseFlowParameters& p) { p.confidence.threshold = 1; }), "no point passes tau = 1");
  EXPECT_EQ(reason([](FuseFlowParameters& p) { p.aggregation.min_weight = 1; }), "no point passes smallest weight = 1");
  EXPECT_EQ(reason([](FuseFlowParameters& p) { p.max_noise = 1e-6f; }), "no point passes largest noise, mm = 0.001");
  EXPECT_EQ(
      reason([](FuseFlowParameters& p) { p.crop_box.emplace(Eigen::Vector3f(5, 5, 5), Eigen::Vector3f(6, 6, 6)); }),
      "no point passes the crop box");
  EXPECT_EQ(reason([](FuseFlowParameters& p) { p.preprocessing.max_range = 1; }),
            "no camera measured anything within its range");
  EXPECT_EQ(reason([](FuseFlowParameters& p) {
              p.confidence.threshold = 1;
              p.aggregation.min_weight = 1;
            }),
            "no point passes tau = 1, smallest weight = 1, largest noise, mm = 70, smallest support = 3");
}

TEST_F(FrameFusing, AParameterOutOfRangeIsAnAnswerThatNamesIt) {
  controls_->change([](FuseFlowParameters& p) { p.consistency.sigma = -1; });
  const auto answer = fuser_->fuse(requestOf(*controls_), stop_);
  EXPECT_NE(answer->error.find("sigma"), std::string::npos) << answer->error;
  controls_->reset();
  EXPECT_TRUE(fuser_->fuse(requestOf(*controls_), stop_)->clouds[0]);
}

TEST_F(FrameFusing, ItStopsBetweenTwoSteps) {
  stop_ = true;
  EXPECT_EQ(fuser_->fuse(requestOf(*controls_), stop_), nullptr);
}

TEST(PointData, HasThePositionsAndColorsOfThePointsAskedFor) {
  Cloud cloud;
  std::vector<Rgb8> colors;
  for (int k = 0; k < 7; ++k) {
    cloud.push_back(PointFused());
    cloud[static_cast<std::size_t>(k)].x = static_cast<float>(k);
    colors.push_back({static_cast<std::uint8_t>(10 * k), 0, 0});
  }
  const auto data = toPolyData(cloud, colors, {0, 3, 6});
  ASSERT_EQ(data->GetNumberOfPoints(), 3);
  EXPECT_EQ(data->GetNumberOfVerts(), 1) << "one cell holds them";
  EXPECT_EQ(data->GetPoint(2)[0], 6);
  EXPECT_EQ(data->GetPointData()->GetScalars()->GetComponent(1, 0), 30);
  EXPECT_EQ(toPolyData(Cloud(), {}, {})->GetNumberOfPoints(), 0);
}

TEST(PointData, SlicesHoldEveryPointOnceAndTheFirstFewAreSpreadEvenly) {
  constexpr int kPoints = 1000;
  Cloud cloud(kPoints, 1);
  for (int k = 0; k < kPoints; ++k) cloud[static_cast<std::size_t>(k)].x = static_cast<float>(k);
  const auto slices = slicesOf(cloud, std::vector<Rgb8>(kPoints), 52);
  ASSERT_EQ(slices.size(), 21u) << "20 of 50 points, made odd";
  std::set<int> seen;
  std::size_t drawn = 0;
  for (const auto& slice : slices) {
    for (vtkIdType k = 0; k < slice->GetNumberOfPoints(); ++k)
      EXPECT_TRUE(seen.insert(static_cast<int>(slice->GetPoint(k)[0])).second);
    EXPECT_LE(slice->GetNumberOfPoints(), 52);
    if (++drawn != thinSlices(slices.size())) continue;
    for (auto at = seen.begin(); std::next(at) != seen.end(); ++at)
      EXPECT_LE(*std::next(at) - *at, 8) << "gap at " << *at;
  }
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(kPoints));
  EXPECT_EQ(slicesOf(Cloud(), {}).size(), 1u);
  EXPECT_LE(slicesOf(cloud, std::vector<Rgb8>(kPoints), 1).size(), kMaxSlices + 1);
}

/** \brief Three cameras in a room, each calibrated 20 mm and 0.5 degrees off unless said otherwise. */
class Refining : public testing::Test {
 protected:
  Refining() {
    options_.scene = "room";
    options_.rig = "ring-3";
    options_.scale = 0.5;
    options_.sensor = "ideal";
    options_.faults.position_error = 0.02;
    options_.faults.rotation_error = 0.5 * M_PI / 180;
  }
  std::shared_ptr<const FusedFrame> fuse(bool refine, std::size_t frame = 0) {
    if (!fuser_) fuser_ = std::make_unique<FrameFuser>(makeSimulatedSource(options_));
    FusionRequest request = requestOf(controls_, frame);
    request.refine_extrinsics = refine;
    return fuser_->fuse(request, stop_);
  }
  /** \brief How far the second camera is from where it should be, seen from the first; metres. */
  double relativeError(const std::vector<Camera>& cameras) const {
    const std::vector<Camera> truth = simulation::Simulator(options_).trueCameras();
    const auto place = [](const std::vector<Camera>& c) {
      return Eigen::Vector3d((c[0].T_world_camera.inverse() * c[1].T_world_camera).translation());
    };
    return (place(cameras) - place(truth)).norm();
  }

  simulation::SimulationOptions options_;
  FusionControls controls_{"fuse_flow", [] {
                             io::MethodOptions options;
                             options.device = "cpu";
                             return options;
                           }()};
  std::atomic<bool> stop_{false};
  std::unique_ptr<FrameFuser> fuser_;
};

TEST_F(Refining, BringsTheViewsOfAStandingFrameTogetherAndOffAgainPosesAreAsGiven) {
  const auto given = fuse(false), refined = fuse(true), again = fuse(false);
  ASSERT_TRUE(refined->error.empty()) << refined->error;
  EXPECT_FALSE(given->refined);
  ASSERT_TRUE(refined->refined);
  EXPECT_LT(refined->clouds[0]->quality->multi_view_error, 0.7 * given->clouds[0]->quality->multi_view_error);
  EXPECT_LT(relativeError(refined->cameras), 0.3 * relativeError(given->cameras));
  ASSERT_EQ(refined->refined->corrections.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const CameraMotion& correction = refined->refined->corrections[k];
    EXPECT_TRUE((correction.T_new_old * given->cameras[k].T_world_camera).isApprox(refined->cameras[k].T_world_camera));
    EXPECT_TRUE(again->cameras[k].T_world_camera.isApprox(given->cameras[k].T_world_camera, 0));
  }
  EXPECT_FALSE(again->refined);
  EXPECT_EQ(again->clouds[0]->quality->error, given->clouds[0]->quality->error);
}

TEST_F(Refining, TellsABumpedCameraUntilItIsSwitchedOff) {
  options_.faults = {};
  options_.faults.bump = 0.06;
  options_.faults.bump_rotation = M_PI / 180;
  options_.faults.bump_frame = 2;
  EXPECT_TRUE(fuse(true, 1)->refined->moved.empty());
  std::shared_ptr<const FusedFrame> last;
  for (std::size_t frame = 2; frame < 9; ++frame) last = fuse(true, frame);
  ASSERT_EQ(last->refined->moved.size(), 1u);
  EXPECT_EQ(last->refined->moved[0].camera, 2u);
  EXPECT_NEAR(last->refined->moved[0].translation, 0.06, 0.02);
  fuse(false, 9);
  EXPECT_TRUE(fuse(true, 9)->refined->moved.empty());
}

/** \brief Seen from what it says where there is no GPU: asked for one, a method that has no use for it says so itself. */
TEST_F(Refining, RunsOnTheDeviceOfTheFusion) {
  io::MethodOptions options;
  options.device = "gpu";
  controls_ = FusionControls("concatenate", options);
  const auto says = [](const FusedFrame& answer, const char* words) {
    return answer.error.find(words) != std::string::npos ? testing::AssertionSuccess()
                                                         : testing::AssertionFailure() << answer.error;
  };
  EXPECT_TRUE(says(*fuse(false), "runs on the CPU only"));
  EXPECT_TRUE(says(*fuse(true), io::runsOnGpu("auto") ? "runs on the CPU only" : "use --device cpu"));
}

/** \brief A source that the test holds: nothing is read until it is let go. */
class HeldSource : public WallSource {
 public:
  void read(std::size_t frame, io::LoadedFrame& out) override {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      ++waiting_;
      changed_.notify_all();
      changed_.wait(lock, [this] { return open_; });
    }
    frames.push_back(frame);
    WallSource::read(frame, out);
  }
  void waitUntilAsked() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return waiting_ > 0; });
  }
  void letGo() {
    const std::lock_guard<std::mutex> lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

  std::vector<std::size_t> frames;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int waiting_{0};
  bool open_{false};
};

TEST(FusionWorker, WhileAFrameTakesItsTimeOnlyTheLastRequestWaits) {
  auto held = std::make_unique<HeldSource>();
  HeldSource* source = held.get();
  const FusionControls controls("fuse_flow", io::MethodOptions());
  FusionWorker worker(std::move(held));
  worker.post(requestOf(controls, 0));
  source->waitUntilAsked();
  for (std::size_t frame = 1; frame <= 9; ++frame) {
    FusionRequest request = requestOf(controls, frame);
    request.number = frame + 1;
    worker.post(std::move(request));
  }
  source->letGo();
  while ((*worker.wait())->number != 10) {
  }
  EXPECT_EQ(source->frames, (std::vector<std::size_t>{0, 9}));
}

TEST(FusionWorker, StopsBetweenFramesAndSaysWhenItCannot) {
  auto held = std::make_unique<HeldSource>();
  HeldSource* source = held.get();
  const FusionControls controls("fuse_flow", io::MethodOptions());
  {
    FusionWorker idle(std::make_unique<WallSource>());
    EXPECT_TRUE(idle.stopWithin(std::chrono::minutes(1)));
  }
  FusionWorker worker(std::move(held));
  worker.post(requestOf(controls));
  source->waitUntilAsked();
  EXPECT_FALSE(worker.stopWithin(std::chrono::milliseconds(1))) << "it reads, and cannot be interrupted";
  source->letGo();
}

}  // namespace
}  // namespace viewer_test
