#include "recordings/files/file_io.h"
#include "recordings/images/image_io.h"
#include "recordings/readers/readers.h"
#include "recordings/streams/azure_kinect.h"
#include "recordings/streams/recorded_camera.h"
#include "recordings/streams/video_file.h"

#include <cstdlib>
#include <filesystem>

namespace fs = std::filesystem;

namespace fuse_flow::io {

bool isMkvFile(const std::string& path) { return fs::path(path).extension() == ".mkv"; }

#ifndef FUSE_FLOW_WITH_LIBAV

std::unique_ptr<Recording> openMkv(const std::vector<std::string>& paths, const RecordingOptions&) {
  throw InputError(paths[0] +
                   ": cannot be read, since FUSE-Flow was built without libavformat; install libavformat-dev, "
                   "libavcodec-dev and libswscale-dev, and build it again");
}

#else

namespace {

/** \brief The value of a tag in nanoseconds; 0 where it is not there. */
Nanoseconds duration(const VideoFile& file, const std::string& tag) {
  const auto found = file.tags().find(tag);
  if (found == file.tags().end()) return 0;
  char* end = nullptr;
  const long long value = std::strtoll(found->second.c_str(), &end, 10);
  constexpr long long a_decade = 315'576'000'000'000'000;
  if (end == found->second.c_str() || *end != '\0' || value > a_decade || value < -a_decade)
    throw InputError(file.path() + ": " + tag + " is '" + found->second + "', must be a number of nanoseconds");
  return value;
}

std::string tagOf(const std::map<std::string, std::string>& tags, const std::string& name) {
  const auto found = tags.find(name);
  return found == tags.end() ? "" : found->second;
}

/** \brief What the tracks of a file share. */
class MkvTrack : public ImageTrack {
 public:
  MkvTrack(std::shared_ptr<VideoFile> file, const VideoTrack& track, Nanoseconds start)
      : file_(std::move(file)), track_(track), stamps_(track.stamps) {
    for (Nanoseconds& stamp : stamps_) stamp += start;
  }
  const std::vector<Nanoseconds>& stamps() const override { return stamps_; }
  void fetch(std::size_t image, std::string& bytes) override { bytes = file_->packet(track_, image); }

 protected:
  std::string nameOf(std::size_t image) const {
    return file_->path() + ": image " + std::to_string(image) + " of the track " + track_.title;
  }
  const VideoTrack& track() const { return track_; }

