#if defined(FUSE_FLOW_WITH_FASTCDR) && defined(FUSE_FLOW_WITH_STREAM)

#include "recordings/logs/message_log.h"
#include "recordings/messages/ros_messages.h"
#include "sinks/cloud_mcap_writer.h"

#include "../recordings/io_fixture.h"

#include <cstdlib>
#include <cstring>

namespace {

using namespace io_test;

class CloudMcap : public IoTest {
 protected:
  static constexpr std::int64_t kFirst = 1'700'000'000'000'000'007;

  /** \brief Point i of frame k is at (k, i, 2.5). */
  static stream::StreamedCloud cloud(int frame, int points, bool normals) {
    stream::StreamedCloud cloud;
    cloud.times = {static_cast<std::uint64_t>(frame), kFirst + frame * 100'000'000, 1};
    for (int i = 0; i < points; ++i) {
      for (const float value : {static_cast<float>(frame), static_cast<float>(i), 2.5f})
        cloud.positions.push_back(value);
      for (const int part : {10, 20, i % 256}) cloud.colors.push_back(static_cast<std::uint8_t>(part));
      cloud.confidence.push_back(51);
      cloud.view_counts.push_back(3);
      if (normals)
        for (const float value : {0.0f, 0.0f, 1.0f}) cloud.normals.push_back(value);
    }
    return cloud;
  }

