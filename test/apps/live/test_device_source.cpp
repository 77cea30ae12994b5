#include "../recordings/io_fixture.h"
#include "live/device_source.h"

#include <algorithm>
#include <deque>

namespace {

using io_test::refuses;
using namespace fuse_flow;
using BenchTime = std::chrono::milliseconds;

/** \brief What happens at a device, as the test wants it, and what a source says. */
class DeviceBench {
 public:
  enum class Step { Images, Nothing, Unplug };

  void next(Step step) {
    const std::lock_guard<std::mutex> lock(mutex_);
    steps_.push_back(step);
    changed_.notify_all();
  }
  void plug(bool connected) {
    const std::lock_guard<std::mutex> lock(mutex_);
    connected_ = connected;
  }
  bool connected() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return connected_;
  }
  Step take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (steps_.empty()) return Step::Nothing;
    const Step step = steps_.front();
    steps_.pop_front();
    return step;
  }

  io::CameraSource::Receiver receiver() {
    return {[this](const io::CameraView& view) { note("view " + std::to_string(view.stamp)); },
            [this](const std::string& line) { note(line); }};
  }
  void note(const std::string& line) {
    const std::lock_guard<std::mutex> lock(mutex_);
    lines_.push_back(line);
    changed_.notify_all();
  }
  /** \brief Waits until a line with these words was noted so often. */
  void await(const std::string& words, std::ptrdiff_t times = 1) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [&] {
      return std::count_if(lines_.begin(), lines_.end(),
                           [&](const std::string& line) { return line.find(words) != std::string::npos; }) >= times;
    });
  }
  std::vector<std::string> lines() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return lines_;
  }

  int open{0};        ///< devices that live
  std::string waits;  ///< Device::waitsFor()
  bool refuses_start{false};
  float focal_length{500};

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Step> steps_;
  std::vector<std::string> lines_;
  bool connected_{true};
};

class BenchDevice : public io::Device {
 public:
  explicit BenchDevice(DeviceBench& bench) : Device("bench:1"), bench_(bench) {
    ++bench_.open;
    camera_.name = "bench_1";
    camera_.intrinsics = {4, 2, bench.focal_length, bench.focal_length, 1.5f, 0.5f, {}};
  }
  ~BenchDevice() override { --bench_.open; }
  const Camera& camera() const override { return camera_; }
  bool hasColor() const override { return false; }
  std::vector<std::string> warnings() const override { return {"bench:1: is no camera"}; }
  void start() override {
    if (bench_.refuses_start) throw io::InputError("bench:1: cannot be started");
    bench_.note("started");
  }
  std::optional<io::DeviceImages> wait(BenchTime longest) override {
    switch (bench_.take()) {
      case DeviceBench::Step::Images:
        return io::DeviceImages{++stamp_, std::make_shared<io::LoadedView>()};
      case DeviceBench::Step::Unplug:
        throw std::runtime_error("bench:1: was unplugged");
      default:
        std::this_thread::sleep_for(longest);
        return {};
    }
  }
  bool connected() override { return bench_.connected(); }
  std::string waitsFor() const override { return bench_.waits; }

 private:
  DeviceBench& bench_;
  Camera camera_;
  std::uint64_t stamp_{0};
};

class DeviceSourceTest : public testing::Test {
 protected:
  /** \param give_up after how long a connected device that delivers nothing is opened again */
  std::unique_ptr<io::DeviceSource> source(BenchTime give_up = std::chrono::hours(1)) {
    io::DeviceTiming timing;
    timing.wait = timing.silent = timing.look_for = BenchTime(1);
    timing.give_up = give_up;
    return std::make_unique<io::DeviceSource>(
        std::make_unique<BenchDevice>(bench_),
        [this]() -> std::unique_ptr<io::Device> {
          if (!bench_.connected()) return nullptr;
          return std::make_unique<BenchDevice>(bench_);
        },
        timing);
  }

  DeviceBench bench_;
};

using BenchStep = DeviceBench::Step;

TEST_F(DeviceSourceTest, TellsTheCameraBeforeItStarts) {
  const auto camera = source();
  ASSERT_EQ(camera->cameras().size(), 1u);
  EXPECT_EQ(camera->cameras()[0].name, "bench_1");
  EXPECT_FALSE(camera->hasColor(0));
  EXPECT_FALSE(camera->hasPoses());
  EXPECT_EQ(camera->clocks(), ClockModel::Separate);
  EXPECT_EQ(camera->warnings(), std::vector<std::string>{"bench:1: is no camera"});
  EXPECT_TRUE(camera->running());
}

