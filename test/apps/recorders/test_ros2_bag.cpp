#if defined(FUSE_FLOW_WITH_FASTCDR) && defined(FUSE_FLOW_WITH_SQLITE) && defined(FUSE_FLOW_WITH_LZ4)

#include "recordings/files/checksum.h"
#include "recordings/files/file_io.h"
#include "recordings/messages/cdr_message.h"
#include "recordings/messages/image_messages.h"
#include "recordings/messages/rig_messages.h"
#include "recordings/read_ahead.h"

#include "../recordings/io_fixture.h"
#include "recorder_images.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>

#include <lz4frame.h>
#include <sqlite3.h>

namespace {

using namespace io_test;
using namespace recorder_test;

constexpr std::uint32_t kStart = 1'700'000'000, kPeriod = 33'333'333;  // seconds, nanoseconds

/** \brief A message that begins with a std_msgs/Header. */
io::CdrMessage& begin(io::CdrMessage& message, const std::string& frame, int k) {
  return message.header(io::Nanoseconds{kStart} * 1'000'000'000 + k * io::Nanoseconds{kPeriod}, frame);
}

std::string bytesOf(io::CdrMessage& message) { return std::string(message.view()); }

std::string imageMessage(const std::string& frame, int k, int width, int height, const std::string& encoding,
                         const std::vector<std::uint8_t>& data) {
  io::CdrMessage message;
  begin(message, frame, k) << static_cast<std::uint32_t>(height) << static_cast<std::uint32_t>(width) << encoding
                           << std::uint8_t{0}
                           << static_cast<std::uint32_t>(data.size() / static_cast<std::size_t>(height)) << data;
  return bytesOf(message);
}

std::string depthMessage(const std::string& frame, int c, int k) {
  std::vector<std::uint8_t> data;
  for (int v = 0; v < kDepthHeight; ++v)
    for (int u = 0; u < kDepthWidth; ++u) {
      data.push_back(static_cast<std::uint8_t>(depthAt(c, k, u, v) & 0xff));
      data.push_back(static_cast<std::uint8_t>(depthAt(c, k, u, v) >> 8));
    }
  return imageMessage(frame, k, kDepthWidth, kDepthHeight, "16UC1", data);
}

std::string infoMessage(const std::string& frame) {
  io::CdrMessage message;
  begin(message, frame, 0) << std::uint32_t{kDepthHeight} << std::uint32_t{kDepthWidth} << std::string("plumb_bob")
                           << std::vector<double>{0.1, -0.05, 0.001, -0.002, 0.01};
  for (const double k : {60.0, 0.0, 31.5, 0.0, 61.0, 23.5, 0.0, 0.0, 1.0}) message << k;
  for (int k = 0; k < 9; ++k) message << (k % 4 == 0 ? 1.0 : 0.0);
  for (const double p : {60.0, 0.0, 31.5, 0.0, 0.0, 61.0, 23.5, 0.0, 0.0, 0.0, 1.0, 0.0}) message << p;
  for (int k = 0; k < 6; ++k) message << std::uint32_t{0};  // binning and region
  message << false;
  return bytesOf(message);
}

std::string tfMessage(const std::vector<std::pair<std::string, double>>& frames) {
  io::CdrMessage message;
  message << static_cast<std::uint32_t>(frames.size());
  for (const auto& [child, x] : frames) {
    message << kStart << std::uint32_t{0} << std::string("world") << child;
    for (const double value : {x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0}) message << value;
  }
  return bytesOf(message);
}

/** \brief A message of a bag. */
struct Sent {
  std::string topic, type, bytes;
  int k;
};

/** \brief Two cameras at x = 1 and 2. */
std::vector<Sent> rig(int frames) {
  std::vector<Sent> sent{
      {"/tf_static", "tf2_msgs/msg/TFMessage", tfMessage({{"left_depth", 1}, {"right_depth", 2}}), 0},
      {"/left/depth/camera_info", "sensor_msgs/msg/CameraInfo", infoMessage("left_depth"), 0},
      {"/right/depth/camera_info", "sensor_msgs/msg/CameraInfo", infoMessage("right_depth"), 0}};
  for (int k = 0; k < frames; ++k) {
    sent.push_back({"/left/depth/image_raw", "sensor_msgs/msg/Image", depthMessage("left_depth", 0, k), k});
    sent.push_back({"/right/depth/image_raw", "sensor_msgs/msg/Image", depthMessage("right_depth", 1, k), k});
  }
  return sent;
}

std::int64_t timeOf(int k) { return std::int64_t{kStart} * 1'000'000'000 + k * std::int64_t{kPeriod}; }

/** \brief As ROS 2's recorder writes its tables. */
void writeSqlite(const std::string& file, const std::vector<Sent>& messages) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  const auto run = [&](const std::string& text) {
    ASSERT_EQ(sqlite3_exec(database, text.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << text;
  };
  run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
      "NOT NULL, "
      "offered_qos_profiles TEXT NOT NULL)");
  run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB "
      "NOT NULL)");
  std::vector<std::string> topics;
  for (const Sent& message : messages) {
    auto known = std::find(topics.begin(), topics.end(), message.topic);
    if (known == topics.end()) {
      topics.push_back(message.topic);
      known = topics.end() - 1;
      run("INSERT INTO topics VALUES(" + std::to_string(topics.size()) + ", '" + message.topic + "', '" + message.type +
          "', 'cdr', '')");
    }
    sqlite3_stmt* insert = nullptr;
    sqlite3_prepare_v2(database, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", -1, &insert,
                       nullptr);
    sqlite3_bind_int64(insert, 1, known - topics.begin() + 1);
    sqlite3_bind_int64(insert, 2, timeOf(message.k));
    sqlite3_bind_blob(insert, 3, message.bytes.data(), static_cast<int>(message.bytes.size()), SQLITE_STATIC);
    EXPECT_EQ(sqlite3_step(insert), SQLITE_DONE);
    sqlite3_finalize(insert);
  }
  sqlite3_close(database);
}

void number(std::string& to, std::uint64_t value, int bytes) {
  for (int k = 0; k < bytes; ++k) to += static_cast<char>(value >> (8 * k) & 0xff);
}
void text(std::string& to, const std::string& value) {
  number(to, value.size(), 4);
  to += value;
}
std::string record(int opcode, const std::string& content) {
  std::string bytes(1, static_cast<char>(opcode));
  number(bytes, content.size(), 8);
  return bytes + content;
}

/** \brief An MCAP file with a chunk for every so many messages, by LZ4, with their indices, and without the summary that a recorder writes last. */
std::string mcapOf(const std::vector<Sent>& messages, std::size_t chunk_size, bool close) {
  std::string file("\x89MCAP0\r\n", 8), header_content;
  text(header_content, "ros2");
  text(header_content, "a test");
  file += record(0x01, header_content);
  std::vector<std::string> topics;
  for (std::size_t begin = 0; begin < messages.size(); begin += chunk_size) {
    std::string records;
    std::map<std::size_t, std::string> index;
    for (std::size_t m = begin; m < std::min(begin + chunk_size, messages.size()); ++m) {
      const Sent& message = messages[m];
      auto known = std::find(topics.begin(), topics.end(), message.topic);
      if (known == topics.end()) {
        topics.push_back(message.topic);
        known = topics.end() - 1;
        std::string schema, channel;
        number(schema, topics.size(), 2);
        for (const std::string& part : {message.type, std::string("ros2msg"), std::string()}) text(schema, part);
        number(channel, topics.size(), 2);
        number(channel, topics.size(), 2);
        for (const std::string& part : {message.topic, std::string("cdr"), std::string()}) text(channel, part);
        records += record(0x03, schema) + record(0x04, channel);
      }
      const auto id = static_cast<std::size_t>(known - topics.begin() + 1);
      number(index[id], static_cast<std::uint64_t>(timeOf(message.k)), 8);
      number(index[id], records.size(), 8);
      std::string content;
      number(content, id, 2);
      number(content, 0, 4);
      for (int twice = 0; twice < 2; ++twice) number(content, static_cast<std::uint64_t>(timeOf(message.k)), 8);
      records += record(0x05, content + message.bytes);
    }
    std::string compressed(LZ4F_compressFrameBound(records.size(), nullptr), '\0');
    compressed.resize(
        LZ4F_compressFrame(compressed.data(), compressed.size(), records.data(), records.size(), nullptr));
    std::string chunk;
    number(chunk, 0, 8);
    number(chunk, 0, 8);
    number(chunk, records.size(), 8);
    number(chunk, io::crc32(records), 4);
    text(chunk, "lz4");
    number(chunk, compressed.size(), 8);
    file += record(0x06, chunk + compressed);
    for (const auto& [id, entries] : index) {
      std::string content;
      number(content, id, 2);
      text(content, entries);
      file += record(0x07, content);
    }
  }
  if (close)
    file += record(0x0f, std::string(4, '\0')) + record(0x02, std::string(20, '\0')) + std::string("\x89MCAP0\r\n", 8);
  return file;
}

class Ros2Bag : public IoTest {
 protected:
  static void expectRig(const std::vector<std::string>& inputs, std::size_t frames) {
    const auto recording = io::openRecording(inputs);
    ASSERT_EQ(recording->cameras().size(), 2u);
    EXPECT_EQ(recording->cameras()[0].name, "left");
    EXPECT_EQ(recording->cameras()[1].T_world_camera.translation().x(), 2);
    EXPECT_FLOAT_EQ(recording->cameras()[0].intrinsics.fy, 61);
    EXPECT_FLOAT_EQ(recording->cameras()[0].intrinsics.distortion.k1, 0.1f);
    ASSERT_EQ(recording->frameCount(), frames);
    io::LoadedFrame frame;
    for (std::size_t k = frames; k-- > 0;) {
      recording->read(k, frame);
      expectDepth(frame.images[0].depth16, 0, static_cast<int>(k));
      expectDepth(frame.images[1].depth16, 1, static_cast<int>(k));
    }
  }
};

TEST_F(Ros2Bag, Sqlite) {
  writeSqlite(path("rig.db3"), rig(4));
  expectRig({path("rig.db3")}, 4);
}

TEST_F(Ros2Bag, AFolderWithItsMetadataAndSeveralFiles) {
  const std::vector<Sent> all = rig(4);
  fs::create_directories(path("bag"));
  writeSqlite(path("bag/bag_0.db3"), std::vector<Sent>(all.begin(), all.begin() + 7));
  writeSqlite(path("bag/bag_1.db3"), std::vector<Sent>(all.begin() + 7, all.end()));
  expectRig({path("bag")}, 4);  // killed before it wrote this:
  write("bag/metadata.yaml",
        "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.db3\n    - bag_1.db3\n");
  expectRig({path("bag")}, 4);
  write("bag/metadata.yaml", "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.db3.zstd\n");
  EXPECT_TRUE(refuses([&] { io::openRecording({path("bag")}); }, {"bag_0.db3.zstd", "unzstd"}));
  write("bag/metadata.yaml", "rosbag2_bagfile_information: [\n");
  EXPECT_TRUE(refuses([&] { io::openRecording({path("bag")}); }, {"metadata.yaml"}));
}

TEST_F(Ros2Bag, McapByLz4) {
  for (const std::size_t chunk : {1u, 3u, 100u}) {
    write("rig.mcap", mcapOf(rig(4), chunk, true));
    expectRig({path("rig.mcap")}, 4);
  }
}

TEST_F(Ros2Bag, AnMcapFileThatWasNotClosedOrIsCutShortPlaysUpToThere) {
  const std::string whole = mcapOf(rig(6), 2, false);
  write("killed.mcap", whole);
  expectRig({path("killed.mcap")}, 6);
  EXPECT_NE(io::openRecording({path("killed.mcap")})->warnings()[0].find("was not closed"), std::string::npos);
  std::size_t frames_before = 6;
  for (std::size_t size = whole.size() - 1; size > whole.size() / 3; size -= 97) {
    write("cut.mcap", whole.substr(0, size));
    const auto recording = io::openRecording({path("cut.mcap")});
    EXPECT_LE(recording->frameCount(), frames_before);
    frames_before = recording->frameCount();
    io::LoadedFrame frame;
    for (const std::size_t k : recording->frames()) {
      recording->read(k, frame);
      if (!frame.rig.views[0].missing()) expectDepth(frame.images[0].depth16, 0, static_cast<int>(k));
    }
  }
  EXPECT_GE(frames_before, 1u);
}

// A file of 100 GB, of which nearly all are records of a kind that nobody knows, which are passed over; on the disk it is a hole.
TEST_F(Ros2Bag, AnMcapFileOf100GbIsReadAsASmallOne) {
  const std::string small = mcapOf(rig(6), 2, false);
  constexpr std::uint64_t hole = 20'000'000'000;
  const auto number = [&](std::size_t at) {
    std::uint64_t value = 0;
    for (std::size_t k = 8; k-- > 0;) value = value << 8 | static_cast<unsigned char>(small[at + k]);
    return value;
  };
  std::ofstream file(path("large.mcap"), std::ios::binary);
  file.write(small.data(), 8);  // the magic bytes
  std::size_t holes = 0;
  for (std::size_t at = 8; at + 9 <= small.size();) {
    const std::size_t size = 9 + static_cast<std::size_t>(number(at + 1));
    file.write(small.data() + at, static_cast<std::streamsize>(size));
    const bool chunk = small[at] == 0x06;
    at += size;
    if (!chunk || holes == 5) continue;
    ++holes;
    file.put(static_cast<char>(0x90));
    for (int k = 0; k < 8; ++k) file.put(static_cast<char>(hole >> (8 * k)));
    file.seekp(static_cast<std::streamoff>(hole - 1), std::ios::cur);
    file.put(0);
  }
  file.close();
  if (!file) GTEST_SKIP() << "no file of 100 GB can be made here";
  ASSERT_GE(holes, 2u);
  expectRig({path("large.mcap")}, 6);
}

TEST_F(Ros2Bag, DamagedBytesAreFoundOrRefused) {
  const std::string whole = mcapOf(rig(3), 3, true);
  for (std::size_t at = 8; at < whole.size(); at += 61) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    write("damaged.mcap", damaged);
    try {
      const auto recording = io::openRecording({path("damaged.mcap")});
      io::LoadedFrame frame;
      for (const std::size_t k : recording->frames()) {
        recording->read(k, frame);
        if (frame.rig.views[0].missing()) continue;  // never other pixels: a chunk has its checksum
        expectDepth(frame.images[0].depth16, 0, (frame.images[0].depth16.at(1, 0) - depthAt(0, 0, 1, 0)) / 11);
      }
    } catch (const io::InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
}

TEST_F(Ros2Bag, WhatIsNoBagIsRefusedInALine) {
  write("text.mcap", "no MCAP file");
  EXPECT_TRUE(refuses([&] { io::openRecording({path("text.mcap")}); }, {"text.mcap: is not an MCAP file"}));
  write("text.db3", std::string(5000, 'x'));
  EXPECT_TRUE(refuses([&] { io::openRecording({path("text.db3")}); }, {"text.db3: is damaged, or no bag of ROS 2"}));
  writeSqlite(path("nothing.db3"), {{"/chatter", "std_msgs/msg/String", std::string(io::CdrMessage().view()), 0}});
  EXPECT_TRUE(refuses([&] { io::openRecording({path("nothing.db3")}); },
                      {"has no images of a depth camera", "std_msgs/String"}));
}

/** \brief SQLite takes memory for a row before it reads it. Versions differ in what they say of one that cannot be. */
TEST_F(Ros2Bag, ARowThatIsLongerThanItsFileIsRefused) {
  std::vector<Sent> messages = rig(1);
  constexpr std::uint32_t padding =
      2'200'000;  // lengths of 4 bytes, SQLite's varints: 7 bits each, the first with the most
  messages[0].bytes += std::string(padding, '\0');
  writeSqlite(path("rig.db3"), messages);
  std::string bytes = io::readFile(path("rig.db3"));
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(bytes[k]); };
  std::size_t found = 0;
  for (std::size_t k = 0; k + 4 < bytes.size() && found == 0; ++k) {
    if (byte(k) < 128 || byte(k + 1) < 128 || byte(k + 2) < 128 || byte(k + 3) >= 128) continue;
    const std::uint32_t length =
        (byte(k) & 127u) << 21 | (byte(k + 1) & 127u) << 14 | (byte(k + 2) & 127u) << 7 | byte(k + 3);
    if (length > padding && length < padding + 2000 && byte(k + 4) == 1) found = k;  // and the first row's number
  }
  ASSERT_GT(found, 0u);
  bytes[found] = '\xff';  // some 266 MB
  write("long.db3", bytes);
  EXPECT_TRUE(refuses([&] { io::openRecording({path("long.db3")}); }, {"long.db3: is damaged, or no bag of ROS 2"}));
  write("rig_again.db3", io::readFile(path("rig.db3")));
  EXPECT_NO_THROW(io::openRecording({path("rig_again.db3")}));
}

TEST_F(Ros2Bag, ADepthTopicWithoutItsCameraInfoIsRefused) {
  std::vector<Sent> messages = rig(2);
  messages.erase(messages.begin() + 1);
  writeSqlite(path("rig.db3"), messages);
  EXPECT_TRUE(refuses([&] { io::openRecording({path("rig.db3")}); },
                      {"there is no CameraInfo for /left/depth/image_raw, must be at /left/depth/camera_info"}));
}

TEST_F(Ros2Bag, AnImageOfAnotherSizeOrTooShortIsDamaged) {
  std::vector<Sent> messages = rig(3);
  messages[5].bytes = imageMessage("left_depth", 1, 4, 4, "16UC1", std::vector<std::uint8_t>(32));
  messages[8].bytes.resize(200);
  writeSqlite(path("rig.db3"), messages);
  io::RecordingOptions options;
  options.skip_damaged = true;
  const auto recording = io::openRecording({path("rig.db3")}, options);
  io::LoadedFrame frame;
  recording->read(1, frame);
  ASSERT_EQ(frame.damaged.size(), 1u);
  EXPECT_NE(frame.damaged[0].message.find("is 4x4 pixels, its camera is calibrated for 64x48"), std::string::npos);
  expectDepth(frame.images[1].depth16, 1, 1);
  recording->read(2, frame);
  ASSERT_EQ(frame.damaged.size(), 1u);
  EXPECT_NE(frame.damaged[0].message.find("is too short"), std::string::npos);
  const auto strict = io::openRecording({path("rig.db3")});
  EXPECT_TRUE(refuses([&] { strict->read(1, frame); }, {"rig.db3", "/left/depth/image_raw"}));
}

TEST_F(Ros2Bag, StampsThatJumpBackAreLeftOutAndCounted) {
  std::vector<Sent> messages = rig(4);
  messages[7].bytes = depthMessage("left_depth", 0, 0);  // the third has the first one's time
  writeSqlite(path("rig.db3"), messages);
  const auto recording = io::openRecording({path("rig.db3")});
  ASSERT_EQ(recording->warnings().size(), 1u);
  EXPECT_NE(recording->warnings()[0].find("/left/depth/image_raw: 1 of 4 images have a time stamp that is not later"),
            std::string::npos);
  io::LoadedFrame frame;
  recording->read(2, frame);
  EXPECT_TRUE(frame.rig.views[0].missing());
  expectDepth(frame.images[1].depth16, 1, 2);
}

/** \brief The rig of a rig.json with colour beside depth, and one image of each camera and frame. */
struct WrittenRig {
  std::vector<Camera> cameras{2};
  io::LoadedFrame frame;

  WrittenRig() {
    cameras[0].name = "left";
    cameras[0].intrinsics = {
        kDepthWidth, kDepthHeight, 60, 61, 31.5f, 23.5f, {0.1f, -0.05f, 0.001f, -0.002f, 0.01f, 0.2f, 0, 0}};
    cameras[0].T_world_camera = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY());
    cameras[0].color = ColorCamera();
    cameras[0].color->intrinsics = {kColorWidth, kColorHeight, 70, 71, 39.5f, 29.5f, {}};
    cameras[0].color->T_depth_color = Eigen::Translation3d(0.03, 0, 0);
    cameras[1].name = "right-2";  // no name in ROS
    cameras[1].intrinsics = {kDepthWidth, kDepthHeight, 60, 60, 31.5f, 23.5f, {}};
    cameras[1].depth_scale = 0.0005f;
    frame.rig.cameras = cameras;
    frame.rig.views.resize(2);
    frame.images.resize(2);
  }
  /** \brief The right camera loses the second frame. */
  void make(int k) {
    for (int c = 0; c < 2; ++c) {
      io::DepthImage& depth = frame.images[static_cast<std::size_t>(c)].depth16;
      frame.rig.views[static_cast<std::size_t>(c)] = {};
      depth = {};
      if (c == 1 && k == 1) continue;
      depth.resize(kDepthWidth, kDepthHeight);
      for (int v = 0; v < kDepthHeight; ++v)
        for (int u = 0; u < kDepthWidth; ++u) depth.at(u, v) = depthAt(c, k, u, v);
      depth.at(3, 1) = 65535;
      frame.rig.views[static_cast<std::size_t>(c)].depth16 = depth.view();
    }
    io::ColorImage& color = frame.images[0].color;
    color.resize(kColorWidth, kColorHeight);
    for (int v = 0; v < kColorHeight; ++v)
      for (int u = 0; u < kColorWidth; ++u)
        color.at(u, v) = {static_cast<std::uint8_t>(3 * u), static_cast<std::uint8_t>(4 * v), 100};
    frame.rig.views[0].color = color.view();
  }
  void write(const std::string& file, const std::string& compression, int frames, bool finish) {
    io::RigMessages::Options options;
    options.compression = compression;
    io::RigMessages messages(file, cameras, {true, false}, options);
    ASSERT_EQ(messages.warnings().size(), 1u);
    EXPECT_NE(messages.warnings()[0].find("'right-2' is not in millimetres"), std::string::npos);
    for (int k = 0; k < frames; ++k) {
      make(k);
      messages.write(timeOf(k), frame);
    }
    if (finish) messages.finish();
  }
};

TEST_F(Ros2Bag, WhatIsWrittenReadsBackTheSame) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    SCOPED_TRACE(compression);
    WrittenRig rig;
    rig.write(path("rig.mcap"), compression, 5, true);
    const auto recording = io::openRecording({path("rig.mcap")});
    EXPECT_TRUE(recording->warnings().empty()) << recording->warnings()[0];
    ASSERT_EQ(recording->cameras().size(), 2u);
    const Camera& left = recording->cameras()[0];
    EXPECT_EQ(left.name, "left");
    EXPECT_EQ(recording->cameras()[1].name, "right_2");
    EXPECT_TRUE(left.T_world_camera.isApprox(rig.cameras[0].T_world_camera, 1e-12));
    EXPECT_FLOAT_EQ(left.intrinsics.distortion.k4, 0.2f);
    EXPECT_FLOAT_EQ(left.intrinsics.fy, 61);
    ASSERT_TRUE(left.color);
    EXPECT_TRUE(left.color->T_depth_color.isApprox(rig.cameras[0].color->T_depth_color, 1e-12));
    EXPECT_EQ(recording->frameCount(), 5u);
    io::LoadedFrame frame;
    for (int k = 0; k < 5; ++k) {
      recording->read(static_cast<std::size_t>(k), frame);
      rig.make(k);
      EXPECT_EQ(frame.images[0].depth16.data, rig.frame.images[0].depth16.data);
      EXPECT_EQ(frame.rig.views[1].missing(), k == 1);
      if (k != 1) {
        EXPECT_FLOAT_EQ(frame.images[1].depth32.at(5, 9), static_cast<float>(depthAt(1, k, 5, 9)) * 0.0005f);
        EXPECT_EQ(frame.images[1].depth32.at(3, 1), 0);
      }
      EXPECT_NEAR(frame.images[0].color.at(40, 30).r, 120, 4);  // by JPEG
      EXPECT_NEAR(frame.images[0].color.at(40, 30).b, 100, 4);
      EXPECT_EQ(frame.rig.stamp, static_cast<std::uint64_t>(timeOf(k) / 1000));
    }
  }
}

