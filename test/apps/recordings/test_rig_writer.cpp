
#include "io_fixture.h"

#include <fuse_flow/recordings/rig_writer.h>

namespace {

using namespace io_test;

class RigWriter : public IoTest {
 protected:
  /** \brief Two cameras of 4 × 3 pixels. */
  static io::RigDescription rig() {
    io::RigDescription rig;
    for (const char* name : {"left", "right"}) {
      Camera camera;
      camera.name = name;
      camera.intrinsics.width = 4;
      camera.intrinsics.height = 3;
      camera.intrinsics.fx = camera.intrinsics.fy = 3;
      rig.cameras.push_back({camera, 0.001f});
    }
    return rig;
  }

  /** \brief What the left camera alone has measured: depth and colour. */
  static void measure(io::LoadedFrame& frame) {
    frame.images.resize(2);
    frame.rig.views.assign(2, DepthView());
    io::LoadedView& left = frame.images[0];
    left.depth16.resize(4, 3);
    left.depth16.at(2, 1) = 1234;
    left.color.resize(4, 3);
    left.color.at(3, 2) = {1, 2, 3};
    frame.rig.views[0].depth16 = left.depth16.view();
    frame.rig.views[0].color = left.color.view();
  }
};

TEST_F(RigWriter, AFolderIsARecordingOnceItIsFinished) {
  const io::RigWriter writer(path("rig"), rig(), true);
  io::LoadedFrame frame, back;
  measure(frame);
  writer.write(0, frame);
  EXPECT_TRUE(refuses([&] { io::openRecording({path("rig")}); }, {path("rig")}));
  writer.finish();
  io::openRecording({path("rig")})->read(0, back);
  EXPECT_EQ(back.images[0].depth16.at(2, 1), 1234);
  EXPECT_EQ(back.images[0].color.at(3, 2).b, 3);
}

TEST_F(RigWriter, AViewThatIsMissingIsAMissingFile) {
  const io::RigWriter writer(path("rig"), rig(), false);
  io::LoadedFrame frame, back;
  measure(frame);
  frame.rig.views[0].color = {};
  writer.write(0, frame);
  writer.finish();
  EXPECT_TRUE(fs::exists(path("rig/left/depth/000000.png")));
  EXPECT_FALSE(fs::exists(path("rig/right/depth/000000.png")));
  EXPECT_FALSE(fs::exists(path("rig/left/color")));
  io::openRecording({path("rig")})->read(0, back);
  EXPECT_FALSE(back.rig.views[0].missing());
  EXPECT_TRUE(back.rig.views[1].missing());
}

TEST_F(RigWriter, DepthInFloatAndConfidenceAreReadBackAsTheyWere) {
  io::RigDescription description = rig();
  for (io::RigCamera& entry : description.cameras) {
    entry.camera.depth_scale = 1;
    entry.confidence_scale.reset();
  }
  description.cameras[1].confidence_scale = 0.5f;
  const io::RigWriter writer(path("rig"), description, false);
  io::LoadedFrame frame, back;
  frame.images.resize(2);
  frame.rig.views.assign(2, DepthView());
  for (std::size_t k = 0; k < 2; ++k) {
    io::LoadedView& images = frame.images[k];
    images.depth32.resize(4, 3);
    images.depth32.at(2, 1) = 1.2345678f;
    images.confidence.resize(4, 3);
    images.confidence.at(0, 2) = 0.1f;
    frame.rig.views[k].depth32 = images.depth32.view();
    frame.rig.views[k].confidence = images.confidence.view();
  }
  writer.write(3, frame);
  writer.finish();
  io::openRecording({path("rig")})->read(3, back);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(back.images[k].depth32.data, frame.images[k].depth32.data);
    EXPECT_EQ(back.images[k].confidence.data, frame.images[k].confidence.data);
  }
}

TEST_F(RigWriter, DepthInFloatIsOfCamerasWhoseUnitIsTheMetre) {
  const io::RigWriter writer(path("rig"), rig(), false);
  io::LoadedFrame frame;
  measure(frame);
  frame.images[0].depth32.resize(4, 3);
  frame.rig.views[0].depth16 = {};
  frame.rig.views[0].depth32 = frame.images[0].depth32.view();
  EXPECT_TRUE(
      refuses<io::OutputError>([&] { writer.write(0, frame); }, {path("rig/left/depth/000000.npy"), "must be 1"}));
}

TEST_F(RigWriter, OfACameraWithoutDepthColourAloneIsWritten) {
  io::RigDescription description = rig();
  for (io::RigCamera& entry : description.cameras) entry.has_depth_scale = false;
  const io::RigWriter writer(path("rig"), description, true);
  io::LoadedFrame frame, back;
  measure(frame);
  EXPECT_TRUE(refuses<io::OutputError>([&] { writer.write(0, frame); }, {"left/depth/000000.png", "no depth_scale"}));
  frame.rig.views[0].depth16 = {};
  writer.write(0, frame);
  writer.finish();
  EXPECT_FALSE(fs::exists(path("rig/left/depth")));
  const auto recording = io::openRecording({path("rig")});
  recording->read(0, back);
  EXPECT_FALSE(recording->hasDepth(0));
  EXPECT_TRUE(back.rig.views[0].missing());
  EXPECT_EQ(back.images[0].color.at(3, 2).b, 3);
  EXPECT_FALSE(back.rig.views[1].color);
}

TEST_F(RigWriter, AFolderThatCannotBeMadeIsNamed) {
  write("file", "");
  EXPECT_TRUE(refuses<io::OutputError>([&] { io::RigWriter(path("file/rig"), rig(), true); }, {path("file/rig")}));
}

}  // namespace
