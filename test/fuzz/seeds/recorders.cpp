#include "../scratch.h"
#include "../seeds.h"
#include "small_images.h"

#include "recordings/files/file_io.h"
#include "recordings/logs/message_log.h"
#include "recordings/messages/rig_messages.h"

#include "../../apps/recordings/images/float_files.h"

#ifdef FUSE_FLOW_WITH_LIBAV
#include "../../apps/recorders/mkv_tracks.h"
#endif
#ifdef FUSE_FLOW_WITH_SQLITE
#include <sqlite3.h>
#endif

#include <algorithm>

namespace fuse_flow_fuzz {
namespace {

using io_test::rawBytes;

constexpr std::uint32_t kStart = 1'700'000'000;  // seconds

std::string rosText(const std::string& value) { return rawBytes(static_cast<std::uint32_t>(value.size())) + value; }

// ---- ROS 1, of which no library here writes messages

std::string rosHeader(std::uint32_t number, const std::string& frame) {
  return rawBytes(number) + rawBytes(kStart + number) + rawBytes(std::uint32_t{0}) + rosText(frame);
}

std::string rosImage(std::uint32_t number, const std::string& encoding, std::uint32_t bytes_per_pixel) {
  return rosHeader(number, "left_depth") + rawBytes(std::uint32_t{kHeight}) + rawBytes(std::uint32_t{kWidth}) +
         rosText(encoding) + '\0' + rawBytes(bytes_per_pixel * kWidth) +
         rosText(std::string(bytes_per_pixel * kWidth * kHeight, '\x04'));
}

/** \brief All pixels are 0, in one run. */
std::string rvlImage() {
  const std::string config(12, '\0');
  return rosHeader(0, "left_depth") + rosText("16UC1; compressedDepth rvl") +
         rosText(config + rawBytes(std::uint32_t{kWidth}) + rawBytes(std::uint32_t{kHeight}) +
                 rawBytes(std::uint32_t{0x8e000000}));
}

std::string cameraInfo() {
  std::string message = rosHeader(0, "left_depth") + rawBytes(std::uint32_t{kHeight}) +
                        rawBytes(std::uint32_t{kWidth}) + rosText("plumb_bob") + rawBytes(std::uint32_t{5});
  for (const double d : {0.1, -0.05, 0.001, -0.002, 0.01}) message += rawBytes(d);
  for (const double k : {10.0, 0.0, 3.5, 0.0, 10.0, 2.5, 0.0, 0.0, 1.0}) message += rawBytes(k);
  for (int k = 0; k < 9; ++k) message += rawBytes(k % 4 == 0 ? 1.0 : 0.0);
  for (const double p : {10.0, 0.0, 3.5, 0.0, 0.0, 10.0, 2.5, 0.0, 0.0, 0.0, 1.0, 0.0}) message += rawBytes(p);
  for (int k = 0; k < 6; ++k) message += rawBytes(std::uint32_t{0});  // binning and region
  return message + '\0';
}

std::string transforms() {
  std::string message = rawBytes(std::uint32_t{2});
  for (const char* child : {"left_depth", "right_depth"}) {
    message += rosHeader(0, "world") + rosText(child);
    for (const double value : {0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0}) message += rawBytes(value);
  }
  return message;
}

std::string field(const std::string& name, const std::string& value) { return rosText(name + "=" + value); }

std::string bagRecord(const std::string& fields, const std::string& data) { return rosText(fields) + rosText(data); }

/** \brief One chunk, not compressed, with its index. */
std::string rosBag() {
  struct Sent {
    std::string topic, type, bytes;
  };
  const std::vector<Sent> all{{"/tf_static", "tf2_msgs/TFMessage", transforms()},
                              {"/left/depth/camera_info", "sensor_msgs/CameraInfo", cameraInfo()},
                              {"/left/depth/image_raw", "sensor_msgs/Image", rosImage(0, "16UC1", 2)},
                              {"/left/color/camera_info", "sensor_msgs/CameraInfo", cameraInfo()},
                              {"/left/color/image_raw", "sensor_msgs/Image", rosImage(0, "rgb8", 3)}};
  const auto op = [](char code) { return field("op", std::string(1, code)); };
  const std::string time = rawBytes(kStart) + rawBytes(std::uint32_t{0});
  std::string connections, chunk, index, counts;
  for (std::uint32_t c = 0; c < all.size(); ++c) {
    const std::string number = field("conn", rawBytes(c));
    const std::string connection =
        bagRecord(op(7) + number + field("topic", all[c].topic),
                  field("topic", all[c].topic) + field("type", all[c].type) + field("md5sum", std::string(32, '0')) +
                      field("message_definition", ""));
    connections += connection;
    chunk += connection;
    index += bagRecord(
        op(4) + field("ver", rawBytes(std::uint32_t{1})) + number + field("count", rawBytes(std::uint32_t{1})),
        time + rawBytes(static_cast<std::uint32_t>(chunk.size())));
    counts += rawBytes(c) + rawBytes(std::uint32_t{1});
    chunk += bagRecord(op(2) + number + field("time", time), all[c].bytes);
  }
  const std::string magic = "#ROSBAG V2.0\n";
  const std::string chunk_record = bagRecord(op(5) + field("compression", "none") +
                                                 field("size", rawBytes(static_cast<std::uint32_t>(chunk.size()))),
                                             chunk) +
                                   index;
  const auto count = static_cast<std::uint32_t>(all.size());
  const auto begin = [&](std::uint64_t index_at) {
    const std::string fields = op(3) + field("index_pos", rawBytes(index_at)) + field("conn_count", rawBytes(count)) +
                               field("chunk_count", rawBytes(std::uint32_t{1}));
    return magic + bagRecord(fields, std::string(4096 - 8 - fields.size(), ' '));
  };
  const std::uint64_t chunk_at = begin(0).size();
  const std::string info =
      bagRecord(op(6) + field("ver", rawBytes(std::uint32_t{1})) + field("chunk_pos", rawBytes(chunk_at)) +
                    field("start_time", time) + field("end_time", time) + field("count", rawBytes(count)),
                counts);
  return begin(chunk_at + chunk_record.size()) + chunk_record + connections + info;
}

// ---- ROS 2

#ifdef FUSE_FLOW_WITH_FASTCDR
/** \brief Two cameras, of which one has colour, and one float depth. */
std::string mcap(const std::string& compression) {
  using namespace fuse_flow;
  io::LoadedFrame frame;
  for (const char* name : {"left", "right"}) {
    Camera camera;
    camera.name = name;
    camera.intrinsics = {kWidth, kHeight, 10, 10, 3.5f, 2.5f, {}};
    frame.rig.cameras.push_back(camera);
  }
  frame.images.resize(2);
  frame.rig.views.resize(2);
  frame.images[0].depth16.resize(kWidth, kHeight);
  for (std::size_t k = 0; k < frame.images[0].depth16.data.size(); ++k)
    frame.images[0].depth16.data[k] = static_cast<std::uint16_t>(k % 5 == 0 ? 0 : 1000 + k);
  frame.images[0].color.resize(kWidth, kHeight);
  frame.images[1].depth32.resize(kWidth, kHeight);
  std::fill(frame.images[1].depth32.data.begin(), frame.images[1].depth32.data.end(), 1.5f);
  frame.rig.views[0].depth16 = frame.images[0].depth16.view();
  frame.rig.views[0].color = frame.images[0].color.view();
  frame.rig.views[1].depth32 = frame.images[1].depth32.view();
  const std::string path = scratchFile("seed.mcap", "");
  io::RigMessages::Options options;
  options.compression = compression;
  io::RigMessages messages(path, frame.rig.cameras, {true, false}, options);
  for (io::Nanoseconds time : {0, 33'000'000}) messages.write(io::Nanoseconds{kStart} * 1'000'000'000 + time, frame);
  messages.finish();
  return io::readFile(path);
}

/** \brief Of a message of each type, that type's number in readMessage() and its bytes. */
std::vector<std::string> cdrMessages(const std::string& file) {
  using namespace fuse_flow;
  const auto log = io::openMcap(scratchFile("seed.mcap", file));
  const std::vector<std::string> types{"sensor_msgs/Image", "sensor_msgs/CompressedImage", "sensor_msgs/CameraInfo",
                                       "tf2_msgs/TFMessage"};
  std::vector<std::string> messages;
  for (std::size_t topic = 0; topic < log->topics().size(); ++topic) {
    const auto type = std::find(types.begin(), types.end(), log->topics()[topic].type);
    if (type == types.end() || log->topics()[topic].times.empty()) continue;
    std::string bytes;
    log->read(topic, 0, bytes);
    messages.push_back(static_cast<char>(type - types.begin()) + bytes);
  }
  return messages;
}
#endif

#if defined(FUSE_FLOW_WITH_FASTCDR) && defined(FUSE_FLOW_WITH_SQLITE)
/** \brief The same messages, as ROS 2's recorder writes its tables. */
std::string sqliteBag(const std::string& file) {
  const std::string path = emptyScratchFolder() + "/seed.db3";
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  const auto run = [&](const std::string& statement) {
    sqlite3_exec(database, statement.c_str(), nullptr, nullptr, nullptr);
  };
  run("PRAGMA page_size = 512");
  run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, "
      "offered_qos_profiles TEXT)");
  run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)");
  const auto log = fuse_flow::io::openMcap(scratchFile("seed.mcap", file));
  for (std::size_t topic = 0; topic < log->topics().size(); ++topic) {
    const fuse_flow::io::Topic& t = log->topics()[topic];
    run("INSERT INTO topics VALUES(" + std::to_string(topic) + ", '" + t.name + "', '" + t.type + "', 'cdr', '')");
    for (std::size_t message = 0; message < t.times.size(); ++message) {
      std::string bytes;
      log->read(topic, message, bytes);
      sqlite3_stmt* insert = nullptr;
      sqlite3_prepare_v2(database, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", -1, &insert,
                         nullptr);
      sqlite3_bind_int64(insert, 1, static_cast<sqlite3_int64>(topic));
      sqlite3_bind_int64(insert, 2, t.times[message]);
      sqlite3_bind_blob(insert, 3, bytes.data(), static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
      sqlite3_step(insert);
      sqlite3_finalize(insert);
    }
  }
  sqlite3_close(database);
  return fuse_flow::io::readFile(path);
}
#endif

// ---- Azure Kinect

#ifdef FUSE_FLOW_WITH_LIBAV
/** \brief Written by libavformat. Its packets have fewer bytes than images, whose sizes the modes say: inputs stay small. */
std::string mkv(const std::string& calibration) {
  const std::string path = scratchFile("seed.mkv", "");
  AVFormatContext* context = nullptr;
  avformat_alloc_output_context2(&context, nullptr, "matroska", path.c_str());
  context->flags |= AVFMT_FLAG_BITEXACT;
  av_dict_set(&context->metadata, "K4A_WIRED_SYNC_MODE", "STANDALONE", 0);
  av_dict_set(&context->metadata, "K4A_START_OFFSET_NS", "1000000", 0);
  av_dict_set(&context->metadata, "K4A_DEPTH_DELAY_NS", "100", 0);
  AVStream* depth = recorder_test::addVideoTrack(context, "DEPTH", 0, AV_CODEC_ID_RAWVIDEO, 320, 288);
  depth->codecpar->codec_tag = MKTAG('b', '1', '6', 'g');
  av_dict_set(&depth->metadata, "K4A_DEPTH_MODE", "NFOV_2X2BINNED", 0);
  AVStream* color = recorder_test::addVideoTrack(context, "COLOR", 0, AV_CODEC_ID_MJPEG, 1280, 720);
  av_dict_set(&color->metadata, "K4A_COLOR_MODE", "MJPG_720P", 0);
  AVStream* attached = avformat_new_stream(context, nullptr);
  attached->codecpar->codec_type = AVMEDIA_TYPE_ATTACHMENT;
  attached->codecpar->codec_id = AV_CODEC_ID_BIN_DATA;
  attached->codecpar->extradata =
      static_cast<std::uint8_t*>(av_mallocz(calibration.size() + AV_INPUT_BUFFER_PADDING_SIZE));
  attached->codecpar->extradata_size = static_cast<int>(calibration.size());
  std::copy(calibration.begin(), calibration.end(), attached->codecpar->extradata);
  av_dict_set(&attached->metadata, "filename", "calibration.json", 0);
  av_dict_set(&attached->metadata, "mimetype", "application/octet-stream", 0);
  avio_open(&context->pb, path.c_str(), AVIO_FLAG_WRITE);
  if (avformat_init_output(context, nullptr) >= 0) {
    depth->codecpar->codec_tag = MKTAG('b', '1', '6', 'g');  // of uncompressed images it has forgotten it
    if (avformat_write_header(context, nullptr) >= 0) {
      for (const int ms : {0, 33, 66})
        for (const AVStream* track : {depth, color})
          recorder_test::writeImage(context, track, ms, std::string(64, '\x04'));
      av_write_trailer(context);
    }
  }
  avio_closep(&context->pb);
  avformat_free_context(context);
  return fuse_flow::io::readFile(path);
}
#endif

}  // namespace

void addRecorderSeeds(Seeds& seeds) {
  seeds["ros1_message"] = {'\0' + rosImage(0, "16UC1", 2),
                           '\0' + rosImage(1, "bayer_rggb8", 1),
                           '\0' + rosImage(2, "yuv422", 2),
                           '\0' + rosImage(3, "32FC1", 4),
                           '\1' + rvlImage(),
                           '\2' + cameraInfo(),
                           '\3' + transforms()};
  seeds["rosbag"] = {rosBag()};
#ifdef FUSE_FLOW_WITH_FASTCDR
  seeds["mcap"] = {mcap("")};
#ifdef FUSE_FLOW_WITH_LZ4
  seeds["mcap"].push_back(mcap("lz4"));
#endif
#ifdef FUSE_FLOW_WITH_ZSTD
  seeds["mcap"].push_back(mcap("zstd"));
#endif
  seeds["cdr_message"] = cdrMessages(seeds["mcap"][0]);
#ifdef FUSE_FLOW_WITH_SQLITE
  seeds["sqlite"] = {sqliteBag(seeds["mcap"][0])};
#endif
#endif
#ifdef FUSE_FLOW_WITH_LIBAV
  seeds["mkv"] = {mkv(seeds.at("mkv_calibration")[0])};
#endif
}

}  // namespace fuse_flow_fuzz