TEST_F(Ros2Bag, AWriterThatIsKilledLeavesAFileThatPlaysUpToItsLastChunk) {
  WrittenRig rig;
  rig.write(path("killed.mcap"), "", 700, false);  // some 15 kB a frame: two chunks, and the beginning of a third
  const auto recording = io::openRecording({path("killed.mcap")});
  EXPECT_NE(recording->warnings()[0].find("was not closed"), std::string::npos);
  EXPECT_GT(recording->frameCount(), 400u);
  EXPECT_LT(recording->frameCount(), 700u);
}

TEST_F(Ros2Bag, SeveralThreadsReadTheSameFramesInTheirOrder) {
  for (const char* compression : {"", "lz4"}) {
    WrittenRig rig;
    rig.write(path("rig.mcap"), compression, 40, true);
    const auto recording = io::openRecording({path("rig.mcap")});
    ASSERT_TRUE(recording->readsConcurrently());
    io::ReadAhead ahead(*recording, recording->frames(), 4);
    io::LoadedFrame frame;
    for (int k = 0; k < 40; ++k) {
      ahead.next(frame);
      rig.make(k);
      EXPECT_EQ(frame.images[0].depth16.data, rig.frame.images[0].depth16.data) << k;
    }
  }
}

TEST_F(Ros2Bag, DamagedBytesOfPlainChunksEndInALineToo) {
  WrittenRig rig;
  rig.write(path("rig.mcap"), "", 2, true);
  std::ifstream file(path("rig.mcap"), std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(file)), {});
  for (std::size_t at = 8; at < whole.size(); at += 131) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0xff);
    write("damaged.mcap", damaged);
    try {
      const auto recording = io::openRecording({path("damaged.mcap")});
      io::LoadedFrame frame;
      for (const std::size_t k : recording->frames()) recording->read(k, frame);
    } catch (const io::InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
}

