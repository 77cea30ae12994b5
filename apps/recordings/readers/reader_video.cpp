#include "recordings/files/file_io.h"
#include "recordings/readers/readers.h"
#include "recordings/streams/decoded_video.h"
#include "recordings/streams/recorded_camera.h"
#include "recordings/streams/video_file.h"

#include <fuse_flow/recordings/rig_json.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <map>

namespace fs = std::filesystem;

namespace fuse_flow::io {

bool isVideoFile(const std::string& path) {
  constexpr std::array extensions{".mp4",  ".m4v", ".mov", ".avi",  ".webm", ".mts",
                                  ".m2ts", ".ts",  ".mpg", ".mpeg", ".ogv"};
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
#ifdef FUSE_FLOW_WITH_LIBAV
  if (extension == ".mkv") return isPlainVideo(path);
#endif
  return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

#ifndef FUSE_FLOW_WITH_LIBAV

std::unique_ptr<Recording> openVideos(const std::vector<std::string>& paths, const RecordingOptions& options) {
  return openMkv(paths, options);  // which says what this build lacks
}

#else

namespace {

class VideoPictures : public ImageTrack {
 public:
  explicit VideoPictures(std::unique_ptr<DecodedVideo> video) : video_(std::move(video)) {}
  const std::vector<Nanoseconds>& stamps() const override { return video_->stamps(); }
  void fetch(std::size_t image, std::string& bytes) override { video_->decode(image, bytes); }
  void decode(std::size_t image, const std::string& bytes, LoadedView& into) const override {
    video_->convert(image, bytes, into.color);
  }

 private:
  std::unique_ptr<DecodedVideo> video_;
};

std::string sizeText(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

/** \brief The camera of a video, as rig.json describes it: a camera without depth, of which the colour images' intrinsics matter. */
Camera cameraOf(const DecodedVideo& video, const std::string& name, const std::string& rig_json,
                const RigDescription& rig) {
  const auto entry = std::find_if(rig.cameras.begin(), rig.cameras.end(),
                                  [&](const RigCamera& camera) { return camera.camera.name == name; });
  if (entry == rig.cameras.end())
    throw InputError(rig_json + ": has no camera '" + name + "', whose video is " + video.path());
  const Camera& camera = entry->camera;
  const Intrinsics& K = camera.color ? camera.color->intrinsics : camera.intrinsics;
  if (K.width != video.width() || K.height != video.height())
    throw InputError(video.path() + ": its pictures are " + sizeText(video.width(), video.height()) + " pixels, " +
                     rig_json + " has the intrinsics of " + sizeText(K.width, K.height) + " for camera '" + name +
                     "', must be of the same size");
  return camera;
}

}  // namespace

std::unique_ptr<Recording> openVideos(const std::vector<std::string>& paths, const RecordingOptions& options) {
  if (options.poses.empty())
    throw InputError(
        paths[0] +
        ": a video does not say where its camera stands, nor its intrinsics; --poses RIG.json must, with a "
        "camera '" +
        cameraName(paths[0], paths) + "'");
  if (!options.read_color) throw InputError(paths[0] + ": is a video, which has colour alone");
  const RigDescription rig = readRigJson(options.poses);
  std::vector<RecordedCamera> cameras;
  std::vector<std::string> warnings;
  std::map<std::string, int> known;  // as other cameras of one name are told apart
  for (const std::string& path : paths) {
    std::string name = cameraName(path, paths);
    if (const int before = known[name]++; before > 0) name += "_" + std::to_string(before + 1);
    auto video = std::make_unique<DecodedVideo>(path);
    warnings.insert(warnings.end(), video->warnings().begin(), video->warnings().end());
    RecordedCamera recorded;
    recorded.camera = cameraOf(*video, name, options.poses, rig);
    recorded.posed = true;
    recorded.file = recorded.clock = path;
    recorded.color = std::make_unique<VideoPictures>(std::move(video));
    cameras.push_back(std::move(recorded));
  }
  return openRecordedCameras("video", std::move(cameras), paths, std::move(warnings), options);
}

#endif

}  // namespace fuse_flow::io
