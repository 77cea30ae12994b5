#include "live/live_rig.h"

#include "../recordings/io_fixture.h"
#include "hand_fed_cameras.h"

namespace {

using namespace live_test;
using io_test::refuses;
using namespace std::chrono_literals;

struct FedRig {
  explicit FedRig(std::vector<std::string> names, ClockModel clocks = ClockModel::Shared, bool posed = true) {
    auto owned = std::make_unique<HandFedCameras>(std::move(names), clocks, posed);
    source = owned.get();
    std::vector<std::unique_ptr<io::CameraSource>> sources;
    sources.push_back(std::move(owned));
    io::LiveRig::Options options;
    options.clock = [time = time] { return *time; };
    rig = std::make_unique<io::LiveRig>(std::move(sources), options);
  }
  void pass(std::chrono::microseconds duration) { *time += duration; }

  std::shared_ptr<std::chrono::microseconds> time = std::make_shared<std::chrono::microseconds>(100s);
  HandFedCameras* source;
  std::unique_ptr<io::LiveRig> rig;
};

std::vector<std::string> names(const io::LiveRig& rig) {
  std::vector<std::string> all;
  for (const Camera& camera : rig.cameras()) all.push_back(camera.name);
  return all;
}

TEST(LiveRig, ViewsOfOneInstantAreAFrameThatOwnsThem) {
  FedRig fed({"left", "right"});
  fed.rig->start();
  io::LiveInstant instant;
  fed.source->deliver(0, 1000000, 7);
  fed.pass(3ms);
  fed.source->deliver(1, 1000400, 7);
  ASSERT_TRUE(fed.rig->next(0ms, instant));
  EXPECT_EQ(instant.rig.stamp, 1000200u);
  EXPECT_EQ(instant.arrived, 100s + 3ms);
  ASSERT_EQ(instant.rig.views.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(instant.rig.cameras[k].name, fed.rig->cameras()[k].name);
    ASSERT_FALSE(instant.rig.views[k].missing());
    EXPECT_EQ(instant.rig.views[k].depth16.row(2)[3], NumberedRig::valueOf(k, 7));
    EXPECT_FALSE(instant.rig.views[k].color);
  }
  checkRigFrame(instant.rig);
  fed.rig.reset();  // the images stay
  EXPECT_EQ(instant.rig.views[1].depth16.row(0)[0], NumberedRig::valueOf(1, 7));
}

TEST(LiveRig, ACameraThatStopsIsSaidOnceAndAgainWhenItReturns) {
  FedRig fed({"left", "right"});
  fed.rig->start();
  for (std::uint64_t k = 0; k < 10; ++k) {
    fed.source->deliver(0, 1000000 + 33000 * k);
    fed.source->deliver(1, 1000000 + 33000 * k);
    fed.pass(33ms);
    EXPECT_TRUE(fed.rig->takeNotices().empty());
  }
  for (std::uint64_t k = 10; k < 60; ++k) {
    fed.source->deliver(0, 1000000 + 33000 * k);
    fed.pass(33ms);
  }
  std::vector<std::string> lines = fed.rig->takeNotices();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0], "camera 'right' has delivered nothing for 1.7 s; the others are fused without it");
  EXPECT_TRUE(fed.rig->takeNotices().empty());
  std::vector<io::CameraStatus> status = fed.rig->status();
  EXPECT_FALSE(status[0].silent);
  ASSERT_TRUE(status[1].silent);
  EXPECT_NEAR(*status[1].silent, 1.683, 1e-9);
  io::LiveInstant instant;
  ASSERT_TRUE(fed.rig->next(0ms, instant));
  EXPECT_TRUE(instant.rig.views[1].missing());
  EXPECT_FALSE(instant.rig.views[0].missing());
  fed.source->deliver(1, 1000000 + 33000 * 60);
  lines = fed.rig->takeNotices();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0], "camera 'right' delivers again, after 1.7 s");
  EXPECT_FALSE(fed.rig->status()[1].silent);
  EXPECT_EQ(fed.rig->status()[1].lost, 50u);  // what it would have delivered meanwhile
  EXPECT_EQ(fed.rig->status()[0].lost, 0u);
}

