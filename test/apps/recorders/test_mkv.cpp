#include "recordings/images/image_io.h"
#include "recordings/read_ahead.h"
#include "recordings/streams/azure_kinect.h"
#include "recordings/streams/video_file.h"

#include "../recordings/images/jpeg_file.h"
#include "../recordings/io_fixture.h"

#include <fuse_flow/recordings/recording.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#ifdef FUSE_FLOW_WITH_LIBAV

#include "mkv_tracks.h"

namespace {

using namespace io_test;
using namespace recorder_test;
using Json = nlohmann::json;

/** \brief A calibration whose numbers are easy: the depth lens in the middle of its square, the colour camera 32 mm to the right. */
Json calibration() {
  const Json depth_lens = {
      {"ModelType", "CALIBRATION_LensDistortionModelBrownConrady"},
      {"ModelParameters", {0.5, 0.5, 0.49, 0.49, 0.5, -0.02, -0.003, 0.9, 0.08, -0.014, 0, 0, -7e-5, 2e-5}}};
  const Json color_lens = {
      {"ModelType", "CALIBRATION_LensDistortionModelBrownConrady"},
      {"ModelParameters", {0.5, 0.5, 0.48, 0.64, 0.3, -2.5, 1.5, 0.2, -2.3, 1.4, 0, 0, 1e-4, -2e-4}}};
  const Json identity = {{"Rotation", {1, 0, 0, 0, 1, 0, 0, 0, 1}}, {"Translation", {0, 0, 0}}};
  const Json aside = {{"Rotation", {1, 0, 0, 0, 1, 0, 0, 0, 1}}, {"Translation", {-0.032, 0.002, 0.004}}};
  Json json;
  json["CalibrationInformation"]["Cameras"] = {{{"Location", "CALIBRATION_CameraLocationD0"},
                                                {"Intrinsics", depth_lens},
                                                {"Rt", identity},
                                                {"SensorWidth", 1024},
                                                {"SensorHeight", 1024}},
                                               {{"Location", "CALIBRATION_CameraLocationPV0"},
                                                {"Intrinsics", color_lens},
                                                {"Rt", aside},
                                                {"SensorWidth", 4096},
                                                {"SensorHeight", 3072}}};
  return json;
}

TEST(AzureKinect, ModesAreScalesAndCropsOfTheWholeSensor) {
  const std::string json = calibration().dump() + '\0';
  const auto camera = [&](const char* depth, const char* color) {
    return io::azureKinectCamera("file", json, {depth, color});
  };
  // Principal points: 0.5 of 1024 pixels, less the crop, less half a pixel.
  const Intrinsics narrow = camera("NFOV_UNBINNED", "720P").intrinsics;
  EXPECT_EQ(narrow.width, 640);
  EXPECT_EQ(narrow.height, 576);
  EXPECT_FLOAT_EQ(narrow.cx, 512 - 192 - 0.5f);
  EXPECT_FLOAT_EQ(narrow.cy, 512 - 180 - 0.5f);
  EXPECT_FLOAT_EQ(narrow.fx, 0.49f * 1024);
  EXPECT_FLOAT_EQ(narrow.distortion.k1, 0.5f);
  EXPECT_FLOAT_EQ(narrow.distortion.k3, -0.003f);
  EXPECT_FLOAT_EQ(narrow.distortion.k4, 0.9f);
  EXPECT_FLOAT_EQ(narrow.distortion.p1, 2e-5f);  // p2 comes before it
  EXPECT_FLOAT_EQ(narrow.distortion.p2, -7e-5f);
  const Intrinsics binned = camera("NFOV_2X2BINNED", "").intrinsics;
  EXPECT_EQ(binned.width, 320);
  EXPECT_FLOAT_EQ(binned.cx, 256 - 96 - 0.5f);
  EXPECT_FLOAT_EQ(binned.cy, 256 - 90 - 0.5f);
  EXPECT_FLOAT_EQ(binned.fx, 0.49f * 512);
  EXPECT_FLOAT_EQ(camera("WFOV_2X2BINNED", "").intrinsics.cx, 255.5f);
  EXPECT_FLOAT_EQ(camera("WFOV_UNBINNED", "").intrinsics.cy, 511.5f);

  const std::vector<std::tuple<const char*, int, int>> sizes{{"720P", 1280, 720},   {"1080P", 1920, 1080},
                                                             {"1440P", 2560, 1440}, {"1536P", 2048, 1536},
                                                             {"2160P", 3840, 2160}, {"3072P", 4096, 3072}};
  for (const auto& [mode, width, height] : sizes) {
    const ColorCamera color = camera("NFOV_UNBINNED", mode).color.value();
    EXPECT_EQ(color.intrinsics.width, width);
    EXPECT_EQ(color.intrinsics.height, height);
    EXPECT_FLOAT_EQ(color.intrinsics.cx, static_cast<float>(width) / 2 - 0.5f) << mode;
    EXPECT_FLOAT_EQ(color.intrinsics.cy, static_cast<float>(height) / 2 - 0.5f) << mode;  // crops are in the middle
    EXPECT_FLOAT_EQ(color.intrinsics.fx, 0.48f * static_cast<float>(width)) << mode;
    EXPECT_NEAR(color.intrinsics.fy, 0.64 * width * 3 / 4, 1e-3) << mode;
    // Rt leads from depth to colour.
    EXPECT_LT((color.T_depth_color.translation() - Eigen::Vector3d(0.032, -0.002, -0.004)).norm(), 1e-12);
  }
}

TEST(AzureKinect, WhatIsNoCalibrationIsRefused) {
  const auto refusal = [](const std::string& json, const std::vector<std::string>& words,
                          const char* depth = "NFOV_UNBINNED") {
    return refuses([&] { io::azureKinectCamera("file", json, {depth, "720P"}); }, words);
  };
  EXPECT_TRUE(refusal("", {"file: is not JSON"}));
  EXPECT_TRUE(refusal("[]", {"CALIBRATION_CameraLocationD0"}));
  EXPECT_TRUE(refusal("{\"CalibrationInformation\": 3}", {"CALIBRATION_CameraLocationD0"}));
  EXPECT_TRUE(refusal(calibration().dump(), {"'PASSIVE_IR'", "NFOV_UNBINNED"}, "PASSIVE_IR"));
  const auto changed = [](const auto& change) {
    Json json = calibration();
    change(json["CalibrationInformation"]["Cameras"]);
    return json.dump();
  };
  EXPECT_TRUE(
      refusal(changed([](Json& c) { c[0]["Intrinsics"]["ModelType"] = "CALIBRATION_LensDistortionModelRational6KT"; }),
              {"ModelType", "Rational6KT"}));
  EXPECT_TRUE(refusal(changed([](Json& c) { c[0]["Intrinsics"]["ModelParameters"].erase(0); }),
                      {"ModelParameters", "14 numbers"}));
  EXPECT_TRUE(refusal(changed([](Json& c) { c[1]["Rt"]["Rotation"][0] = 2; }), {"Rt", "rigid"}));
  EXPECT_TRUE(refusal(changed([](Json& c) { c[1]["SensorHeight"] = 2304; }), {"SensorHeight", "2304"}));
  EXPECT_TRUE(refusal(changed([](Json& c) { c[0].erase("SensorWidth"); }), {"SensorWidth"}));
  EXPECT_TRUE(refusal(changed([](Json& c) { c.erase(1); }), {"CALIBRATION_CameraLocationPV0"}));
}

constexpr int kWidth = 320, kHeight = 288;  // of the mode NFOV_2X2BINNED

std::uint16_t mkvDepthAt(int k, int u, int v) {
  return static_cast<std::uint16_t>(u == v ? 0 : 300 + 1000 * k + 2 * u + 3 * v);
}

/** \brief What a test wants in a file. */
struct MkvOptions {
  std::string calibration = ::calibration().dump();
  std::string depth_mode = "NFOV_2X2BINNED";
  std::string sync = "STANDALONE";
  std::string start_offset = "0";
  std::string depth_delay = "0";
  std::vector<int> depth_ms{0, 33, 66};
  std::vector<int> color_ms{};  // grey images of 1280x720, each brighter than the one before
  std::string color_format = "MJPG";
};

/** \brief Written by libavformat. */
class Mkv : public IoTest {
 protected:
  std::string writeMkv(const std::string& name, const MkvOptions& options = {}) const {
    const std::string file = path(name);
    writeMkvFile(file, options);
    return file;
  }
  static void writeMkvFile(const std::string& file, const MkvOptions& options) {
    fs::create_directories(fs::path(file).parent_path());
    AVFormatContext* context = nullptr;
    avformat_alloc_output_context2(&context, nullptr, "matroska", file.c_str());
    const auto tag = [](AVDictionary** tags, const char* key, const std::string& value) {
      av_dict_set(tags, key, value.c_str(), 0);
    };
    tag(&context->metadata, "K4A_WIRED_SYNC_MODE", options.sync);
    tag(&context->metadata, "K4A_START_OFFSET_NS", options.start_offset);
    tag(&context->metadata, "K4A_DEPTH_DELAY_NS", options.depth_delay);
    AVStream* depth = addVideoTrack(context, "DEPTH", MKTAG('b', '1', '6', 'g'), AV_CODEC_ID_RAWVIDEO, kWidth, kHeight);
    tag(&depth->metadata, "K4A_DEPTH_MODE", options.depth_mode);
    AVStream* color = nullptr;
    if (!options.color_ms.empty()) {
      const bool jpeg = options.color_format == "MJPG";
      color = addVideoTrack(context, "COLOR", fourcc(options.color_format),
                            jpeg ? AV_CODEC_ID_MJPEG : AV_CODEC_ID_RAWVIDEO, 1280, 720);
      tag(&color->metadata, "K4A_COLOR_MODE", options.color_format + "_720P");
    }
    if (!options.calibration.empty()) {
      AVStream* attached = avformat_new_stream(context, nullptr);
      attached->codecpar->codec_type = AVMEDIA_TYPE_ATTACHMENT;
      attached->codecpar->codec_id = AV_CODEC_ID_BIN_DATA;
      const std::size_t size = options.calibration.size();
      attached->codecpar->extradata = static_cast<std::uint8_t*>(av_mallocz(size + AV_INPUT_BUFFER_PADDING_SIZE));
      attached->codecpar->extradata_size = static_cast<int>(size);
      std::copy(options.calibration.begin(), options.calibration.end(), attached->codecpar->extradata);
      tag(&attached->metadata, "filename", "calibration.json");
      tag(&attached->metadata, "mimetype", "application/octet-stream");
    }
    avio_open(&context->pb, file.c_str(), AVIO_FLAG_WRITE);
    EXPECT_GE(avformat_init_output(context, nullptr), 0);
    depth->codecpar->codec_tag = fourcc("b16g");  // of uncompressed images it has forgotten these
    if (color) color->codecpar->codec_tag = fourcc(options.color_format);
    ASSERT_GE(avformat_write_header(context, nullptr), 0);
    std::vector<std::tuple<int, bool, int>> order;  // of time, as recorders write
    for (std::size_t k = 0; k < options.depth_ms.size(); ++k)
      order.emplace_back(options.depth_ms[k], true, static_cast<int>(k));
    for (std::size_t k = 0; k < options.color_ms.size(); ++k)
      order.emplace_back(options.color_ms[k], false, static_cast<int>(k));
    std::sort(order.begin(), order.end());
    for (const auto& [ms, is_depth, k] : order)
      EXPECT_TRUE(writeImage(context, is_depth ? depth : color, ms,
                             is_depth ? depthBytes(k) : colorBytes(options.color_format, k)));
    av_write_trailer(context);
    avio_closep(&context->pb);
    avformat_free_context(context);
  }

