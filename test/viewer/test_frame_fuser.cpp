#include "viewer/frame_fuser.h"
#include "viewer/fusion_controls.h"
#include "viewer/fusion_worker.h"
#include "viewer/point_data.h"
#include "wall_source.h"

#include <gtest/gtest.h>

#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>

#include <condition_variable>
#include <mutex>

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
  EXPECT_EQ(answer->clouds[0]->points->GetNumberOfPoints(), static_cast<vtkIdType>(answer->clouds[0]->cloud->size()));
}

TEST_F(FrameFusing, AnotherColorFusesNothingAgain) {
  FusionRequest request = requestOf(*controls_);
  const auto first = fuser_->fuse(request, stop_);
  request.color_by = ColorBy::Camera;
  const auto second = fuser_->fuse(request, stop_);
  EXPECT_EQ(source_->reads, 1);
  EXPECT_EQ(second->clouds[0]->cloud, first->clouds[0]->cloud);
  EXPECT_NE(second->clouds[0]->points, first->clouds[0]->points);
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

TEST_F(FrameFusing, TheComparisonIsMadeOfTheSameFrame) {
  controls_->compareWith("concatenate");
  const auto answer = fuser_->fuse(requestOf(*controls_, 3), stop_);
  EXPECT_EQ(answer->frame, 3u);
  EXPECT_EQ(answer->clouds[1]->cloud->size(), 2u * WallSource::kWidth * WallSource::kHeight);
  EXPECT_EQ(source_->reads, 1);
}

TEST_F(FrameFusing, AFrameThatCannotBeReadIsAnAnswerThatSaysSo) {
  const auto answer = fuser_->fuse(requestOf(*controls_, 5), stop_);
  EXPECT_TRUE(answer->ended);
  EXPECT_EQ(answer->clouds[0], nullptr);
  EXPECT_EQ(answer->error, "frame 5: 000002.png: is cut short");
  EXPECT_TRUE(fuser_->fuse(requestOf(*controls_, 4), stop_)->error.empty()) << "the others can still be read";
}

TEST_F(FrameFusing, AParameterOutOfRangeIsAnAnswerThatNamesIt) {
  controls_->change([](FuseFlowParameters& p) { p.consistency.sigma = -1; });
  const auto answer = fuser_->fuse(requestOf(*controls_), stop_);
  EXPECT_FALSE(answer->ended) << "the recording goes on";
  EXPECT_NE(answer->error.find("sigma"), std::string::npos) << answer->error;
  controls_->reset();
  EXPECT_TRUE(fuser_->fuse(requestOf(*controls_), stop_)->clouds[0]);
}

TEST_F(FrameFusing, TheCoarseCloudHasAboutAsManyPointsAsWanted) {
  controls_->toggle(Component::SpatialHash);  // tens of thousands of points
  FusionRequest request = requestOf(*controls_);
  request.coarse_points = 1000;
  const auto coarse = fuser_->fuse(request, stop_)->clouds[0];
  EXPECT_LE(coarse->coarse->GetNumberOfPoints(), 1000);
  EXPECT_GE(coarse->coarse->GetNumberOfPoints(), 800);
  request.coarse_points = 100000;
  const auto whole = fuser_->fuse(request, stop_)->clouds[0];
  EXPECT_EQ(whole->coarse, whole->points) << "nothing to leave out";
}

TEST_F(FrameFusing, ItStopsBetweenTwoSteps) {
  stop_ = true;
  EXPECT_EQ(fuser_->fuse(requestOf(*controls_), stop_), nullptr);
}

TEST(PointData, HasThePositionsAndColorsOfEveryNthPoint) {
  Cloud cloud;
  std::vector<Rgb8> colors;
  for (int k = 0; k < 7; ++k) {
    cloud.push_back(PointFused());
    cloud[static_cast<std::size_t>(k)].x = static_cast<float>(k);
    colors.push_back({static_cast<std::uint8_t>(10 * k), 0, 0});
  }
  const auto data = toPolyData(cloud, colors, 3);
  ASSERT_EQ(data->GetNumberOfPoints(), 3);
  EXPECT_EQ(data->GetNumberOfVerts(), 1) << "one cell holds them";
  EXPECT_EQ(data->GetPoint(2)[0], 6);
  EXPECT_EQ(data->GetPointData()->GetScalars()->GetComponent(1, 0), 30);
  EXPECT_EQ(toPolyData(Cloud(), {})->GetNumberOfPoints(), 0);
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
