#include "live/devices.h"
#include "live/live_rig.h"
#include "live/video_camera.h"

#include "../recordings/io_fixture.h"
#include "hand_fed_cameras.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

namespace {

using namespace live_test;
using io_test::refuses;
using namespace std::chrono_literals;

TEST(LiveRig, AColourCameraGetsItsLensWithItsPose) {
  auto cameras = std::make_unique<HandFedCameras>(std::vector<std::string>{"a", "webcam"}, ClockModel::Shared, false);
  std::vector<std::unique_ptr<io::CameraSource>> sources;
  sources.push_back(std::move(cameras));
  io::LiveRig rig(std::move(sources), {});
  EXPECT_EQ(rig.withoutIntrinsics(), std::vector<std::string>{"webcam"});
  std::vector<io::RigCamera> calibrated(2);
  for (std::size_t k = 0; k < 2; ++k) {
    calibrated[k].camera = rig.cameras()[k];
    calibrated[k].camera.intrinsics.fx = 77;
  }
  const float own = rig.cameras()[0].intrinsics.fx;
  rig.setPoses("rig.json", calibrated);
  EXPECT_TRUE(rig.withoutIntrinsics().empty());
  EXPECT_EQ(rig.cameras()[0].intrinsics.fx, own) << "it knows its lens";
  EXPECT_EQ(rig.cameras()[1].intrinsics.fx, 77);
  calibrated[1].camera.intrinsics.width += 2;
  auto again = std::make_unique<HandFedCameras>(std::vector<std::string>{"a", "webcam"}, ClockModel::Shared, false);
  sources.clear();
  sources.push_back(std::move(again));
  io::LiveRig other(std::move(sources), {});
  EXPECT_TRUE(refuses([&] { other.setPoses("rig.json", calibrated); },
                      {"rig.json: has the intrinsics of", "'webcam'", "must be of the same size"}));
}

TEST(VideoCamera, WhatIsNoneIsSaid) {
  EXPECT_TRUE(io::isDevice("video:/dev/video0"));
  EXPECT_TRUE(io::isDevice("video:rtsp://camera/stream"));
  EXPECT_TRUE(refuses([] { io::openDevice("rtsp://camera/stream"); }, {"video:rtsp://"}));
  EXPECT_TRUE(refuses([] { io::openDevice("webcam:0"); }, {"video:/dev/video0"}));
}

}  // namespace

#ifdef FUSE_FLOW_WITH_LIBAV

#include "../recorders/video_file_of.h"

namespace {

using namespace recorder_test;

std::uint8_t levelOf(int number) { return static_cast<std::uint8_t>(16 + 5 * (number % 44)); }

int freePort() {
  const int listening = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  EXPECT_EQ(bind(listening, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size), 0);
  close(listening);
  return ntohs(address.sin_port);
}

/** \brief A camera with an address: sends pictures to whom connects first, and then ends. */
class Sender {
 public:
  Sender(int port, int pictures, std::chrono::milliseconds apart, bool one_key = false) {
    thread_ = std::thread([=] {
      VideoOptions options;
      options.container = "mpegts";
      options.between = 0;
      options.pictures = pictures;
      if (one_key) options.codec = AV_CODEC_ID_H264;
      if (one_key) options.key_every = 1000;
      writeVideo("tcp://127.0.0.1:" + std::to_string(port) + "?listen=1", options, [&](int k, AVFrame& frame) {
        paintPlain(frame, levelOf(k), 128, 128);
        std::this_thread::sleep_for(apart);
      });
    });
  }
  ~Sender() { thread_.join(); }

