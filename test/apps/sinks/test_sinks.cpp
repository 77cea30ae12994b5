#include "sinks/background_sink.h"
#include "sinks/cloud_files.h"
#include "sinks/quality_report.h"

#include "../recordings/io_fixture.h"

#include "clouds/cloud_io.h"
#include "recordings/read_ahead.h"

#include <atomic>
#include <chrono>
#include <iterator>
#include <thread>

namespace {

using namespace io_test;

class Sinks : public IoTest {
 protected:
  std::size_t points(const std::string& name) const {
    pcl::PointCloud<pcl::PointXYZ> cloud;
    io::readCloud(path(name), cloud);
    return cloud.size();
  }
  std::string textOf(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

std::shared_ptr<io::FusedFrame> frameOfPoints(std::size_t number, std::size_t points) {
  const auto frame = std::make_shared<io::FusedFrame>();
  frame->number = number;
  for (std::size_t k = 0; k < points; ++k) {
    PointFused p{};
    p.x = static_cast<float>(k);
    p.z = 1;
    frame->cloud.push_back(p);
  }
  return frame;
}

TEST_F(Sinks, CloudsOfSeveralFramesGoIntoAFolderByTheirNumbers) {
  io::CloudFiles files(path("out"), "pcd", 2);
  files.take(frameOfPoints(3, 5));
  files.take(frameOfPoints(1000000, 7));
  EXPECT_EQ(files.pathOf(3), path("out/000003.pcd"));
  EXPECT_EQ(points("out/000003.pcd"), 5u);
  EXPECT_EQ(points("out/1000000.pcd"), 7u);
  EXPECT_TRUE(files.finish().empty());
}

TEST_F(Sinks, TheCloudOfOneFrameGoesToTheFileThatIsNamed) {
  io::CloudFiles files(path("one.PLY"), "pcd", 1);
  files.take(frameOfPoints(8, 2));
  EXPECT_EQ(points("one.PLY"), 2u);
  EXPECT_THROW(io::CloudFiles(path("one.ply"), "ply", 2), io::OptionError);
  EXPECT_THROW(io::CloudFiles(path("one.txt"), "ply", 1), io::OptionError);
}

TEST_F(Sinks, CloudsOfAnEarlierRunAreNamed) {
  io::CloudFiles before(path("out"), "ply", 3);
  for (const std::size_t k : {0u, 1u, 2u}) before.take(frameOfPoints(k, 1));
  io::CloudFiles files(path("out"), "ply", 1);
  files.take(frameOfPoints(1, 1));
  const std::vector<std::string> lines = files.finish();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("2 clouds that this run has not written, such as 000000.ply"), std::string::npos) << lines[0];
}

TEST_F(Sinks, ACloudWithNormalsIsWrittenWithThemEvenWithoutPoints) {
  const auto frame = frameOfPoints(0, 0);
  frame->has_normals = true;
  io::CloudFiles files(path("n.pcd"), "pcd", 1);
  files.take(frame);
  EXPECT_NE(textOf("n.pcd").find("normal_x"), std::string::npos);
}

/** \brief Keeps the numbers of what it takes, slowly, and throws at one of them. */
class SlowSink : public io::FrameSink {
 public:
  explicit SlowSink(std::size_t fails_at) : fails_at_(fails_at) {}
  void take(const std::shared_ptr<const io::FusedFrame>& frame) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    if (frame->number == fails_at_) throw io::OutputError("no room for " + std::to_string(frame->number));
    taken.push_back(frame->number);
  }
  std::vector<std::string> finish() override { return {"finished after " + std::to_string(taken.size())}; }

  std::vector<std::size_t> taken;

 private:
  std::size_t fails_at_;
};

TEST(BackgroundSink, TakesAllFramesInTheirOrder) {
  const auto slow = std::make_shared<SlowSink>(1000);
  io::BackgroundSink sink(slow, 2);
  std::vector<std::size_t> numbers;
  for (std::size_t k = 0; k < 20; ++k) {
    sink.take(frameOfPoints(k, 0));
    numbers.push_back(k);
  }
  EXPECT_EQ(sink.finish(), std::vector<std::string>{"finished after 20"});
  EXPECT_EQ(slow->taken, numbers);
}

TEST(BackgroundSink, WhatIsThrownComesOutWithALaterFrameAndNothingIsTakenBehindIt) {
  const auto slow = std::make_shared<SlowSink>(3);
  io::BackgroundSink sink(slow, 1);
  const auto take_many = [&] {
    for (std::size_t k = 0; k < 20; ++k) sink.take(frameOfPoints(k, 0));
  };
  EXPECT_TRUE(refuses<io::OutputError>(take_many, {"no room for 3"}));
  EXPECT_TRUE(refuses<io::OutputError>([&] { sink.drain(); }, {"no room for 3"}));
  EXPECT_TRUE(refuses<io::OutputError>([&] { sink.finish(); }, {"no room for 3"}));
  EXPECT_EQ(slow->taken, (std::vector<std::size_t>{0, 1, 2}));
}

TEST(BackgroundSink, WhatWaitsIsTakenBeforeItEnds) {
  const auto slow = std::make_shared<SlowSink>(1000);
  {
    io::BackgroundSink sink(slow, 4);
    for (std::size_t k = 0; k < 4; ++k) sink.take(frameOfPoints(k, 0));
  }
  EXPECT_EQ(slow->taken.size(), 4u);
}

TEST(BackgroundSink, MemoryIsBoundedByWhatMayWait) {
  io::FramePool pool;
  io::BackgroundSink sink(std::make_shared<SlowSink>(1000), 2);
  for (std::size_t k = 0; k < 30; ++k) {
    const std::shared_ptr<io::FusedFrame> frame = pool.next();
    frame->number = k;
    sink.take(frame);
  }
  EXPECT_LE(pool.size(), 4u);  // at hand, at work, and two that wait
}

/** \brief Frames whose stamp is their number, and one that cannot be read. */
class NumberedRecording : public io::Recording {
 public:
  explicit NumberedRecording(std::size_t damaged) : damaged_(damaged) {}
  std::string kind() const override { return "numbers"; }
  std::size_t frameCount() const override { return 50; }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  std::vector<std::string> inputs() const override { return {}; }
  void read(std::size_t frame, io::LoadedFrame& out) override {
    ++reads;
    if (frame == damaged_) throw io::InputError("frame " + std::to_string(frame) + " is damaged");
    out.rig.stamp = frame;
  }

