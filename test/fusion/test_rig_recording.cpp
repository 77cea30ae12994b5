#include "../simulated_recording.h"
#include "clouds/cloud_io.h"
#include "recordings/files/file_io.h"
#include "recordings/range.h"

#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/recordings/rig_writer.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace {

namespace fs = std::filesystem;
using namespace fuse_flow;

/** \brief A small recording of two frames in a folder of its own, removed afterwards. */
class RigRecording : public testing::Test {
 protected:
  static const std::vector<io::LoadedFrame>& frames() {
    static const std::vector<io::LoadedFrame> once = simulated_recording::frames(0.125, 2);
    return once;
  }
  static const std::vector<Camera>& cameras() { return frames()[0].rig.cameras; }

  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("fuse_flow_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    io::RigDescription rig{{}, 5.0};
    for (const Camera& camera : cameras()) rig.cameras.push_back({camera});
    const io::RigWriter writer(folder_.string(), rig, true);
    for (std::size_t frame = 0; frame < frames().size(); ++frame) writer.write(frame, frames()[frame]);
    writer.finish();
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path depthFile(std::size_t camera, const std::string& name) const {
    return folder_ / cameras()[camera].name / "depth" / name;
  }

  void replaceInJson(const std::string& before, const std::string& after) const {
    std::string text = io::readFile((folder_ / "rig.json").string());
    const std::size_t at = text.find(before);
    ASSERT_NE(at, std::string::npos) << before;
    text.replace(at, before.size(), after);
    io::writeFile((folder_ / "rig.json").string(), text);
  }

  /** \brief Opens and reads frame 0; what it throws is one line. */
  std::string messageOf() const {
    try {
      io::LoadedFrame loaded;
      io::openRecording({folder_.string()})->read(0, loaded);
    } catch (const io::InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(RigRecording, ReadsBackWhatWasWritten) {
  const auto recording = io::openRecording({folder_.string()});
  ASSERT_EQ(recording->frameCount(), 2u);
  EXPECT_EQ(recording->framesPerSecond(), 5.0);
  ASSERT_EQ(recording->cameras().size(), cameras().size());
  io::LoadedFrame loaded;
  recording->read(1, loaded);
  for (std::size_t i = 0; i < cameras().size(); ++i) {
    const io::LoadedView& written = frames()[1].images[i];
    EXPECT_TRUE(loaded.rig.cameras[i].T_world_camera.isApprox(cameras()[i].T_world_camera, 1e-9));
    ASSERT_TRUE(loaded.rig.views[i].depth16);
    ASSERT_TRUE(loaded.rig.views[i].color);
    for (int v = 0; v < 60; ++v)
      for (int u = 0; u < 80; ++u) {
        ASSERT_EQ(loaded.rig.views[i].depth16.row(v)[u], written.depth16.at(u, v));
        const Rgb8 color = loaded.rig.views[i].color.row(v)[u];
        ASSERT_EQ(color.r, written.color.at(u, v).r);
        ASSERT_EQ(color.g, written.color.at(u, v).g);
        ASSERT_EQ(color.b, written.color.at(u, v).b);
      }
  }
}

TEST_F(RigRecording, AMissingFileIsADroppedFrameOfThatCamera) {
  fs::remove(depthFile(1, "000000.png"));
  io::LoadedFrame loaded;
  io::openRecording({folder_.string()})->read(0, loaded);
  EXPECT_FALSE(loaded.rig.views[0].missing());
  EXPECT_TRUE(loaded.rig.views[1].missing());
}

TEST_F(RigRecording, ATruncatedDepthImageIsAnErrorThatNamesTheFile) {
  const std::string path = depthFile(2, "000000.png").string();
  fs::resize_file(path, fs::file_size(path) / 2);
  EXPECT_NE(messageOf().find(path), std::string::npos) << messageOf();
}

TEST_F(RigRecording, AnImageOfAnotherSizeIsAnErrorThatNamesTheFile) {
  replaceInJson("\"width\": 80", "\"width\": 81");
  EXPECT_NE(messageOf().find("000000.png"), std::string::npos) << messageOf();
}

TEST_F(RigRecording, ACameraWithoutAPoseIsAnErrorThatNamesTheKey) {
  replaceInJson("\"T_world_camera\"", "\"T_wrold_camera\"");
  EXPECT_NE(messageOf().find("T_world_camera"), std::string::npos) << messageOf();
}

TEST_F(RigRecording, AFocalLengthOfZeroIsAnErrorThatNamesIt) {
  const std::string text = io::readFile((folder_ / "rig.json").string());
  const std::size_t at = text.find("\"fx\": ");
  ASSERT_NE(at, std::string::npos);
  replaceInJson(text.substr(at, text.find(',', at) - at), "\"fx\": 0");
  EXPECT_NE(messageOf().find("fx"), std::string::npos) << messageOf();
}

TEST_F(RigRecording, TextThatIsNotJsonIsAnErrorThatNamesTheFile) {
  io::writeFile((folder_ / "rig.json").string(), "{\"cameras\": [");
  EXPECT_NE(messageOf().find("rig.json"), std::string::npos) << messageOf();
}

TEST_F(RigRecording, AnEmptyFolderIsAnErrorThatNamesIt) {
  fs::remove_all(folder_);
  fs::create_directory(folder_);
  EXPECT_NE(messageOf().find(folder_.string()), std::string::npos) << messageOf();
}

TEST_F(RigRecording, CloudsComeBackFromPlyAndPcd) {
  pcl::PointCloud<PointFused> cloud;
  PointFused point;
  point.x = 1.5f;
  point.z = -2.25f;
  point.confidence = 0.5f;
  point.view_count = 3;
  cloud.push_back(point);
  for (const char* name : {"cloud.ply", "cloud.pcd"}) {
    const std::string path = (folder_ / name).string();
    io::writeCloud(path, cloud);
    pcl::PointCloud<PointFused> back;
    io::readCloud(path, back);
    ASSERT_EQ(back.size(), 1u) << name;
    EXPECT_EQ(back[0].x, 1.5f) << name;
    EXPECT_EQ(back[0].z, -2.25f) << name;
    EXPECT_EQ(back[0].confidence, 0.5f) << name;
    EXPECT_EQ(back[0].view_count, 3u) << name;
  }
}

TEST_F(RigRecording, AnOutputThatCannotBeWrittenLeavesNothingBehind) {
  pcl::PointCloud<PointFused> cloud;
  cloud.emplace_back();
  EXPECT_THROW(io::writeCloud((folder_ / "no_such_folder" / "cloud.ply").string(), cloud), io::OutputError);
  EXPECT_FALSE(fs::exists(folder_ / "no_such_folder"));
}

TEST(Range, FollowsPython) {
  EXPECT_EQ(io::parseRange("0:100:20", 200), (std::vector<std::size_t>{0, 20, 40, 60, 80}));
  EXPECT_EQ(io::parseRange("3,1", 5), (std::vector<std::size_t>{3, 1}));
  EXPECT_THROW(io::parseRange("1:2:x", 5), io::InputError);
}

TEST(SevenScenes, NeedsToBeToldWhichFramesActAsCameras) {
  const std::string folder = FUSE_FLOW_TEST_SHARED_DATA "/seven_scenes";
  if (!fs::is_directory(folder)) GTEST_SKIP() << folder << " is not there";
  EXPECT_THROW(io::openRecording({folder}), io::InputError);
  io::RecordingOptions options;
  options.views = "0,60,120,180";
  EXPECT_EQ(io::openRecording({folder}, options)->cameras().size(), 4u);
}

}  // namespace