  static unsigned fourcc(const std::string& name) { return MKTAG(name[0], name[1], name[2], name[3]); }

  static std::string depthBytes(int k) {
    std::string bytes;
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) {
        bytes += static_cast<char>(mkvDepthAt(k, u, v) >> 8);
        bytes += static_cast<char>(mkvDepthAt(k, u, v) & 0xff);
      }
    return bytes;
  }
  static std::string colorBytes(const std::string& format, int k) {
    if (format == "MJPG") {
      const auto plane = [](int value) {
        return std::vector<std::uint8_t>(160 * 90, static_cast<std::uint8_t>(value));
      };
      return jpeg(160, {plane(60 + 40 * k), plane(128), plane(128)});
    }
    std::string bytes;
    if (format == "NV12")  // luminance 126 and no chroma: (126 - 16) * 255 / 219
      bytes = std::string(1280 * 720, 126) + std::string(1280 * 720 / 2, static_cast<char>(128));
    for (int n = 0; n < 1280 * 720 && format == "YUY2"; ++n) bytes += {126, static_cast<char>(128)};
    if (format == "BGRA") bytes = std::string(1280 * 720 * 4, static_cast<char>(60 + 40 * k));
    return bytes;
  }

  static void expectDepth(const io::LoadedView& view, int k) {
    ASSERT_EQ(view.depth16.width, kWidth);
    int wrong = 0;
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) wrong += view.depth16.at(u, v) == mkvDepthAt(k, u, v) ? 0 : 1;
    EXPECT_EQ(wrong, 0) << "image " << k;
  }
  static bool warns(const io::Recording& recording, const std::string& words) {
    return std::any_of(recording.warnings().begin(), recording.warnings().end(),
                       [&](const std::string& warning) { return warning.find(words) != std::string::npos; });
  }
  testing::AssertionResult refusal(const MkvOptions& options, const std::vector<std::string>& words) {
    const std::string file = writeMkv("refused.mkv", options);
    return refuses([&] { io::openRecording({file}); }, words);
  }
};