  std::atomic<int> reads{0};

 private:
  std::size_t damaged_;
  std::vector<Camera> cameras_;
};

TEST(ReadAhead, GivesTheFramesInTheirOrderAndWhatIsThrownInItsPlace) {
  NumberedRecording recording(30);
  const std::vector<std::size_t> chosen{3, 7, 5, 30, 8};
  io::ReadAhead ahead(recording, chosen, 2);
  io::LoadedFrame frame;
  for (std::size_t k = 0; k < 3; ++k) {
    ahead.next(frame);
    EXPECT_EQ(frame.rig.stamp, chosen[k]);
  }
  EXPECT_TRUE(refuses([&] { ahead.next(frame); }, {"frame 30 is damaged"}));
}

TEST(ReadAhead, ReadsNoFurtherAheadThanItMay) {
  NumberedRecording recording(1000);
  {
    io::ReadAhead ahead(recording, recording.frames(), 3);
    io::LoadedFrame frame;
    for (int k = 0; k < 10; ++k) ahead.next(frame);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_LE(recording.reads, 10 + 3);
  }  // ends though nobody has taken all
  EXPECT_LE(recording.reads, 10 + 4);
  const io::ReadAhead unused(recording, recording.frames(), 1);
}

TEST(FramePool, GivesMemoryAgainOnceNobodyHoldsIt) {
  io::FramePool pool;
  std::shared_ptr<const io::FusedFrame> kept = pool.next();
  EXPECT_NE(pool.next(), kept);
  EXPECT_EQ(pool.size(), 2u);
  const io::FusedFrame* const first = kept.get();
  kept.reset();
  EXPECT_EQ(pool.next().get(), first);
  EXPECT_EQ(pool.size(), 2u);
}

Camera camera() {
  Camera camera;
  camera.name = "left";
  camera.intrinsics = {4, 3, 5, 5, 1.5f, 1, {}};
  return camera;
}

TEST_F(Sinks, AReportKeepsOneFrameForFlicker) {
  io::QualityReport report("fuse_flow", {}, {});
  io::FramePool pool;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto frame = pool.next();
    frame->number = k;
    frame->input.rig.cameras.assign(1, camera());
    frame->input.rig.views.assign(1, {});  // missing
    report.take(frame);
  }
  EXPECT_EQ(pool.size(), 2u);
  EXPECT_EQ(report.report().json()["frames"].size(), 4u);
}

// A wall that the sensor measures twice, 2 mm apart, and once more after a gap.
TEST_F(Sinks, FlickerIsOfFramesThatFollowOneAnother) {
  io::QualityReport report("fuse_flow", {}, {});
  io::FramePool pool;
  for (const auto& [number, depth] : {std::pair<std::size_t, float>{3, 1.0f}, {4, 1.002f}, {6, 1.002f}}) {
    const auto frame = pool.next();
    frame->number = number;
    frame->cloud.clear();
    Camera wide = camera();
    wide.intrinsics = {64, 48, 60, 60, 31.5f, 23.5f, {}};
    frame->input.rig.cameras.assign(1, wide);
    frame->input.images.resize(1);
    io::FloatImage& image = frame->input.images[0].depth32;
    image.resize(64, 48);
    std::fill(image.data.begin(), image.data.end(), depth);
    frame->input.rig.views.assign(1, {});
    frame->input.rig.views[0].depth32 = image.view();
    for (int v = 0; v < 48; ++v)
      for (int u = 0; u < 64; ++u) {
        PointFused p{};
        p.x = depth * (static_cast<float>(u) - 31.5f) / 60;
        p.y = depth * (static_cast<float>(v) - 23.5f) / 60;
        p.z = depth;
        frame->cloud.push_back(p);
      }
    report.take(frame);
  }
  const nlohmann::json frames = report.report().json()["frames"];
  EXPECT_TRUE(frames[0]["flicker_mm"].is_null());
  ASSERT_TRUE(frames[1]["flicker_mm"].is_number()) << frames[1];
  EXPECT_NEAR(frames[1]["flicker_mm"].get<double>(), 2.0, 0.5);
  EXPECT_TRUE(frames[2]["flicker_mm"].is_null()) << "frame 5 is not there";
}

TEST_F(Sinks, AReportIsWrittenAtTheEnd) {
  io::QualityReport::Options options;
  options.measure = false;
  options.file = path("new/report.json");
  io::QualityReport report("fuse_flow", {"left"}, options);
  report.take(frameOfPoints(7, 3));
  EXPECT_FALSE(fs::exists(options.file));
  EXPECT_TRUE(report.finish().empty());
  EXPECT_NE(textOf("new/report.json").find("\"frame\": 7"), std::string::npos) << textOf("new/report.json");
}

}  // namespace