  /** \brief Three clouds; from the third on a camera stands elsewhere. */
  void writeFile(const std::string& file, const std::string& compression) const {
    io::CloudMcapWriter writer(file, compression);
    stream::Description description;
    description.frame = "room";
    description.cameras.resize(2);
    description.cameras[0].name = "left eye";
    description.cameras[1].name = "left-eye";
    description.cameras[1].T_world_camera.translation() = Eigen::Vector3d(1, 2, 3);
    writer.describe(description);
    writer.write(cloud(0, 1000, false));
    writer.write(cloud(1, 0, false));
    description.cameras[1].T_world_camera.translation().x() = 9;
    writer.describe(description);
    writer.write(cloud(2, 300'000, true));
    writer.finish();
    EXPECT_EQ(writer.bytes(), fs::file_size(file));
  }
};

TEST_F(CloudMcap, IsReadBackAsItWasWritten) {
  for (const std::string compression : {"", "zstd"}) {
    SCOPED_TRACE(compression);
    writeFile(path("clouds.mcap"), compression);
    const auto log = io::openMcap(path("clouds.mcap"));
    EXPECT_TRUE(log->warnings().empty());
    ASSERT_EQ(log->topics().size(), 2u);
    const std::size_t points = *log->find("/points"), tf = *log->find("/tf_static");
    EXPECT_EQ(log->topics()[points].type, "sensor_msgs/PointCloud2");
    EXPECT_EQ(log->topics()[tf].times, (std::vector<io::Nanoseconds>{kFirst, kFirst + 200'000'000}));
    ASSERT_EQ(log->topics()[points].times.size(), 3u);
    for (int k = 0; k < 3; ++k) {
      SCOPED_TRACE(k);
      const std::uint32_t count = k == 0 ? 1000 : k == 1 ? 0 : 300'000, fields = k == 2 ? 9 : k == 1 ? 3 : 6;
      std::string bytes;
      log->read(points, static_cast<std::size_t>(k), bytes);
      const auto in = io::makeWireReader(io::Wire::Cdr, "cloud", bytes);
      const io::HeaderMessage header = io::readHeader(*in);
      EXPECT_EQ(header.stamp, kFirst + k * 100'000'000);
      EXPECT_EQ(header.stamp, log->topics()[points].times[static_cast<std::size_t>(k)]);
      EXPECT_EQ(header.frame, "room");
      EXPECT_EQ(in->u32(), 1u);
      EXPECT_EQ(in->u32(), count);
      ASSERT_EQ(in->u32(), fields);
      const char* const names[] = {"x",          "y",        "z",        "rgb",     "confidence",
                                   "view_count", "normal_x", "normal_y", "normal_z"};
      for (std::uint32_t field = 0; field < fields; ++field) {
        EXPECT_EQ(in->text(), names[field]);
        EXPECT_EQ(in->u32(), 4 * field);
        EXPECT_EQ(in->u8(), field == 5 ? 6 : 7);  // PointField's UINT32 or FLOAT32
        EXPECT_EQ(in->u32(), 1u);
      }
      EXPECT_EQ(in->u8(), 0);
      EXPECT_EQ(in->u32(), 4 * fields);
      EXPECT_EQ(in->u32(), 4 * fields * count);
      const std::string_view data = in->bytes();
      EXPECT_EQ(in->u8(), 1);
      ASSERT_EQ(data.size(), 4 * fields * count);
      const auto value = [&](std::size_t point, std::size_t field) {
        float number;
        std::memcpy(&number, data.data() + 4 * (point * fields + field), sizeof(number));
        return number;
      };
      for (std::size_t i = 0; i < count; i += 37) {
        ASSERT_EQ(value(i, 0), static_cast<float>(k));
        ASSERT_EQ(value(i, 1), static_cast<float>(i));
        ASSERT_EQ(value(i, 2), 2.5f);
        const char* color = data.data() + 4 * (i * fields + 3);
        ASSERT_EQ(static_cast<unsigned char>(color[0]), i % 256);
        ASSERT_EQ(color[1], 20);
        ASSERT_EQ(color[2], 10);
        ASSERT_EQ(value(i, 4), 0.2f);
        ASSERT_EQ(color[8], 3);
        if (k == 2) {
          ASSERT_EQ(value(i, 8), 1.0f);
        }
      }
    }
    std::string bytes;
    log->read(tf, 1, bytes);
    const auto in = io::makeWireReader(io::Wire::Cdr, "tf", bytes);
    const auto transforms = io::readTransforms(*in);
    ASSERT_EQ(transforms.size(), 2u);
    EXPECT_EQ(transforms[0].header.frame, "room");
    EXPECT_EQ(transforms[0].child, "left_eye");
    EXPECT_EQ(transforms[1].child, "left_eye_2");
    EXPECT_EQ(transforms[1].T_parent_child.translation(), Eigen::Vector3d(9, 2, 3));
  }
}

/** \brief read_clouds.cjs: @mcap/core, and messages by @foxglove/rosmsg2-serialization. */
TEST_F(CloudMcap, AnotherImplementationReadsIt) {
  const std::string packages =
      " @mcap/core@2 @foxglove/rosmsg@5 @foxglove/rosmsg2-serialization@3 @foxglove/wasm-zstd@1";
  std::string modules = path("node_modules");
  if (const char* given = std::getenv("FUSE_FLOW_TEST_NODE_MODULES"))
    modules = given;
  else if (std::system(("timeout 60 npm install --no-audit --no-fund --prefix '" + folder_.string() + "'" + packages +
                        " > '" + path("log") + "' 2>&1")
                           .c_str()) != 0)
    GTEST_SKIP() << "needs npm, and its registry for" << packages;
  writeFile(path("clouds.mcap"), "zstd");
  ASSERT_EQ(
      std::system(("NODE_PATH='" + modules + "' node " FUSE_FLOW_TEST_SOURCE_DIR "/test/apps/sinks/read_clouds.cjs '" +
                   path("clouds.mcap") + "' > '" + path("said") + "' 2> '" + path("log") + "'")
                      .c_str()),
      0);
  std::ifstream said(path("said"));
  const std::string text((std::istreambuf_iterator<char>(said)), {});
  const std::string last = " 1700000000.200000007 room ";
  EXPECT_EQ(text,
            "/tf_static 1700000000.000000007 room>left_eye:0 room>left_eye_2:1\n"
            "/points 1700000000.000000007 room 1000 x,y,z,rgb,confidence,view_count 0,999,2.5,10,20,231,0.20,3\n"
            "/points 1700000000.100000007 room 0 x,y,z\n"
            "/tf_static" +
                last.substr(0, 21) + " room>left_eye:0 room>left_eye_2:9\n/points" + last +
                "300000 x,y,z,rgb,confidence,view_count,normal_x,normal_y,normal_z 2,299999,2.5,10,20,223,0.20,3\n");
}

}  // namespace

#endif