 private:
  std::thread thread_;
};

std::string idOf(int port) { return "tcp://127.0.0.1:" + std::to_string(port); }

std::unique_ptr<io::Device> openSoon(const std::string& id) {
  for (int k = 0; k < 500; ++k) {
    try {
      return io::openVideoCamera(id);
    } catch (const io::InputError&) {  // it does not listen yet
      std::this_thread::sleep_for(10ms);
    }
  }
  return nullptr;
}

int shown(const io::LoadedView& images) {
  const double luma = 16 + 219.0 / 255 * images.color.at(30, 20).g;
  return static_cast<int>(std::lround((luma - 16) / 5));
}

TEST(VideoCamera, DeliversPicturesInTheirOrderWithTheirTimes) {
  const int port = freePort();
  const Sender sender(port, 40, 20ms);
  const std::unique_ptr<io::Device> camera = openSoon(idOf(port));
  ASSERT_NE(camera, nullptr);
  EXPECT_FALSE(camera->hasDepth());
  EXPECT_FALSE(camera->hasIntrinsics());
  EXPECT_TRUE(camera->hasColor());
  EXPECT_EQ(camera->camera().intrinsics.width, 64);
  EXPECT_EQ(camera->camera().intrinsics.height, 48);
  camera->start();
  int pictures = 0, before = -1;
  std::uint64_t stamp_before = 0;
  std::string end;
  for (int k = 0; k < 1000 && end.empty(); ++k) {
    try {
      const std::optional<io::DeviceImages> images = camera->wait(20ms);
      if (!images) continue;
      const int number = shown(*images->images);
      EXPECT_GT(number, before);
      const double passed = static_cast<double>(images->stamp - stamp_before);
      EXPECT_TRUE(before < 0 || std::abs(passed - 40000.0 * (number - before)) < 100) << passed;
      before = number;
      stamp_before = images->stamp;
      ++pictures;
    } catch (const io::InputError& error) {
      end = error.what();
    }
  }
  EXPECT_EQ(end, "video:" + idOf(port) + ": has ended");
  EXPECT_GT(pictures, 10) << "of a slow reader the oldest are given up";
  EXPECT_EQ(before, 39);
}

TEST(VideoCamera, TheKeyPictureThatItBeginsWithIsNotLost) {
  const int port = freePort();
  if (avcodec_find_encoder(AV_CODEC_ID_H264) == nullptr) GTEST_SKIP() << "no encoder of H.264";
  const Sender sender(port, 60, 20ms, true);  // there is no other
  std::unique_ptr<io::Device> camera = openSoon(idOf(port));
  ASSERT_NE(camera, nullptr);
  camera->start();
  int last = -1;
  std::string end;
  while (end.empty()) {
    try {
      if (const std::optional<io::DeviceImages> images = camera->wait(20ms)) last = shown(*images->images);
    } catch (const io::InputError& error) {
      end = error.what();
    }
  }
  EXPECT_EQ(last, 59 % 44) << end;
}

TEST(VideoCamera, OneThatEndsIsLookedForAndComesBack) {
  const int port = freePort();
  std::mutex mutex;
  std::vector<std::string> notices;
  std::atomic<int> views{0};
  std::atomic<int> restarts{0};
  std::atomic<std::uint64_t> last{0};
  io::DeviceTiming timing;
  timing.wait = timing.look_for = 10ms;
  std::unique_ptr<io::DeviceSource> source;
  const auto wait = [&](const auto& condition) {
    for (int k = 0; k < 2000 && !condition(); ++k) std::this_thread::sleep_for(5ms);
    return condition();
  };
  const auto said = [&](const std::string& words) {
    const std::lock_guard<std::mutex> lock(mutex);
    return std::any_of(notices.begin(), notices.end(),
                       [&](const std::string& line) { return line.find(words) != std::string::npos; });
  };
  {
    const Sender sender(port, 20, 40ms);  // as their times say
    std::unique_ptr<io::Device> device = openSoon(idOf(port));
    ASSERT_NE(device, nullptr);
    source = std::make_unique<io::DeviceSource>(
        std::move(device), [port] { return io::openVideoCamera(idOf(port)); }, timing);
    EXPECT_FALSE(source->hasDepth(0));
    source->start({[&](const io::CameraView& view) {
                     restarts += views > 0 && view.stamp <= last ? 1 : 0;
                     last = view.stamp;
                     ++views;
                   },
                   [&](const std::string& line) {
                     const std::lock_guard<std::mutex> lock(mutex);
                     notices.push_back(line);
                   }});
  }
  EXPECT_TRUE(wait([&] { return said("has ended; it is looked for again"); }));
  const int first = views;
  EXPECT_GT(first, 0);
  {
    const Sender sender(port, 20, 40ms);  // as their times say
    EXPECT_TRUE(wait([&] { return said("is back"); }));
  }
  EXPECT_TRUE(wait([&] { return views > first; }));
  source->stop();
  EXPECT_EQ(restarts, 1) << "its clock begins again, which the synchroniser knows of";
}

TEST(VideoCamera, StopDoesNotWaitForOneThatAcceptsAndIsSilent) {
  // Sixteen pictures, and then nobody but a listener who says nothing.
  const int port = freePort();
  std::unique_ptr<io::CameraSource> source;
  {
    const Sender sender(port, 16, 5ms);
    for (int k = 0; k < 500 && !source; ++k) {
      try {
        source = io::openVideoSource(idOf(port), 24h);
      } catch (const io::InputError&) {  // it does not listen yet
        std::this_thread::sleep_for(10ms);
      }
    }
    ASSERT_NE(source, nullptr);
    source->start({[](const io::CameraView&) {}, [](const std::string&) {}});
  }
  const int listening = socket(AF_INET, SOCK_STREAM, 0);
  const int yes = 1;
  setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  ASSERT_EQ(bind(listening, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(listen(listening, 4), 0);
  const int connected = accept(listening, nullptr, nullptr);  // it is looked for again
  ASSERT_GE(connected, 0);
  source->stop();  // or this test takes a day
  close(connected);
  close(listening);
}

TEST(VideoCamera, PasswordsAreInNoName) {
  for (const std::string id : {"rtsp://user:secret@127.0.0.1:1/a@b", "http://user:secret@127.0.0.1:1"}) {
    try {
      io::openVideoCamera(id);
      ADD_FAILURE() << "was opened";
    } catch (const io::InputError& error) {
      EXPECT_EQ(std::string(error.what()).find("secret"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("://127.0.0.1:1"), std::string::npos) << error.what();
    }
  }
}

TEST(VideoCamera, OneThatIsNotThereIsSaid) {
  const int port = freePort();
  EXPECT_TRUE(refuses([&] { io::openVideoCamera(idOf(port)); }, {"video:" + idOf(port) + ": cannot be opened"}));
  EXPECT_TRUE(refuses([] { io::openVideoCamera("/dev/video999"); }, {"video:/dev/video999: "}));
}

TEST(VideoCamera, AFileIsARecording) {
  const std::string file = (std::filesystem::temp_directory_path() / "fuse_flow_no_camera.mp4").string();
  std::ofstream(file) << "text";
  EXPECT_TRUE(refuses([&] { io::openVideoCamera(file); }, {"video:" + file, "is a file, and no camera"}) ||
              refuses([&] { io::openVideoCamera(file); }, {"built without libavdevice"}));
  EXPECT_TRUE(refuses([&] { io::openVideoCamera("file://" + file); }, {"is a file, and no camera"}));
  EXPECT_TRUE(refuses([] { io::openDevice("video:"); }, {"video:", "/dev/video0"}));
  std::filesystem::remove(file);
}

}  // namespace

#endif  // FUSE_FLOW_WITH_LIBAV