/** \brief Five frames, a chunk for each; in that of frame 2 the lowest bit of a byte of an image is another. */
std::string withDamagedImage(const std::string& bytes) {
  std::string damaged = bytes;
  std::uint64_t length = 0;
  std::size_t record = 8;  // behind the magic bytes
  for (int chunks = 0;; record += 9 + length) {
    std::memcpy(&length, bytes.data() + record + 1, sizeof length);
    if (bytes[record] == 0x06 && ++chunks == 3) break;
  }
  char& byte = damaged[record + 9 + length - 30];
  byte = static_cast<char>(byte ^ 1);
  return damaged;
}

TEST_F(Ros2Bag, ADamagedByteOfAnImageIsNoImage) {
  WrittenRig rig;
  {
    io::RigMessages messages(path("rig.mcap"), rig.cameras, {true, false}, {});
    for (int k = 0; k < 5; ++k) {
      rig.make(k);
      messages.write(timeOf(k), rig.frame);
      messages.flush();
    }
    messages.finish();
  }
  std::ifstream file(path("rig.mcap"), std::ios::binary);
  write("damaged.mcap", withDamagedImage(std::string(std::istreambuf_iterator<char>(file), {})));
  const auto recording = io::openRecording({path("damaged.mcap")});
  ASSERT_EQ(recording->frameCount(), 5u);
  io::LoadedFrame frame;
  for (const int k : {0, 1, 3, 4}) {
    recording->read(static_cast<std::size_t>(k), frame);
    rig.make(k);
    EXPECT_EQ(frame.images[0].depth16.data, rig.frame.images[0].depth16.data) << k;
  }
  for (int again = 0; again < 2; ++again)
    EXPECT_TRUE(refuses([&] { recording->read(2, frame); }, {"damaged.mcap: the chunk at byte", "is damaged"}));
  io::RecordingOptions skip;
  skip.skip_damaged = true;
  io::openRecording({path("damaged.mcap")}, skip)->read(2, frame);
  EXPECT_EQ(frame.damaged.size(), 2u);  // both cameras' images are in that chunk
  EXPECT_TRUE(frame.rig.views[0].missing());
  EXPECT_TRUE(frame.rig.views[1].missing());
}

