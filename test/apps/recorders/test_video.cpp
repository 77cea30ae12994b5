#include "recordings/read_ahead.h"
#include "recordings/streams/decoded_video.h"

#include "../recordings/io_fixture.h"

#include <fuse_flow/recordings/recording.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#ifdef FUSE_FLOW_WITH_LIBAV

#include "video_file_of.h"

namespace {

using namespace io_test;
using namespace recorder_test;
using Json = nlohmann::json;

/** \brief Brightness of a picture, from which its number is known: steps that no codec blurs. */
std::uint8_t levelOf(int number) { return static_cast<std::uint8_t>(16 + 5 * (number % 44)); }

class Video : public IoTest {
 protected:
  /** \brief For containers without places for times. */
  static VideoOptions inOrder() {
    VideoOptions options;
    options.between = 0;
    return options;
  }
  static std::string bytesOf(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::string counting(const std::string& name, const VideoOptions& options = {}) const {
    const std::string file = path(name);
    EXPECT_TRUE(writeVideo(file, options, [](int k, AVFrame& frame) { paintPlain(frame, levelOf(k), 128, 128); }));
    return file;
  }
  /** \brief rig.json of cameras a few centimetres apart. */
  std::string rigOf(const std::vector<std::string>& names, int width = 64) const {
    Json rig;
    for (std::size_t k = 0; k < names.size(); ++k)
      rig["cameras"].push_back(
          {{"name", names[k]},
           {"width", width},
           {"height", 48},
           {"fx", 50},
           {"fy", 50},
           {"cx", 31.5},
           {"cy", 23.5},
           {"T_world_camera", {1, 0, 0, 0.1 * static_cast<double>(k), 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
    return write("rig.json", rig.dump());
  }
  static io::RecordingOptions posed(const std::string& rig, std::vector<double> offsets = {}) {
    io::RecordingOptions options;
    options.poses = rig;
    options.time_offsets = std::move(offsets);
    return options;
  }
  /** \brief The number of the picture that a view of a frame shows; −1: none. */
  static int shown(const io::LoadedFrame& frame, std::size_t view) {
    if (!frame.rig.views[view].color) return -1;
    const Rgb8 pixel = frame.rig.views[view].color.row(20)[30];
    const double luma = 16 + 219.0 / 255 * pixel.g;  // grey
    return static_cast<int>(std::lround((luma - 16) / 5));
  }
  static bool says(const std::vector<std::string>& lines, const std::string& words) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(words) != std::string::npos; });
  }
};

TEST_F(Video, PicturesComeInTheirOrderAlsoWhereTheyAreStoredInAnother) {
  const auto recording = io::openRecording({counting("left.mp4")}, posed(rigOf({"left"})));
  EXPECT_EQ(recording->kind(), "video");
  ASSERT_EQ(recording->frameCount(), 40u);
  EXPECT_NEAR(recording->framesPerSecond().value(), 25, 0.01);
  EXPECT_FALSE(recording->hasDepth(0));
  EXPECT_TRUE(recording->hasColor(0));
  EXPECT_EQ(recording->cameras()[0].intrinsics.fx, 50);
  EXPECT_EQ(recording->inputs().size(), 2u) << "the video and rig.json";
  io::LoadedFrame frame;
  for (int k = 0; k < 40; ++k) {
    recording->read(static_cast<std::size_t>(k), frame);
    EXPECT_EQ(shown(frame, 0), k);
  }
  EXPECT_NEAR(static_cast<double>(frame.rig.stamp), 39 * 40000.0, 45000) << "a muxer may begin a picture later";
}

TEST_F(Video, AnyPictureCanBeReadAtAnyTime) {
  for (const char* name : {"one.mp4", "one.avi", "one.mkv", "one.ts"}) {
    VideoOptions options = std::string(name) == "one.avi" ? inOrder() : VideoOptions();
    options.pictures = 44;
    const auto recording = io::openRecording({counting(name, options)}, posed(rigOf({"one"})));
    ASSERT_EQ(recording->frameCount(), 44u) << name;
    std::vector<std::vector<Rgb8>> in_order;
    io::LoadedFrame frame;
    for (std::size_t k = 0; k < 44; ++k) {
      recording->read(k, frame);
      in_order.push_back(frame.images[0].color.data);
    }
    std::mt19937 random(1);
    for (int k = 0; k < 40; ++k) {
      const std::size_t number = random() % 44;
      recording->read(number, frame);
      ASSERT_EQ(shown(frame, 0), static_cast<int>(number)) << name;
      EXPECT_EQ(std::memcmp(frame.images[0].color.data.data(), in_order[number].data(), 3 * in_order[number].size()), 0)
          << name << " " << number;
    }
  }
}

TEST_F(Video, WhatIsStoredWithoutLossIsReadWithoutLoss) {
  VideoOptions options;
  options.codec = AV_CODEC_ID_FFV1;
  options.format = AV_PIX_FMT_BGR0;
  options.pictures = 3;
  const auto valueOf = [](int k, int u, int v, int channel) {
    return static_cast<std::uint8_t>(37 * k + 3 * u + 5 * v + 80 * channel);
  };
  const std::string file = path("left.avi");
  if (!writeVideo(file, options, [&](int k, AVFrame& frame) {
        for (int v = 0; v < 48; ++v)
          for (int u = 0; u < 64; ++u)
            for (int channel = 0; channel < 3; ++channel)
              frame.data[0][v * frame.linesize[0] + 4 * u + 2 - channel] = valueOf(k, u, v, channel);
      }))
    GTEST_SKIP() << "no encoder of FFV1";
  const auto recording = io::openRecording({file}, posed(rigOf({"left"})));
  io::LoadedFrame frame;
  for (int k = 0; k < 3; ++k) {
    recording->read(static_cast<std::size_t>(k), frame);
    std::size_t differ = 0;
    for (int v = 0; v < 48; ++v)
      for (int u = 0; u < 64; ++u) {
        const Rgb8 pixel = frame.rig.views[0].color.row(v)[u];
        differ += pixel.r != valueOf(k, u, v, 0) || pixel.g != valueOf(k, u, v, 1) || pixel.b != valueOf(k, u, v, 2);
      }
    EXPECT_EQ(differ, 0u) << k;
  }
}

TEST_F(Video, ColoursAreThoseOfItsMatrixAndRange) {
  struct Case {
    AVColorSpace matrix;
    AVColorRange range;
    std::uint8_t y, u, v;  // of pure red
  };
  for (const Case& of :
       {Case{AVCOL_SPC_SMPTE170M, AVCOL_RANGE_MPEG, 81, 90, 240}, Case{AVCOL_SPC_BT709, AVCOL_RANGE_MPEG, 63, 102, 240},
        Case{AVCOL_SPC_UNSPECIFIED, AVCOL_RANGE_UNSPECIFIED, 81, 90, 240},  // few rows: BT.601
        Case{AVCOL_SPC_SMPTE170M, AVCOL_RANGE_JPEG, 76, 85, 255}}) {
    VideoOptions options;
    options.codec = AV_CODEC_ID_FFV1;
    options.pictures = 1;
    options.matrix = of.matrix;
    options.range = of.range;
    const std::string file = path("left.mkv");
    if (!writeVideo(file, options, [&](int, AVFrame& frame) { paintPlain(frame, of.y, of.u, of.v); }))
      GTEST_SKIP() << "no encoder of FFV1";
    const auto recording = io::openRecording({file}, posed(rigOf({"left"})));
    io::LoadedFrame frame;
    recording->read(0, frame);
    const Rgb8 pixel = frame.rig.views[0].color.row(10)[10];
    EXPECT_NEAR(pixel.r, 255, 3) << of.matrix << " " << of.range;
    EXPECT_NEAR(pixel.g, 0, 3) << of.matrix << " " << of.range;
    EXPECT_NEAR(pixel.b, 0, 3) << of.matrix << " " << of.range;
  }
}

TEST_F(Video, CamerasArePutTogetherByTheTimesTheyBeganAt) {
  const std::vector<std::string> files{counting("left.mp4"), counting("right.mp4")};
  const std::string rig = rigOf({"left", "right"});
  io::LoadedFrame frame;
  const auto together = io::openRecording(files, posed(rig));
  EXPECT_TRUE(says(together->warnings(), "--time-offsets says by how many seconds each began later"));
  together->read(7, frame);
  EXPECT_EQ(shown(frame, 0), 7);
  EXPECT_EQ(shown(frame, 1), 7);
  const auto later = io::openRecording(files, posed(rig, {0, 0.2}));  // the right one by five pictures
  EXPECT_FALSE(says(later->warnings(), "--time-offsets"));
  ASSERT_EQ(later->frameCount(), 45u);
  later->read(7, frame);
  EXPECT_EQ(shown(frame, 0), 7);
  EXPECT_EQ(shown(frame, 1), 2);
  later->read(3, frame);
  EXPECT_EQ(shown(frame, 1), -1);
  const auto earlier = io::openRecording(files, posed(rig, {10.2, 10}));  // only the difference matters
  earlier->read(7, frame);
  EXPECT_EQ(shown(frame, 0), 2);
  EXPECT_EQ(shown(frame, 1), 7);
  EXPECT_TRUE(refuses<io::OptionError>([&] { io::openRecording(files, posed(rig, {1})); },
                                       {"--time-offsets", "has 1 numbers, must be 2"}));
  for (const double wrong : {-0.1, 1e7, std::nan("")})
    EXPECT_TRUE(refuses<io::OptionError>(
        [&] {
          io::openRecording(files, posed(rig, {0, wrong}));
        },
        {"--time-offsets", "must be seconds from 0"}));
  EXPECT_TRUE(refuses<io::OptionError>([&] { io::openRecording({folder_.string()}, posed(rig, {1})); },
                                       {"--time-offsets", "is for .mkv files and videos"}));
}

TEST_F(Video, SeveralThreadsReadWhatOneReads) {
  const std::vector<std::string> files{counting("left.mp4"), counting("right.avi", inOrder())};
  const auto recording = io::openRecording(files, posed(rigOf({"left", "right"})));
  ASSERT_TRUE(recording->readsConcurrently());
  const std::vector<std::size_t> frames = recording->frames();
  io::ReadAhead ahead(*recording, frames, 4);
  io::LoadedFrame frame;
  for (const std::size_t number : frames) {
    ahead.next(frame);
    for (const std::size_t view : {0, 1}) {
      const int found = shown(frame, view);
      EXPECT_TRUE(found == -1 || found == static_cast<int>(number)) << found << " " << number;
    }
  }
}

TEST_F(Video, WhatFfmpegEncodesIsRead) {
  constexpr int pictures = 44, width = 64, height = 48;
  std::string raw;  // with its colour, since what range a grey picture has differs from one ffmpeg to another
  for (int k = 0; k < pictures; ++k)
    raw += std::string(width * height, static_cast<char>(levelOf(k))) + std::string(width * height / 2, '\x80');
  write("pictures.raw", raw);
  for (const std::string name : {"h264.mp4", "h264.mov", "h264.mkv", "vp9.webm"}) {
    const std::string codec = name == "vp9.webm" ? "libvpx-vp9 -deadline realtime -cpu-used 8"
                                                 : "libx264 -bf 3 -g 20 -x264-params open-gop=1";
    const std::string command =
        "ffmpeg -nostdin -loglevel quiet -y -f rawvideo -pix_fmt yuv420p -video_size 64x48 -framerate 25 -i " +
        path("pictures.raw") + " -c:v " + codec + " " + path(name);
    if (std::system(command.c_str()) != 0) GTEST_SKIP() << "no ffmpeg with this codec: " << codec;
    const std::string camera = name.substr(0, name.find('.'));
    const auto recording = io::openRecording({path(name)}, posed(rigOf({camera})));
    ASSERT_EQ(recording->frameCount(), static_cast<std::size_t>(pictures)) << name;
    io::LoadedFrame frame;
    for (const std::size_t number : {0, 1, 2, 3, 10, 11, 12, 40, 43, 22, 21, 20, 19, 18, 5, 43, 0}) try {
        recording->read(number, frame);
        EXPECT_EQ(shown(frame, 0), static_cast<int>(number)) << name;
      } catch (const io::InputError& error) {
        ADD_FAILURE() << error.what();
      }
  }
}

TEST_F(Video, WhatItsPicturesAreNotIsSaid) {
  VideoOptions options;
  options.field_order = AV_FIELD_TT;
  options.transfer = AVCOL_TRC_ARIB_STD_B67;
  const auto recording = io::openRecording({counting("left.mkv", options)}, posed(rigOf({"left"})));
  EXPECT_TRUE(says(recording->warnings(), "is interlaced"));
  EXPECT_TRUE(says(recording->warnings(), "high dynamic range"));
  EXPECT_TRUE(io::openRecording({counting("left.mkv")}, posed(rigOf({"left"})))->warnings().empty());
}

TEST_F(Video, FilesOfOneNameAreToldApart) {
  fs::create_directories(folder_ / "a" / "media");
  fs::create_directories(folder_ / "b" / "media");
  const std::vector<std::string> files{counting("a/media/film.mp4"), counting("b/media/film.mp4")};
  Json rig = Json::parse(bytesOf(rigOf({"media", "media_2"})));
  rig["cameras"][1]["fx"] = 77;
  const auto recording = io::openRecording(files, posed(write("rig.json", rig.dump())));
  EXPECT_EQ(recording->cameras()[0].intrinsics.fx, 50);
  EXPECT_EQ(recording->cameras()[1].name, "media_2");
  EXPECT_EQ(recording->cameras()[1].intrinsics.fx, 77);
}

TEST_F(Video, PicturesWhoseOrderNobodyKnowsAreRefused) {
  const std::string file = counting("left.avi");  // B-pictures, for which AVI has no times
  EXPECT_TRUE(refuses([&] { io::openRecording({file}, posed(rigOf({"left"}))); }, {file, "another order", ".mp4"}));
}

TEST_F(Video, NoOtherFileIsOpenedForOne) {
  const std::string other = counting("other.ts");
  const std::string list =
      write("list.mp4", "#EXTM3U\n#EXT-X-TARGETDURATION:2\n#EXTINF:2,\n" + other + "\n#EXT-X-ENDLIST\n");
  const std::string parts = write("parts.mp4", "ffconcat version 1.0\nfile '" + other + "'\n");
  const std::string matroska = write("parts.mkv", "ffconcat version 1.0\nfile '" + other + "'\n");
  EXPECT_TRUE(refuses([&] { io::openRecording({matroska}, posed(rigOf({"parts"}))); }, {matroska, "Matroska"}));
  for (const std::string& file : {list, parts})
    EXPECT_TRUE(refuses(
        [&] {
          io::openRecording({file}, posed(rigOf({"list", "parts"})));
        },
        {file, "must be a video"}));
}

TEST_F(Video, WhatItDoesNotSayMustBeGiven) {
  const std::string file = counting("left.mp4");
  EXPECT_TRUE(refuses([&] { io::openRecording({file}); }, {file, "--poses RIG.json must, with a camera 'left'"}));
  EXPECT_TRUE(refuses([&] { io::openRecording({file}, posed(rigOf({"right"}))); },
                      {"rig.json: has no camera 'left', whose video is " + file}));
  EXPECT_TRUE(refuses([&] { io::openRecording({file}, posed(rigOf({"left"}, 128))); },
                      {file, "64x48", "128x48", "must be of the same size"}));
  const std::string text = write("text.mp4", "no video at all, whatever its name says");
  EXPECT_TRUE(refuses([&] { io::openRecording({text}, posed(rigOf({"text"}))); }, {text, "must be a video"}));
}

TEST_F(Video, OneThatIsCutShortOrDamagedGivesWhatCanBeRead) {
  VideoOptions options;
  options.codec = AV_CODEC_ID_MJPEG;
  options.format = AV_PIX_FMT_YUVJ420P;
  options.pictures = 20;
  const std::string whole = bytesOf(counting("whole.avi", options));
  const std::string rig = rigOf({"cut", "whole"});
  for (const double share : {0.3, 0.6, 0.95}) {
    const std::string cut =
        write("cut.avi", whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
    try {
      const auto recording = io::openRecording({cut}, posed(rig));
      EXPECT_LT(recording->frameCount(), 21u);
      io::LoadedFrame frame;
      for (const std::size_t number : recording->frames()) {
        try {
          recording->read(number, frame);
        } catch (const io::InputError& error) {
          EXPECT_NE(std::string(error.what()).find(cut), std::string::npos) << error.what();
        }
      }
    } catch (const io::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(cut), std::string::npos) << error.what();
    }
  }
  std::string damaged = whole;
  for (std::size_t k = damaged.size() * 3 / 4; k < damaged.size() * 3 / 4 + 400; ++k) damaged[k] = '\x55';
  const auto recording = io::openRecording({write("whole.avi", damaged)}, posed(rig));
  io::LoadedFrame frame;
  int right = 0;
  for (const std::size_t number : recording->frames()) {
    try {
      recording->read(number, frame);
      const int level = frame.rig.views[0].color.row(20)[30].g;  // its range is the full one
      right += std::abs(level - levelOf(static_cast<int>(number))) < 3 ? 1 : 0;
    } catch (const io::InputError&) {  // says so
    }
  }
  EXPECT_GE(right, 8) << "those before it";
}

}  // namespace

#endif  // FUSE_FLOW_WITH_LIBAV
