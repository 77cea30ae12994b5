#include "viewer/live_frames.h"

#include "../live/numbered_rig.h"

#include <gtest/gtest.h>

#include <thread>

namespace viewer_test {
namespace {

using namespace fuse_flow;
using live_test::NumberedRig;

/** \brief Cameras that never deliver anything. */
class SilentCameras : public io::CameraSource {
 public:
  const std::vector<Camera>& cameras() const override { return rig_.cameras(); }
  void start(const Receiver&) override {}
  void stop() override {}
  bool running() const override { return true; }

 private:
  NumberedRig rig_{2, 1};
};

struct LiveSource {
  LiveSource() {
    std::vector<std::unique_ptr<io::CameraSource>> sources;
    sources.push_back(std::make_unique<SilentCameras>());
    rig = std::make_unique<io::LiveRig>(std::move(sources), io::LiveRig::Options());
    frames = std::make_unique<viewing::LiveFrames>(*rig, "2 cameras", inlet);
  }
  /** \brief The first camera's depth is of that frame; the second camera is missing. */
  std::weak_ptr<const io::LiveInstant> put(std::size_t number) {
    const auto instant = std::make_shared<io::LiveInstant>();
    instant->rig.cameras = rig->cameras();
    instant->rig.views.resize(2);
    instant->held = {std::make_shared<io::LoadedView>(NumberedRig::imagesOf(0, number)), nullptr};
    instant->rig.views[0].depth16 = instant->held[0]->depth16.view();
    inlet->put(instant);
    return instant;
  }
  /** \brief The number of the frame that the source gives. */
  std::size_t read() {
    frames->read(5, loaded);
    EXPECT_TRUE(loaded.rig.views[1].missing());
    EXPECT_EQ(loaded.images.size(), 2u);
    return loaded.rig.views[0].depth16.row(2)[1] % 1000;
  }

  std::shared_ptr<viewing::LiveFrames::Inlet> inlet = std::make_shared<viewing::LiveFrames::Inlet>();
  std::unique_ptr<io::LiveRig> rig;
  std::unique_ptr<viewing::LiveFrames> frames;
  io::LoadedFrame loaded;
};

TEST(LiveFrames, KeepTheImagesOfTheFrameBeforeAndNoOlder) {
  LiveSource source;
  const std::weak_ptr<const io::LiveInstant> first = source.put(1);
  source.read();
  source.put(2);
  EXPECT_EQ(source.read(), 2u);
  EXPECT_FALSE(first.expired());
  source.put(3);
  EXPECT_EQ(source.read(), 3u);
  EXPECT_TRUE(first.expired());
}

TEST(LiveFrames, GiveTheLatestInstantAndKeepItsImages) {
  LiveSource source;
  source.put(1);
  source.put(2);
  EXPECT_EQ(source.read(), 2u);
  source.put(3);
  EXPECT_EQ(source.loaded.rig.views[0].depth16.row(0)[0] % 1000, 2);  // until the next one is read
  EXPECT_EQ(source.read(), 3u);
  source.inlet->end();
  EXPECT_EQ(source.read(), 3u);  // all that there is
}

TEST(LiveFrames, WaitForWhatComes) {
  LiveSource source;
  std::thread camera([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    source.put(7);
  });
  EXPECT_EQ(source.read(), 7u);
  camera.join();
}

TEST(LiveFrames, SayThatNothingHasComeAndHowTheCamerasDo) {
  LiveSource source;
  source.inlet->end();
  io::LoadedFrame frame;
  EXPECT_THROW(source.frames->read(0, frame), io::InputError);
  ASSERT_EQ(source.frames->status().size(), 2u);
  EXPECT_EQ(source.frames->status()[1].rfind("camera_1: ", 0), 0u) << source.frames->status()[1];
  EXPECT_FALSE(source.frames->frameCount());
}

}  // namespace
}  // namespace viewer_test