TEST_F(Ros2Bag, AFullDiskAndTwoCamerasOfOneNameAreErrors) {
  WrittenRig rig;
  if (fs::exists("/dev/full")) {
    EXPECT_TRUE(refuses<io::OutputError>([&] { rig.write("/dev/full", "", 1, true); },
                                         {"/dev/full: cannot be written", "nothing of it can be read"}));
  }
  rig.cameras[1].name = "left";
  EXPECT_TRUE(refuses<io::OutputError>(
      [&] {
        io::RigMessages(path("a.mcap"), rig.cameras, {false, false}, {});
      },
      {"two cameras", "'left'"}));
}

TEST(Rvl, OfAnyImageIsWhatItWas) {
  std::uint32_t state = 7;
  for (const int kind : {0, 1, 2, 3}) {
    io::DepthImage image;
    image.resize(61, 37);
    for (std::uint16_t& z : image.data) {
      state = state * 1664525u + 1013904223u;
      const std::uint32_t random = state >> 16;
      z = static_cast<std::uint16_t>(kind == 0    ? 0
                                     : kind == 1  ? random
                                     : kind == 2  ? 1000 + random % 5
                                     : random % 3 ? 0
                                                  : random);
    }
    std::string data(12, '\0');
    for (const std::uint32_t side : {61u, 37u}) data.append(reinterpret_cast<const char*>(&side), 4);
    data += io::encodeRvl(image);
    io::CompressedImageMessage message;
    message.format = "16UC1; compressedDepth rvl";
    message.data = data;
    io::LoadedView view;
    io::decodeDepth("image", message, view);
    EXPECT_EQ(view.depth16.data, image.data) << kind;
  }
}