 private:
  std::shared_ptr<VideoFile> file_;
  const VideoTrack& track_;
  std::vector<Nanoseconds> stamps_;
};

class MkvDepth : public MkvTrack {
 public:
  using MkvTrack::MkvTrack;
  void decode(std::size_t image, const std::string& bytes, LoadedView& into) const override {
    into.depth32.resize(0, 0);
    into.depth16.resize(track().width, track().height);
    std::vector<std::uint16_t>& pixels = into.depth16.data;
    if (bytes.size() != 2 * pixels.size())
      throw InputError(nameOf(image) + ": has " + std::to_string(bytes.size()) + " bytes, must have " +
                       std::to_string(2 * pixels.size()));
    const auto* from = reinterpret_cast<const std::uint8_t*>(bytes.data());
    for (std::size_t k = 0; k < pixels.size(); ++k)
      pixels[k] = static_cast<std::uint16_t>(from[2 * k] << 8 | from[2 * k + 1]);
  }
};

class MkvColor : public MkvTrack {
 public:
  using MkvTrack::MkvTrack;
  void decode(std::size_t image, const std::string& bytes, LoadedView& into) const override {
    const int w = track().width, h = track().height;
    if (track().codec == VideoCodec::Mjpeg)
      decodeColor(nameOf(image), bytes, into.color, [&](int width, int height) {
        if (width != w || height != h)
          throw InputError(nameOf(image) + ": is " + std::to_string(width) + "x" + std::to_string(height) +
                           " pixels, the track is " + std::to_string(w) + "x" + std::to_string(h));
      });
    else
      convertColor(nameOf(image), track().codec, w, h, bytes, into.color);
  }
};

/** \brief "MJPG_720P" is 720P. */
std::string colorMode(const VideoTrack& track) {
  const std::string mode = tagOf(track.tags, "K4A_COLOR_MODE");
  return mode.substr(mode.find('_') + 1);
}

void checkSize(const std::string& path, const VideoTrack& track, const Intrinsics& K) {
  if (track.width == K.width && track.height == K.height) return;
  throw InputError(path + ": its track " + track.title + " is " + std::to_string(track.width) + "x" +
                   std::to_string(track.height) + " pixels, its mode is " + std::to_string(K.width) + "x" +
                   std::to_string(K.height));
}

const VideoTrack& depthTrack(const VideoFile& file) {
  const VideoTrack* track = file.track("DEPTH");
  if (!track || track->stamps.empty())
    throw InputError(
        file.path() +
        ": has no depth images, must be recorded with a depth mode, as k4arecorder does with -d NFOV_UNBINNED");
  if (track->codec != VideoCodec::Grey16BigEndian)
    throw InputError(file.path() + ": its depth is encoded as " + track->codec_name +
                     ", must be b16g: 16 bits, big endian, not compressed");
  return *track;
}

/** \brief Null, where it has none, or none was wanted. */
const VideoTrack* colorTrack(const VideoFile& file) {
  const VideoTrack* track = file.track("COLOR");
  if (!track || track->stamps.empty()) return nullptr;
  if (track->codec == VideoCodec::Other || track->codec == VideoCodec::Grey16BigEndian)
    throw InputError(file.path() + ": its colour is encoded as " + track->codec_name +
                     ", must be MJPG, NV12, YUY2 or BGRA");
  return track;
}

/** \brief Devices that a cable synchronises stamp with one clock, which starts with the master. */
std::string clockOf(const VideoFile& file) {
  const std::string mode = tagOf(file.tags(), "K4A_WIRED_SYNC_MODE");
  return mode == "MASTER" || mode == "SUBORDINATE" ? "the synchronisation cable" : file.path();
}

RecordedCamera openCamera(const std::string& path, const std::string& name, bool read_color,
                          std::vector<std::string>& warnings) {
  const auto file = std::make_shared<VideoFile>(
      path, read_color ? std::vector<std::string>{"DEPTH", "COLOR"} : std::vector<std::string>{"DEPTH"});
  warnings.insert(warnings.end(), file->warnings().begin(), file->warnings().end());
  const std::string calibration = file->attachment("calibration.json");
  if (calibration.empty())
    throw InputError(path +
                     ": has no calibration.json attached, must be a recording of an Azure Kinect or an Orbbec Femto by "
                     "k4arecorder");
  const VideoTrack& depth = depthTrack(*file);
  const VideoTrack* color = colorTrack(*file);
  RecordedCamera recorded;
  recorded.camera = azureKinectCamera(path + ": calibration.json", calibration,
                                      {tagOf(depth.tags, "K4A_DEPTH_MODE"), color ? colorMode(*color) : ""});
  checkSize(path, depth, recorded.camera.intrinsics);
  if (color) checkSize(path, *color, recorded.camera.color->intrinsics);
  recorded.camera.name = name;
  recorded.file = path;
  recorded.clock = clockOf(*file);
  recorded.depth_delay = duration(*file, "K4A_DEPTH_DELAY_NS");
  const Nanoseconds start = duration(*file, "K4A_START_OFFSET_NS");
  recorded.depth = std::make_unique<MkvDepth>(file, depth, start);
  if (color) recorded.color = std::make_unique<MkvColor>(file, *color, start);
  return recorded;
}

}  // namespace

std::unique_ptr<Recording> openMkv(const std::vector<std::string>& paths, const RecordingOptions& options) {
  std::vector<RecordedCamera> cameras;
  std::vector<std::string> warnings;
  for (const std::string& path : paths)
    cameras.push_back(openCamera(path, cameraName(path, paths), options.read_color, warnings));
  return openRecordedCameras("mkv", std::move(cameras), paths, std::move(warnings), options);
}

#endif

}  // namespace fuse_flow::io