TEST_F(DeviceSourceTest, DeliversWithTheStampsOfTheDevice) {
  const auto camera = source();
  bench_.next(BenchStep::Images);
  bench_.next(BenchStep::Images);
  camera->start(bench_.receiver());
  bench_.await("view 2");
  camera->stop();
  EXPECT_EQ(bench_.lines(), (std::vector<std::string>{"started", "view 1", "view 2"}));
}

TEST_F(DeviceSourceTest, NothingIsDeliveredAndNothingIsOpenAfterStop) {
  const auto camera = source();
  camera->start(bench_.receiver());
  bench_.next(BenchStep::Images);
  bench_.await("view 1");
  camera->stop();
  EXPECT_EQ(bench_.open, 0);
  EXPECT_FALSE(camera->running());
  const std::size_t lines = bench_.lines().size();
  bench_.next(BenchStep::Images);
  camera->stop();
  EXPECT_EQ(bench_.lines().size(), lines);
}

TEST_F(DeviceSourceTest, StopsBeforeItStarts) {
  const auto camera = source();
  camera->stop();
  EXPECT_EQ(bench_.open, 0);
  camera->start(bench_.receiver());
  EXPECT_TRUE(bench_.lines().empty());
}

TEST_F(DeviceSourceTest, ADeviceThatCannotStartIsAnError) {
  bench_.refuses_start = true;
  const auto camera = source();
  EXPECT_TRUE(refuses([&] { camera->start(bench_.receiver()); }, {"bench:1: cannot be started"}));
}

TEST_F(DeviceSourceTest, GoesOnWhenAnUnpluggedDeviceIsBack) {
  const auto camera = source();
  camera->start(bench_.receiver());
  bench_.next(BenchStep::Images);
  bench_.await("view 1");
  bench_.plug(false);
  bench_.await("bench:1: was unplugged; it is looked for again");
  EXPECT_TRUE(camera->running());
  bench_.plug(true);
  bench_.await("bench:1: is back");
  bench_.next(BenchStep::Images);
  bench_.await("view 1", 2);
  camera->stop();
  EXPECT_EQ(bench_.open, 0);
}

TEST_F(DeviceSourceTest, AnExceptionOfTheLibraryIsALossToo) {
  const auto camera = source();
  bench_.next(BenchStep::Unplug);
  camera->start(bench_.receiver());
  bench_.await("bench:1: was unplugged; it is looked for again");
  bench_.await("bench:1: is back");
}

TEST_F(DeviceSourceTest, StopsWhileItLooksForTheDevice) {
  const auto camera = source();
  bench_.plug(false);
  camera->start(bench_.receiver());
  bench_.await("it is looked for again");
  camera->stop();
  EXPECT_EQ(bench_.open, 0);
}

TEST_F(DeviceSourceTest, ASilentDeviceIsOpenedAgainThoughItIsConnected) {
  const auto camera = source(BenchTime(1));
  camera->start(bench_.receiver());
  bench_.await("bench:1: is connected, but delivers no images; it is looked for again");
  bench_.await("bench:1: is back");
}

TEST_F(DeviceSourceTest, ADeviceThatWaitsForAnotherIsLeftOpenAndSaysSoOnce) {
  bench_.waits = "it waits for its master";
  const auto camera = source(BenchTime(1));
  camera->start(bench_.receiver());
  bench_.await("bench:1: delivers no images: it waits for its master");
  bench_.next(BenchStep::Images);
  bench_.await("bench:1: delivers images again");
  bench_.await("view 1");
  camera->stop();
  const std::vector<std::string> lines = bench_.lines();
  EXPECT_EQ(std::count(lines.begin(), lines.end(), "started"), 1);
}

TEST_F(DeviceSourceTest, WhyItCannotBeOpenedAgainIsSaidOnce) {
  const auto camera = source();
  camera->start(bench_.receiver());
  bench_.await("started");
  bench_.refuses_start = true;
  bench_.next(BenchStep::Unplug);
  bench_.await("bench:1: cannot be started");
  camera->stop();
  const std::vector<std::string> lines = bench_.lines();
  EXPECT_EQ(std::count(lines.begin(), lines.end(), "bench:1: cannot be started"), 1);
}

TEST_F(DeviceSourceTest, AnotherCalibrationEndsIt) {
  const auto camera = source();
  camera->start(bench_.receiver());
  bench_.await("started");
  bench_.focal_length = 510;
  bench_.next(BenchStep::Unplug);
  bench_.await("bench:1: is back with another calibration");
  camera->stop();
  EXPECT_FALSE(camera->running());
}

}  // namespace