TEST_F(Mkv, DepthAndTimes) {
  const auto recording = io::openRecording({writeMkv("kinect.mkv")});
  EXPECT_EQ(recording->kind(), "mkv");
  ASSERT_EQ(recording->cameras().size(), 1u);
  EXPECT_EQ(recording->cameras()[0].name, "kinect");
  EXPECT_FLOAT_EQ(recording->cameras()[0].depth_scale, 0.001f);
  EXPECT_FALSE(recording->hasColor(0));
  ASSERT_EQ(recording->frameCount(), 3u);
  EXPECT_NEAR(recording->framesPerSecond().value(), 30.3, 0.1);
  io::LoadedFrame frame;
  for (const int k : {0, 1, 2, 1, 0, 2}) {  // also back and over one
    recording->read(static_cast<std::size_t>(k), frame);
    expectDepth(frame.images[0], k);
    EXPECT_EQ(frame.rig.stamp, static_cast<std::uint64_t>(33'000 * k));
  }
}

TEST_F(Mkv, ColourOfEachFormat) {
  for (const char* format : {"NV12", "YUY2", "BGRA", "MJPG"}) {
    SCOPED_TRACE(format);
    MkvOptions options;
    options.color_format = format;
    options.color_ms = {0, 33, 66};
    const auto recording = io::openRecording({writeMkv(std::string(format) + ".mkv", options)});
    EXPECT_TRUE(recording->hasColor(0));
    io::LoadedFrame frame;
    for (const int k : {2, 0, 1}) {
      recording->read(static_cast<std::size_t>(k), frame);
      expectDepth(frame.images[0], k);
      ASSERT_EQ(frame.images[0].color.width, 1280);
      for (const auto& [u, v] : {std::pair{0, 0}, {640, 360}, {1279, 719}}) {
        const Rgb8 color = frame.images[0].color.at(u, v);
        const auto grey = static_cast<std::uint8_t>(format[0] == 'M' || format[0] == 'B' ? 60 + 40 * k : 128);
        for (const int channel : {color.r, color.g, color.b}) EXPECT_NEAR(channel, grey, 1);
      }
    }
  }
}

TEST(ConvertColor, OfColouredPixelsEachChannelIsInItsPlace) {
  io::ColorImage rgb;
  io::convertColor("image", io::VideoCodec::Bgra, 2, 2, {1, 2, 3, 9, 4, 5, 6, 9, 7, 8, 9, 9, 10, 11, 12, 9}, rgb);
  EXPECT_EQ(rgb.at(0, 0).r, 3);
  EXPECT_EQ(rgb.at(0, 0).b, 1);
  EXPECT_EQ(rgb.at(1, 1).g, 11);
  // Y, Cb, Cr of pure red of BT.601, rounded: 81, 90, 240.
  const std::string red_yuy2{81, 90, 81, static_cast<char>(240), 81, 90, 81, static_cast<char>(240)};
  const std::string red_nv12{81, 81, 81, 81, 90, static_cast<char>(240)};
  for (const auto& [codec, bytes] : {std::pair{io::VideoCodec::Yuy2, red_yuy2}, {io::VideoCodec::Nv12, red_nv12}}) {
    io::convertColor("image", codec, 2, 2, bytes, rgb);
    EXPECT_NEAR(rgb.at(1, 1).r, 254, 2);
    EXPECT_NEAR(rgb.at(1, 1).g, 0, 2);
    EXPECT_NEAR(rgb.at(1, 1).b, 0, 2);
  }
  EXPECT_TRUE(refuses([&] { io::convertColor("image", io::VideoCodec::Bgra, 2, 2, "short", rgb); },
                      {"image: has 5 bytes, must have 16"}));
}

TEST_F(Mkv, TheColourImageOfADepthImageIsThatOfItsTimeLessTheDelay) {
  MkvOptions options;
  options.depth_ms = {20, 53, 86};
  options.color_ms = {0, 33, 66, 99};
  options.depth_delay = "20000000";
  const auto recording = io::openRecording({writeMkv("delayed.mkv", options)});
  io::LoadedFrame frame;
  for (const int k : {0, 1, 2}) {
    recording->read(static_cast<std::size_t>(k), frame);
    EXPECT_EQ(frame.images[0].color.at(5, 5).r,
              60 + 40 * k);  // without the delay the nearest of the first is the second
  }
  EXPECT_FALSE(warns(*recording, "before or after depth"));
  options.depth_delay = "0";
  const auto undelayed = io::openRecording({writeMkv("undelayed.mkv", options)});
  undelayed->read(0, frame);
  EXPECT_EQ(frame.images[0].color.at(5, 5).r, 100);
  EXPECT_TRUE(warns(*undelayed, "13.0 ms before or after depth"));
}

TEST_F(Mkv, SeveralThreadsReadTheSameFramesInTheirOrder) {
  MkvOptions options;
  options.depth_ms.clear();
  for (int k = 0; k < 30; ++k) options.depth_ms.push_back(33 * k);
  const auto recording = io::openRecording({writeMkv("long.mkv", options)});
  ASSERT_TRUE(recording->readsConcurrently());
  io::ReadAhead ahead(*recording, recording->frames(), 4);
  io::LoadedFrame frame;
  for (int k = 0; k < 30; ++k) {
    ahead.next(frame);
    expectDepth(frame.images[0], k);
  }
}

TEST_F(Mkv, CamerasThatExposeFarApartAreNamed) {
  MkvOptions master, late;
  master.sync = "MASTER";
  late.sync = "SUBORDINATE";
  late.start_offset = "12000000";
  io::RecordingOptions options;
  options.without_poses = true;
  const auto recording = io::openRecording({writeMkv("left.mkv", master), writeMkv("right.mkv", late)}, options);
  EXPECT_TRUE(warns(*recording, "are taken within 12.0 ms (median), so that what moves may be double"));
}

TEST_F(Mkv, DevicesOnACableShareTheClockOfTheirStartOffsets) {
  MkvOptions master, subordinate;
  master.sync = "MASTER";
  master.start_offset = "100000000";
  subordinate.sync = "SUBORDINATE";
  subordinate.start_offset = "133000000";  // its first image is the master's second
  io::RecordingOptions options;
  options.without_poses = true;
  const std::vector<std::string> files{writeMkv("a/output.mkv", master), writeMkv("b/output.mkv", subordinate)};
  const auto recording = io::openRecording(files, options);
  EXPECT_EQ(recording->cameras()[0].name, "a");  // two files of one name are told apart by their folders
  EXPECT_EQ(recording->cameras()[1].name, "b");
  ASSERT_EQ(recording->frameCount(), 4u);
  io::LoadedFrame frame;
  recording->read(0, frame);
  EXPECT_TRUE(frame.rig.views[1].missing());
  recording->read(1, frame);
  expectDepth(frame.images[0], 1);
  expectDepth(frame.images[1], 0);
  EXPECT_EQ(frame.rig.stamp, 133'000u);
  recording->read(3, frame);
  EXPECT_TRUE(frame.rig.views[0].missing());
  ASSERT_EQ(frame.ended.size(), 1u);
  EXPECT_NE(frame.ended[0].message.find("ends after 3 of 4 frames"), std::string::npos);
  EXPECT_FALSE(warns(*recording, "clocks"));
}

TEST_F(Mkv, DevicesWithoutACableBeginTogetherWhichIsSaid) {
  MkvOptions late;
  late.start_offset = "5000000000";
  io::RecordingOptions options;
  options.without_poses = true;
  const auto recording = io::openRecording({writeMkv("left.mkv"), writeMkv("right.mkv", late)}, options);
  EXPECT_TRUE(warns(*recording, "nothing says how the clocks"));
  ASSERT_EQ(recording->frameCount(), 3u);
  io::LoadedFrame frame;
  recording->read(2, frame);
  expectDepth(frame.images[0], 2);
  expectDepth(frame.images[1], 2);
}

TEST_F(Mkv, PosesOfARigJsonPlaceTheFiles) {
  const auto pose = [](double x) { return Json{1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; };
  Json rig;
  for (const auto& [name, x] : {std::pair{"left", 0.5}, {"right", 1.5}})
    rig["cameras"].push_back({{"name", name},
                              {"width", kWidth},
                              {"height", kHeight},
                              {"fx", 250},
                              {"fy", 250},
                              {"cx", 160},
                              {"cy", 144},
                              {"depth_scale", 0.001},
                              {"T_world_camera", pose(x)}});
  io::RecordingOptions options;
  options.poses = write("rig.json", rig.dump());
  const auto recording = io::openRecording({writeMkv("left.mkv"), writeMkv("right.mkv")}, options);
  EXPECT_EQ(recording->cameras()[1].T_world_camera.translation().x(), 1.5);
}

TEST_F(Mkv, WhatIsNoRecordingIsRefusedInALine) {
  MkvOptions options;
  options.calibration.clear();
  EXPECT_TRUE(refusal(options, {"refused.mkv: has no calibration.json"}));
  options = {};
  options.depth_mode = "WFOV_UNBINNED";
  EXPECT_TRUE(refusal(options, {"its track DEPTH is 320x288 pixels, its mode is 1024x1024"}));
  options = {};
  options.depth_ms.clear();
  options.color_ms = {0};
  EXPECT_TRUE(refusal(options, {"has no depth images"}));
  options = {};
  options.start_offset = "soon";
  EXPECT_TRUE(refusal(options, {"K4A_START_OFFSET_NS is 'soon'"}));
  write("text.mkv", "no Matroska");
  EXPECT_TRUE(refuses([&] { io::openRecording({path("text.mkv")}); }, {"text.mkv: is not a Matroska file"}));
  write("short.mkv", "\x1a\x45\xdf\xa3");
  EXPECT_TRUE(refuses([&] { io::openRecording({path("short.mkv")}); }, {"short.mkv"}));
}

TEST_F(Mkv, AFileWhoseRecorderWasKilledPlaysUpToThere) {
  const std::string whole = writeMkv("whole.mkv");
  fs::resize_file(whole, fs::file_size(whole) - kWidth * kHeight * 2);  // the last image, and what is behind it
  const auto recording = io::openRecording({whole});
  ASSERT_EQ(recording->frameCount(), 2u);
  io::LoadedFrame frame;
  for (const int k : {1, 0}) {
    recording->read(static_cast<std::size_t>(k), frame);
    expectDepth(frame.images[0], k);
  }
}

TEST_F(Mkv, TheRecordingOfARealDevice) {
  const fs::path real = fs::path(FUSE_FLOW_TEST_SHARED_DATA) / "azure_kinect" / "recording.mkv";
  if (!fs::exists(real)) GTEST_SKIP() << real << " is not there";
  const auto recording = io::openRecording({real.string()});
  EXPECT_TRUE(recording->warnings().empty()) << recording->warnings()[0];
  ASSERT_EQ(recording->frameCount(), 1u);  // an image of colour, of depth and of infrared
  io::LoadedFrame frame;
  recording->read(0, frame);
  EXPECT_EQ(frame.rig.stamp, 800'222u);  // 463.945 ms into the file, which starts at 336.277 ms
  const Camera& camera = recording->cameras()[0];

  // Pixel by pixel what ffmpeg extracts.
  const std::string raw = path("depth.raw");
  const std::string command = "ffmpeg -v error -y -i '" + real.string() +
                              "' -map 0:1 -fps_mode passthrough -f rawvideo -pix_fmt gray16le '" + raw +
                              "' > /dev/null 2>&1";
  if (std::system(command.c_str()) == 0) {
    std::ifstream file(raw, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    ASSERT_EQ(bytes.size(), frame.images[0].depth16.data.size() * 2);
    EXPECT_TRUE(
        std::equal(bytes.begin(), bytes.end(), reinterpret_cast<const char*>(frame.images[0].depth16.data.data())));
  }

  // The edges of what stands in front of a wall are edges of colour, to two pixels of 1280.
  const io::DepthImage& depth = frame.images[0].depth16;
  const io::ColorImage& color = frame.images[0].color;
  const Eigen::Isometry3d T_color_depth = camera.color->T_depth_color.inverse();
  const auto pixelOf = [&](int u, int v) {
    const float z = static_cast<float>(depth.at(u, v)) * camera.depth_scale;
    const Ray ray = unproject(camera.intrinsics, {static_cast<float>(u), static_cast<float>(v)});
    const Eigen::Vector3f p = (T_color_depth * Eigen::Vector3d(ray.x * z, ray.y * z, z)).cast<float>();
    return project(camera.color->intrinsics, {p.x(), p.y(), p.z()});
  };
  constexpr int most = 16, beside = 6;  // pixels; at an edge itself there is often no depth
  std::map<int, double> steps;          // of brightness, by how far aside of the edge
  int edges = 0;
  for (int v = 0; v < depth.height; ++v)
    for (int u = beside; u + beside < depth.width; ++u)
      for (const int side : {-1, 1}) {
        const int front = depth.at(u, v), behind = depth.at(u + side * beside, v), next = depth.at(u + side, v);
        if (front == 0 || behind < front + 150 || (next != 0 && next < front + 100)) continue;
        const Pixel pixel = pixelOf(u, v);
        const int x = static_cast<int>(std::lround(pixel.u)), y = static_cast<int>(std::lround(pixel.v));
        if (x < most + 2 || y < 0 || x >= color.width - most - 2 || y >= color.height) continue;
        ++edges;
        for (int aside = -most; aside <= most; ++aside)
          steps[aside] += std::abs(color.at(x + aside + 2, y).g - color.at(x + aside - 2, y).g);
      }
  EXPECT_GT(edges, 200);
  const auto sharpest =
      std::max_element(steps.begin(), steps.end(), [](const auto& p, const auto& q) { return p.second < q.second; });
  EXPECT_LE(std::abs(sharpest->first), 2);
}

}  // namespace

#endif  // FUSE_FLOW_WITH_LIBAV