TEST(LiveRig, ACameraThatNeverDeliversAndOneThatHasEnded) {
  FedRig fed({"only"});
  fed.rig->start();
  fed.pass(1500ms);
  const std::vector<std::string> lines = fed.rig->takeNotices();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0], "camera 'only' has not delivered anything yet, 1.5 s after the start");
  fed.source->notice("only: was unplugged");
  EXPECT_EQ(fed.rig->takeNotices(), (std::vector<std::string>{"only: was unplugged"}));
  fed.source->deliver(0, 5);
  EXPECT_EQ(fed.rig->takeNotices(), (std::vector<std::string>{"camera 'only' delivers, after 1.5 s"}));
  EXPECT_TRUE(fed.rig->running());
  fed.source->runs = false;
  fed.pass(10s);
  EXPECT_TRUE(fed.rig->takeNotices().empty());
  EXPECT_FALSE(fed.rig->running());
  fed.source->why = "its file is damaged";
  EXPECT_TRUE(refuses([&] { fed.rig->running(); }, {"its file is damaged"}));
}

TEST(LiveRig, ACameraThatIsSlowHasNotStopped) {
  FedRig fed({"thermometer"});
  fed.rig->start();
  fed.source->deliver(0, 1000000);
  fed.pass(2s);
  fed.source->deliver(0, 3000000);
  fed.rig->takeNotices();  // before its second image nobody knows
  for (std::uint64_t k = 2; k < 6; ++k) {
    fed.pass(1900ms);
    EXPECT_TRUE(fed.rig->takeNotices().empty());
    fed.pass(100ms);
    fed.source->deliver(0, 1000000 + 2000000 * k);
  }
  fed.pass(5900ms);
  EXPECT_TRUE(fed.rig->takeNotices().empty());
  fed.pass(200ms);
  EXPECT_EQ(fed.rig->takeNotices(), (std::vector<std::string>{"camera 'thermometer' has delivered nothing for 6.1 s"}));
}

TEST(LiveRig, ByDefaultItsClockIsTheTimeOfDay) {
  std::vector<std::unique_ptr<io::CameraSource>> sources;
  sources.push_back(std::make_unique<HandFedCameras>(std::vector<std::string>{"a"}, ClockModel::Separate));
  auto* source = static_cast<HandFedCameras*>(sources[0].get());
  const auto before = std::chrono::system_clock::now().time_since_epoch();
  io::LiveRig rig(std::move(sources), {});
  std::uint64_t heard = 0;
  rig.setListener([&](std::size_t, std::uint64_t time, const io::CameraView&) { heard = time; });
  rig.start();
  source->deliver(0, 17);
  EXPECT_GE(std::chrono::microseconds(heard) + 1s, before);
  EXPECT_LE(std::chrono::microseconds(heard), before + 24h);
}

TEST(LiveRig, CountsRatesAndLosses) {
  FedRig fed({"fast", "slow"});
  fed.rig->start();
  for (std::uint64_t k = 0; k < 200; ++k) {
    if (k % 20 != 7) fed.source->deliver(0, 1000000 + 25000 * k);
    if (k % 4 == 0) fed.source->deliver(1, 1000000 + 25000 * k);
    fed.pass(25ms);
  }
  const std::vector<io::CameraStatus> status = fed.rig->status();
  EXPECT_NEAR(status[0].rate, 38, 0.6);
  EXPECT_NEAR(status[1].rate, 10, 0.6);
  EXPECT_EQ(status[0].received, 190u);
  EXPECT_EQ(status[0].lost, 10u);
  EXPECT_EQ(status[1].received, 50u);
  EXPECT_EQ(status[1].lost, 0u);
  EXPECT_EQ(io::describe(status[1]).rfind("slow:  10.", 0), 0u) << io::describe(status[1]);
}

TEST(LiveRig, ItsListenerHearsEachViewByOneClock) {
  FedRig fed({"left", "right"}, ClockModel::Separate);
  std::vector<std::pair<std::size_t, std::uint64_t>> heard;
  fed.rig->setListener([&](std::size_t camera, std::uint64_t time, const io::CameraView& view) {
    EXPECT_EQ(view.camera, camera);
    heard.emplace_back(camera, time);
  });
  fed.rig->start();
  std::uint64_t before[2] = {0, 0};
  for (std::uint64_t k = 0; k < 50; ++k) {
    // Exposed at 100 s + 33 ms k of the host; the second camera's clock is an hour ahead; views are on their way for 2 ms or more.
    fed.pass(2ms);
    fed.source->deliver(0, 33000 * k);
    if (k % 3 == 0) fed.pass(1ms);
    fed.source->deliver(1, 3600000000 + 33000 * k);
    fed.pass(k % 3 == 0 ? 30ms : 31ms);
  }
  ASSERT_EQ(heard.size(), 100u);
  for (std::size_t k = 0; k < heard.size(); ++k) {
    EXPECT_EQ(heard[k].first, k % 2);
    EXPECT_GT(heard[k].second, before[k % 2]);
    before[k % 2] = heard[k].second;
    // By the host's clock, as they would have come by the quickest way.
    EXPECT_NEAR(static_cast<double>(heard[k].second), 100e6 + 2000 + 33000.0 * static_cast<double>(k / 2), 1001);
  }
  EXPECT_NEAR(static_cast<double>(fed.rig->status()[1].clock_offset.count()), -3600e6, 1001);
}