/** \brief The files that write_mcap.cjs writes with @mcap/core and messages by @foxglove/rosmsg2-serialization. */
TEST_F(Ros2Bag, McapFilesOfAnotherImplementation) {
  const std::string packages =
      " @mcap/core@2 @foxglove/rosmsg@5 @foxglove/rosmsg2-serialization@3 @foxglove/rosmsg-msgs-common@3 "
      "@foxglove/wasm-zstd@1";
  const std::string quiet = " > '" + path("log") + "' 2>&1";
  std::string modules = path("node_modules");
  if (const char* given = std::getenv("FUSE_FLOW_TEST_NODE_MODULES"))
    modules = given;
  else if (std::system(
               ("timeout 60 npm install --no-audit --no-fund --prefix '" + folder_.string() + "'" + packages + quiet)
                   .c_str()) != 0)
    GTEST_SKIP() << "needs npm, and its registry for" << packages;
  ASSERT_EQ(std::system(("NODE_PATH='" + modules +
                         "' node " FUSE_FLOW_TEST_SOURCE_DIR "/test/apps/recorders/write_mcap.cjs '" +
                         folder_.string() + "'" + quiet)
                            .c_str()),
            0);
  for (const char* name : {"unchunked.mcap", "plain.mcap", "zstd.mcap", "unindexed.mcap"}) {
    SCOPED_TRACE(name);
    const auto recording = io::openRecording({path(name)});
    EXPECT_TRUE(recording->warnings().empty()) << recording->warnings()[0];
    ASSERT_EQ(recording->cameras().size(), 2u);
    const Camera& left = recording->cameras()[0];
    EXPECT_FLOAT_EQ(left.intrinsics.distortion.k6, 0.004f);  // rational_polynomial
    ASSERT_TRUE(left.color);
    EXPECT_LT((left.color->T_depth_color.translation() - Eigen::Vector3d(0.03, 0, 0)).norm(), 1e-9);
    ASSERT_EQ(recording->frameCount(), 5u);
    io::LoadedFrame frame;
    for (const int k : {0, 1, 2, 3, 4, 0}) {
      recording->read(static_cast<std::size_t>(k), frame);
      expectDepth(frame.images[0].depth16, 0, k);
      expectDepth(frame.images[1].depth16, 1, k);
      expectColor(frame.images[0].color, 0, k);
    }
  }

  // And it reads ours.
  WrittenRig rig;
  rig.write(path("ours.mcap"), "zstd", 3, true);
  ASSERT_EQ(std::system(("NODE_PATH='" + modules +
                         "' node " FUSE_FLOW_TEST_SOURCE_DIR "/test/apps/recorders/read_mcap.cjs '" +
                         path("ours.mcap") + "' > '" + path("said") + "'" + " 2> '" + path("log") + "'")
                            .c_str()),
            0);
  std::ifstream said(path("said"));
  const std::string text((std::istreambuf_iterator<char>(said)), {});
  const std::string last = std::to_string(timeOf(2));
  EXPECT_EQ(
      text,
      "/left/color/camera_info sensor_msgs/msg/CameraInfo 1 " + std::to_string(timeOf(0)) + " 80x60 plumb_bob 70\n" +
          "/left/color/image_raw/compressed sensor_msgs/msg/CompressedImage 3 " + last +
          " left_color rgb8; jpeg compressed bgr8 true\n" + "/left/depth/camera_info sensor_msgs/msg/CameraInfo 1 " +
          std::to_string(timeOf(0)) + " 64x48 rational_polynomial 60\n" +
          "/left/depth/image_raw/compressedDepth sensor_msgs/msg/CompressedImage 3 " + last +
          " left_depth 16UC1; compressedDepth rvl true\n" + "/right_2/depth/camera_info sensor_msgs/msg/CameraInfo 1 " +
          std::to_string(timeOf(0)) + " 64x48 plumb_bob 60\n" + "/right_2/depth/image_raw sensor_msgs/msg/Image 2 " +
          last + " right_2_depth 32FC1 true\n" + "/tf_static tf2_msgs/msg/TFMessage 1 " + std::to_string(timeOf(0)) +
          " world>left_depth:1,left_depth>left_color:0.03,world>right_2_depth:0\n");
}

}  // namespace

#endif
