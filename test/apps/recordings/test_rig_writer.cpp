
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

TEST_F(RigWriter, AFolderThatCannotBeMadeIsNamed) {
  write("file", "");
  EXPECT_TRUE(refuses<io::OutputError>([&] { io::RigWriter(path("file/rig"), rig(), true); }, {path("file/rig")}));
}

}  // namespace
