#include "recordings/readers/view_files.h"

#include "../tools/support/png_file.h"
#include "io_fixture.h"

#include <algorithm>
#include <vector>

namespace {

using namespace io_test;

class ViewFiles : public IoTest {
 protected:
  ViewFiles() {
    camera_.name = "left";
    camera_.intrinsics.width = 4;
    camera_.intrinsics.height = 3;
  }

  std::string depth(int width, int height) const {
    return write(
        "depth.png",
        tool_test::depthPng(width, height, std::vector<std::uint16_t>(static_cast<std::size_t>(width * height), 9)));
  }
  std::string color(int width, int height) const {
    return write("color.png", tool_test::colorPng(width, height, 1, 2, 3));
  }
  std::string confidence(int width, int height) const {
    return write(
        "confidence.png",
        tool_test::samplesPng(width, height, 8, 0, std::string(static_cast<std::size_t>(width * height), '\xff')));
  }
  void load(const io::ViewFiles& files) { io::loadView(files, camera_, std::nullopt, images_, view_); }

  Camera camera_;
  io::LoadedView images_;
  DepthView view_;
};

TEST_F(ViewFiles, WhatIsThereIsRead) {
  load({depth(4, 3), color(4, 3), confidence(4, 3)});
  EXPECT_EQ(view_.width(), 4);
  EXPECT_EQ(view_.height(), 3);
  EXPECT_EQ(view_.depth16.row(2)[3], 9);
  EXPECT_EQ(view_.color.row(2)[3].b, 3);
  EXPECT_EQ(view_.confidence.row(2)[3], 1.0f);
}

TEST_F(ViewFiles, AnImageThatClaimsAnotherSizeIsNotDecoded) {
  const std::string nothing = tool_test::pngChunk("IDAT", "nothing");
  const std::string rgb = write("rgb.png", tool_test::png(tool_test::pngHeader(20000, 20000, 8, 2) + nothing));
  const std::string grey = write("grey.png", tool_test::png(tool_test::pngHeader(20000, 20000, 16, 0) + nothing));
  const std::vector<std::string> words{"20000x20000", "'left' is calibrated for 4x3"};
  EXPECT_TRUE(refuses([&] { load({grey, "", ""}); }, words));
  EXPECT_TRUE(refuses([&] { load({depth(4, 3), rgb, ""}); }, words));
  EXPECT_TRUE(refuses([&] { load({depth(4, 3), "", grey}); }, words));
}

TEST_F(ViewFiles, WithoutDepthTheViewIsMissingWhateverElseIsThere) {
  load({path("no.png"), color(4, 3), confidence(4, 3)});
  EXPECT_TRUE(view_.missing());
  EXPECT_FALSE(view_.color);
}

TEST_F(ViewFiles, ColorOfTheFrameBeforeDoesNotStay) {
  load({depth(4, 3), color(4, 3), confidence(4, 3)});
  load({depth(4, 3), "", path("no.png")});
  EXPECT_FALSE(view_.missing());
  EXPECT_FALSE(view_.color);
  EXPECT_FALSE(view_.confidence);
}

TEST_F(ViewFiles, AnImageOfAnotherSizeIsNamedWithBothSizes) {
  EXPECT_TRUE(refuses([&] { load({depth(3, 4), "", ""}); }, {path("depth.png"), "left", "3x4", "4x3"}));
  EXPECT_TRUE(refuses([&] { load({depth(4, 3), color(3, 4), ""}); }, {path("color.png"), "left", "3x4", "4x3"}));
  EXPECT_TRUE(refuses([&] { load({depth(4, 3), "", confidence(3, 4)}); }, {path("confidence.png"), "3x4", "4x3"}));
}

TEST_F(ViewFiles, ADamagedFileIsSkippedWhereThatIsWanted) {
  io::LoadedFrame frame;
  frame.rig.cameras.assign(2, camera_);
  frame.rig.views.resize(2);
  frame.images.resize(2);
  const io::ViewFiles whole{depth(4, 3), "", ""}, damaged{whole.depth, write("cut.png", "x"), ""};
  const auto load_both = [&](std::size_t view) {
    io::loadView(view == 0 ? whole : damaged, camera_, std::nullopt, frame.images[view], frame.rig.views[view]);
  };
  for (const int threads : {1, 2}) {
    frame.damaged.clear();
    io::RecordingOptions options;
    options.threads = threads;
    options.skip_damaged = true;
    io::ViewLoading(options).load(2, load_both, frame);
    EXPECT_FALSE(frame.rig.views[0].missing());
    EXPECT_TRUE(frame.rig.views[1].missing());
    ASSERT_EQ(frame.damaged.size(), 1u);
    EXPECT_EQ(frame.damaged[0].view, 1u);
    EXPECT_NE(frame.damaged[0].message.find("cut.png"), std::string::npos) << frame.damaged[0].message;
    options.skip_damaged = false;
    EXPECT_TRUE(refuses([&] { io::ViewLoading(options).load(2, load_both, frame); }, {path("cut.png")}));
  }
}

TEST_F(ViewFiles, EachCameraIsInOnePartAndPartsAreRows) {
  for (const int parts : {1, 2, 3, 7})
    for (const std::size_t cameras : {1, 2, 5, 12}) {
      int before = 0;
      std::vector<int> in_part(static_cast<std::size_t>(parts), 0);
      for (std::size_t camera = 0; camera < cameras; ++camera) {
        int found = -1;
        for (int part = 0; part < parts; ++part) {
          if (!io::isInPart(camera, cameras, part, parts)) continue;
          EXPECT_EQ(found, -1) << "in two";
          found = part;
        }
        ASSERT_GE(found, before) << camera << " of " << cameras << " in " << parts;
        ++in_part[static_cast<std::size_t>(before = found)];
      }
      const auto [least, most] = std::minmax_element(in_part.begin(), in_part.end());
      EXPECT_LE(*most - *least, 1);
    }
}

TEST_F(ViewFiles, AProcessReadsTheCamerasOfItsPart) {
  io::LoadedFrame frame;
  frame.rig.views.resize(5);
  frame.images.resize(5);
  std::vector<int> read_by(5, -1);
  io::FloatImage image;
  image.resize(4, 3);
  for (int part = 0; part < 2; ++part) {
    for (fuse_flow::DepthView& view : frame.rig.views) view.depth32 = image.view();  // of the frame before
    io::RecordingOptions options;
    options.part = part;
    options.parts = 2;
    io::ViewLoading(options).load(
        5,
        [&](std::size_t view) {
          EXPECT_EQ(read_by[view], -1) << "by two";
          read_by[view] = part;
        },
        frame);
    for (std::size_t view = 0; view < 5; ++view) EXPECT_EQ(frame.rig.views[view].missing(), (view < 2) != (part == 0));
  }
  EXPECT_EQ(read_by, (std::vector<int>{0, 0, 1, 1, 1}));
}

TEST_F(ViewFiles, AColorCameraHasASizeOfItsOwn) {
  camera_.color = ColorCamera();
  camera_.color->intrinsics.width = 8;
  camera_.color->intrinsics.height = 5;
  load({depth(4, 3), color(8, 5), ""});
  EXPECT_EQ(view_.color.width, 8);
  EXPECT_TRUE(refuses([&] { load({depth(4, 3), color(4, 3), ""}); }, {path("color.png"), "left color", "4x3", "8x5"}));
}

TEST_F(ViewFiles, FramesAreNumberedWithSixDigits) {
  EXPECT_EQ(io::frameStem(0), "000000");
  EXPECT_EQ(io::frameStem(42), "000042");
  EXPECT_EQ(io::frameStem(999999), "999999");
  EXPECT_EQ(io::frameStem(1234567), "1234567");
}

TEST_F(ViewFiles, ColorIsFoundAsPngOrJpeg) {
  EXPECT_EQ(io::findImage(folder_.string(), "000001"), "");
  const std::string jpeg = write("000001.jpeg", "");
  EXPECT_EQ(io::findImage(folder_.string(), "000001"), jpeg);
  const std::string jpg = write("000001.jpg", "");
  EXPECT_EQ(io::findImage(folder_.string(), "000001"), jpg);
  const std::string png = write("000001.png", "");
  EXPECT_EQ(io::findImage(folder_.string(), "000001"), png);
}

}  // namespace
