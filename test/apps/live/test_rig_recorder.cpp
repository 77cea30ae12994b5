#include "live/rig_recorder.h"

#include "../recordings/io_fixture.h"
#include "numbered_rig.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <filesystem>
#include <fstream>
#include <thread>

#if defined(FUSE_FLOW_WITH_FASTCDR)

namespace {

namespace fs = std::filesystem;
using namespace live_test;
using io_test::refuses;

class RecordedRig : public io_test::IoTest {
 protected:
  std::unique_ptr<io::RigRecorder> recorder(const io::RigRecorder::Options& options, std::size_t cameras = 2) {
    return std::make_unique<io::RigRecorder>(path("rig.mcap"), NumberedRig(cameras, 1).cameras(),
                                             std::vector<bool>(cameras, false), options);
  }
  static std::shared_ptr<const io::LoadedView> view(std::size_t camera, std::size_t frame) {
    return std::make_shared<io::LoadedView>(NumberedRig::imagesOf(camera, frame));
  }
  /** \brief Frames in which every camera has the depth of one and the same frame. */
  std::size_t wholeFrames(const std::string& name, std::size_t cameras = 2) const {
    const auto recording = io::openRecording({path(name)});
    EXPECT_EQ(recording->cameras().size(), cameras);
    io::LoadedFrame frame;
    std::size_t whole = 0;
    for (const std::size_t k : recording->frames()) {
      recording->read(k, frame);
      bool all = true;
      for (std::size_t c = 0; c < cameras; ++c)
        all = all && !frame.images[c].depth16.empty() &&
              frame.images[c].depth16.data == NumberedRig::imagesOf(c, k).depth16.data;
      whole += all ? 1 : 0;
    }
    return whole;
  }
};

TEST_F(RecordedRig, EveryViewIsInTheFileWhoeverCompressedIt) {
  for (const unsigned int threads : {1u, 4u}) {
    io::RigRecorder::Options options;
    options.threads = threads;
    const auto recording = recorder(options);
    for (std::size_t frame = 0; frame < 100; ++frame)
      for (std::size_t camera = 0; camera < 2; ++camera)
        recording->take(camera, static_cast<io::Nanoseconds>(1000000000 + 33000000 * frame), view(camera, frame));
    recording->finish();
    EXPECT_EQ(recording->written(), 200u);
    EXPECT_EQ(recording->lost(), 0u);
    EXPECT_EQ(wholeFrames("rig.mcap"), 100u);
  }
}

#ifdef __GLIBC__
TEST_F(RecordedRig, NoByteOfAMessageIsWhatTheMemoryWas) {
  const io::RigMessages messages(path("rig.mcap"), NumberedRig(2, 1).cameras(), {false, false}, {});
  std::string bytes[2];
  for (const int k : {0, 1}) {
    mallopt(M_PERTURB, k == 0 ? 0x5a : 0xa5);  // what memory holds that nobody has written
    bytes[k] = messages.encode(1, 1234567890, *view(1, 7)).at(0).bytes;
  }
  mallopt(M_PERTURB, 0);
  EXPECT_GT(bytes[0].size(), 30u);
  EXPECT_EQ(bytes[0], bytes[1]);
}
#endif

TEST_F(RecordedRig, CamerasMayDeliverFromThreadsOfTheirOwn) {
  io::RigRecorder::Options options;
  options.threads = 2;
  const auto recording = recorder(options);
  std::vector<std::thread> cameras;
  for (std::size_t camera = 0; camera < 2; ++camera)
    cameras.emplace_back([&, camera] {
      for (std::size_t frame = 0; frame < 200; ++frame)
        recording->take(camera, static_cast<io::Nanoseconds>(33000000 * frame), view(camera, frame));
    });
  for (std::thread& camera : cameras) camera.join();
  recording->finish();
  EXPECT_EQ(wholeFrames("rig.mcap"), 200u);
}

TEST_F(RecordedRig, WhatComesTooFastIsCountedOrWaitedFor) {
  const auto large = std::make_shared<io::LoadedView>();
  large->depth16.resize(2000, 1000);
  for (std::size_t k = 0; k < large->depth16.data.size(); ++k)
    large->depth16.data[k] = static_cast<std::uint16_t>(k * 7919 % 5000);
  std::vector<Camera> cameras = NumberedRig(1, 1).cameras();
  cameras[0].intrinsics.width = 2000;
  cameras[0].intrinsics.height = 1000;
  for (const bool waits : {false, true}) {
    io::RigRecorder::Options options;
    options.threads = 1;
    options.most_waiting = 5000000;  // one of them, of 4 MB
    options.waits = waits;
    io::RigRecorder recording(path("large.mcap"), cameras, {false}, options);
    for (int k = 0; k < 20; ++k) recording.take(0, 33000000 * k, large);
    recording.finish();
    EXPECT_EQ(recording.written() + recording.lost(), 20u);
    EXPECT_EQ(recording.lost() == 0, waits);
    EXPECT_GE(recording.written(), 1u);
    const auto read = io::openRecording({path("large.mcap")});
    EXPECT_EQ(read->frames().size(), recording.written());
  }
}

TEST_F(RecordedRig, WhatAProgramThatIsKilledHadWrittenPlays) {
  io::RigRecorder::Options options;
  auto recording = recorder(options);
  const auto take = [&](std::size_t frame) {
    for (std::size_t camera = 0; camera < 2; ++camera)
      recording->take(camera, static_cast<io::Nanoseconds>(33000000 * frame), view(camera, frame));
  };
  // Small images: by its size no chunk would end for minutes.
  for (std::size_t frame = 0; frame < 10; ++frame) take(frame);
  const auto size = [&] { return fs::file_size(path("rig.mcap")); };
  while (size() < 1000) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  fs::copy_file(path("rig.mcap"), path("killed.mcap"));
  EXPECT_EQ(wholeFrames("killed.mcap"), 10u);
  recording.reset();  // without finish()
  EXPECT_EQ(wholeFrames("rig.mcap"), 10u);
}

TEST_F(RecordedRig, AFullDiskEndsItWithOneLine) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  fs::create_symlink("/dev/full", path("rig.mcap"));
  EXPECT_TRUE(refuses<io::OutputError>(
      [&] {
        const auto recording = recorder({});
        for (std::size_t frame = 0;; ++frame) {
          recording->take(0, static_cast<io::Nanoseconds>(33000000 * frame), view(0, frame));
          recording->check();
        }
      },
      {"cannot be written", "nothing of it can be read"}));
}

}  // namespace

#endif