TEST(LiveRig, SeveralSourcesAreOneRigWithNamesOfTheirOwn) {
  std::vector<std::unique_ptr<io::CameraSource>> sources;
  for (int k = 0; k < 3; ++k)
    sources.push_back(std::make_unique<HandFedCameras>(std::vector<std::string>{"k4a:0"}, ClockModel::Shared, false));
  auto* last = static_cast<HandFedCameras*>(sources[2].get());
  io::LiveRig rig(std::move(sources), {});
  EXPECT_EQ(names(rig), (std::vector<std::string>{"k4a_0", "k4a_0_2", "k4a_0_3"}));
  EXPECT_EQ(rig.withoutPoses(), names(rig));
  std::size_t heard = 99;
  rig.setListener([&](std::size_t camera, std::uint64_t, const io::CameraView&) { heard = camera; });
  rig.start();
  last->deliver(0, 1);
  EXPECT_EQ(heard, 2u);
  EXPECT_TRUE(refuses([] { io::LiveRig({}, {}); }, {"there is no camera"}));
}

io::RigCamera standingAt(const std::string& name, double x) {
  io::RigCamera entry;
  entry.camera.name = name;
  entry.camera.T_world_camera.translation().x() = x;
  entry.camera.noise = NoiseModel();
  return entry;
}

TEST(LiveRig, PosesAreFoundByNameElseByPlace) {
  FedRig fed({"a", "b"}, ClockModel::Shared, false);
  fed.rig->setPoses("rig.json", {standingAt("c", 9), standingAt("b", 2), standingAt("a", 1)});
  EXPECT_EQ(fed.rig->cameras()[0].T_world_camera.translation().x(), 1);
  EXPECT_EQ(fed.rig->cameras()[1].T_world_camera.translation().x(), 2);
  EXPECT_TRUE(fed.rig->cameras()[1].noise);
  EXPECT_EQ(fed.rig->cameras()[1].intrinsics.width, NumberedRig::kWidth);  // the device knows better
  EXPECT_TRUE(fed.rig->withoutPoses().empty());
  ASSERT_EQ(fed.rig->warnings().size(), 1u);
  EXPECT_NE(fed.rig->warnings()[0].find("do not run: 'c'; the others"), std::string::npos) << fed.rig->warnings()[0];
  FedRig other({"a", "b"}, ClockModel::Shared, false);
  other.rig->setPoses("rig.json", {standingAt("left", 3), standingAt("right", 4)});
  EXPECT_EQ(other.rig->cameras()[1].T_world_camera.translation().x(), 4);
  ASSERT_EQ(other.rig->warnings().size(), 1u);
  EXPECT_NE(other.rig->warnings()[0].find("in their order"), std::string::npos);
  EXPECT_TRUE(refuses(
      [&] {
        other.rig->setPoses("r.json", {standingAt("a", 3), standingAt("right", 4)});
      },
      {"r.json", "'a', 'b'"}));
  EXPECT_TRUE(refuses([&] { other.rig->setPoses("r.json", {standingAt("x", 3)}); }, {"r.json", "'a', 'b'"}));
  io::RigCamera distances = standingAt("b", 2);
  distances.depth.is_distance = true;
  EXPECT_TRUE(refuses([&] { fed.rig->setPoses("r.json", {standingAt("a", 1), distances}); }, {"'b'", "depth_is"}));
}

// Two computers each have a camera of one name, and one of these computers is lost: the camera that is left would get the pose of the other.
TEST(LiveRig, PosesOfCamerasThatAreCalledAlikeNeedAllOfThem) {
  FedRig both({"a", "a", "b"}, ClockModel::Shared, false);
  both.rig->setPoses("rig.json", {standingAt("a", 1), standingAt("a_2", 2), standingAt("b", 3)});
  EXPECT_EQ(both.rig->cameras()[1].T_world_camera.translation().x(), 2);
  EXPECT_TRUE(both.rig->warnings().empty());
  FedRig one({"a", "b"}, ClockModel::Shared, false);
  EXPECT_TRUE(refuses(
      [&] {
        one.rig->setPoses("rig.json", {standingAt("a", 1), standingAt("a_2", 2), standingAt("b", 3)});
      },
      {"rig.json", "'a' and 'a_2'", "nobody knows which"}));
}

}  // namespace
