#include "recordings/calibrations/calibration.h"
#include "recordings/range.h"
#include "recordings/readers/view_files.h"
#include "recordings/streams/recorded_camera.h"
#include "recordings/streams/time_matching.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>

namespace fuse_flow::io {
namespace {

/** \brief What makes its frames. */
const ImageTrack& pacemaker(const RecordedCamera& camera) { return camera.depth ? *camera.depth : *camera.color; }

class RecordedRig : public Recording {
 public:
  RecordedRig(std::string kind, std::vector<RecordedCamera> cameras, std::vector<std::string> files,
              std::vector<std::string> warnings, const RecordingOptions& options)
      : kind_(std::move(kind)),
        recorded_(std::move(cameras)),
        files_(std::move(files)),
        read_color_(options.read_color),
        time_offsets_(options.time_offsets),
        loading_(options) {
    warnings_ = std::move(warnings);
    for (const RecordedCamera& recorded : recorded_) cameras_.push_back(recorded.camera);
    group();
    for (std::size_t c = 0; c < recorded_.size(); ++c) matchColor(c);
  }

  std::string kind() const override { return kind_; }
  std::size_t frameCount() const override { return sets_.size(); }
  std::optional<double> framesPerSecond() const override {
    std::vector<Nanoseconds> stamps;
    for (const FrameSet& set : sets_) stamps.push_back(set.stamp);
    const Nanoseconds period = framePeriod(stamps);
    return period > 0 ? std::optional(1e9 / static_cast<double>(period)) : std::nullopt;
  }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  bool hasDepth(std::size_t camera) const override { return recorded_[camera].depth != nullptr; }
  bool hasColor(std::size_t camera) const override { return read_color_ && recorded_[camera].color; }
  std::vector<std::string> inputs() const override { return files_; }
  std::size_t imagesWithoutPartner(std::size_t camera) const override { return without_partner_[camera]; }

  bool readsConcurrently() const override { return true; }
  void read(std::size_t frame, LoadedFrame& out) override {
    const FrameSet& set = sets_.at(frame);
    out.rig.cameras = cameras_;
    out.rig.views.resize(cameras_.size());
    out.images.resize(cameras_.size());
    out.rig.stamp = static_cast<std::uint64_t>(std::max<Nanoseconds>(0, set.stamp / 1000));
    out.damaged.clear();
    out.ended.clear();
    std::vector<Fetched> fetched = fetchAll(set);
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      out.rig.views[c] = DepthView();
      out.images[c].color_file.clear();
      if (frame >= ends_[c]) out.ended.push_back({c, ending(c)});
    }
    const auto decode_view = [&](std::size_t c) { decode(c, fetched[c], out.images[c], out.rig.views[c]); };
    loading_.load(cameras_.size(), decode_view, out);
    const std::lock_guard<std::mutex> lock(mutex_);
    spare_.push_back(std::move(fetched));
  }

 private:
  /** \brief The bytes of a view's images. */
  struct Fetched {
    std::optional<std::size_t> depth, color;  ///< the images' numbers
    std::string depth_bytes, color_bytes;
    std::string damage;  ///< why there are none
  };

  /** \brief Files are read by one thread at a time; what is in them is decoded by many. */
  std::vector<Fetched> fetchAll(const FrameSet& set) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<Fetched> fetched;
    if (!spare_.empty()) {
      fetched = std::move(spare_.back());
      spare_.pop_back();
    }
    fetched.resize(cameras_.size());
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      fetched[c].damage.clear();
      if (!loading_.reads(c, cameras_.size())) continue;
      try {
        fetch(c, set.images[c], fetched[c]);
      } catch (const InputError& error) {
        if (!loading_.skipsDamaged()) throw;
        fetched[c].damage = error.what();
      }
    }
    return fetched;
  }

  void fetch(std::size_t c, std::optional<std::size_t> image, Fetched& fetched) {
    const RecordedCamera& recorded = recorded_[c];
    fetched.depth = recorded.depth ? image : std::nullopt;
    fetched.color = !image || !hasColor(c) ? std::nullopt : recorded.depth ? color_of_[c][*image] : image;
    if (fetched.depth) recorded.depth->fetch(*fetched.depth, fetched.depth_bytes);
    if (fetched.color) recorded.color->fetch(*fetched.color, fetched.color_bytes);
  }

  void decode(std::size_t c, const Fetched& fetched, LoadedView& images, DepthView& view) const {
    if (!fetched.damage.empty()) throw InputError(fetched.damage);
    if (fetched.depth) {
      recorded_[c].depth->decode(*fetched.depth, fetched.depth_bytes, images);
      view.depth16 = images.depth16.view();
      view.depth32 = images.depth32.view();
    }
    if (!fetched.color) return;
    recorded_[c].color->decode(*fetched.color, fetched.color_bytes, images);
    view.color = images.color.view();
  }

  /** \brief Puts the clocks of recorders that nothing ties together to the same start. */
  std::vector<Nanoseconds> clockOffsets() {
    std::map<std::string, Nanoseconds> starts;
    for (const RecordedCamera& recorded : recorded_) {
      const Nanoseconds start = pacemaker(recorded).stamps().front();
      const auto [known, inserted] = starts.emplace(recorded.clock, start);
      if (!inserted) known->second = std::min(known->second, start);
    }
    std::vector<Nanoseconds> offsets(recorded_.size(), 0);
    for (std::size_t c = 0; c < recorded_.size() && !time_offsets_.empty(); ++c) {
      const auto file = std::find(files_.begin(), files_.end(), recorded_[c].file);
      const double seconds = time_offsets_.at(static_cast<std::size_t>(file - files_.begin()));
      offsets[c] = static_cast<Nanoseconds>(std::llround(1e9 * seconds));
      if (starts.size() > 1) offsets[c] -= starts.at(recorded_[c].clock);
    }
    if (starts.size() < 2 || !time_offsets_.empty()) return offsets;
    warnings_.push_back(
        "nothing says how the clocks of " + recorded_[0].file +
        " and the others relate; their first images are taken to be of the same moment, which only a cable or a shared "
        "clock makes sure; --time-offsets says by how many seconds each began later");
    for (std::size_t c = 0; c < recorded_.size(); ++c) offsets[c] = -starts.at(recorded_[c].clock);
    return offsets;
  }

  void group() {
    const std::vector<Nanoseconds> offsets = clockOffsets();
    std::vector<std::vector<Nanoseconds>> stamps;
    for (std::size_t c = 0; c < recorded_.size(); ++c) {
      stamps.push_back(pacemaker(recorded_[c]).stamps());
      for (Nanoseconds& stamp : stamps.back()) stamp += offsets[c];
    }
    std::vector<CameraTimes> times;
    for (std::size_t c = 0; c < recorded_.size(); ++c)
      times.push_back(
          {cameras_[c].name, recorded_[c].file, std::move(stamps[c]), pacemaker(recorded_[c]).stamps().front()});
    FrameSets grouped = framesByTime(times, warnings_);
    sets_ = std::move(grouped.sets);
    without_partner_ = std::move(grouped.unused);
    ends_.assign(recorded_.size(), 0);
    for (std::size_t frame = 0; frame < sets_.size(); ++frame)
      for (std::size_t c = 0; c < recorded_.size(); ++c)
        if (sets_[frame].images[c]) ends_[c] = frame + 1;
  }

  /** \brief The colour image of each depth image: the nearest one, within half of the colour camera's period. */
  void matchColor(std::size_t c) {
    color_of_.emplace_back();
    const RecordedCamera& recorded = recorded_[c];
    if (!recorded.depth || !recorded.color) return;
    color_of_[c] = colorByTime(cameras_[c].name, recorded.depth->stamps(), recorded.color->stamps(),
                               recorded.depth_delay, warnings_);
  }

  std::string ending(std::size_t c) const {
    return "camera '" + cameras_[c].name + "' ends after " + std::to_string(ends_[c]) + " of " +
           std::to_string(sets_.size()) + " frames";
  }

  std::string kind_;
  std::vector<RecordedCamera> recorded_;
  std::vector<std::string> files_;
  bool read_color_;
  std::vector<double> time_offsets_;  ///< of each file, seconds; none: what the files say
  ViewLoading loading_;
  std::vector<Camera> cameras_;
  std::vector<FrameSet> sets_;
  std::vector<std::size_t> without_partner_;
  std::mutex mutex_;                                               ///< of the files, and of spare_
  std::vector<std::vector<Fetched>> spare_;                        ///< memory
  std::vector<std::size_t> ends_;                                  ///< of each camera, the frame behind its last one
  std::vector<std::vector<std::optional<std::size_t>>> color_of_;  ///< of each camera's depth images, the colour image
};

/** \brief Those that RecordingOptions::views chooses. */
std::vector<RecordedCamera> chosen(std::vector<RecordedCamera> cameras, const std::string& views) {
  if (views.empty()) return cameras;
  std::vector<RecordedCamera> result;
  for (const std::size_t c : parseRange(views, cameras.size(), "--views")) result.push_back(std::move(cameras[c]));
  return result;
}

/** \brief Takes out cameras without an image, and tracks of colour without one. */
void dropEmpty(std::vector<RecordedCamera>& cameras, std::vector<std::string>& warnings) {
  const auto empty = [](const std::unique_ptr<ImageTrack>& track) { return track && track->stamps().empty(); };
  std::vector<RecordedCamera> filled;
  for (RecordedCamera& recorded : cameras) {
    if (empty(recorded.color)) recorded.color.reset();
    if (recorded.depth ? empty(recorded.depth) : !recorded.color)
      warnings.push_back(recorded.file + ": camera '" + recorded.camera.name + "' has no images, and is left out");
    else
      filled.push_back(std::move(recorded));
  }
  cameras = std::move(filled);
}

/** \brief Cameras that messages, rig.json and --poses can tell apart. */
void makeNamesUnique(std::vector<RecordedCamera>& cameras) {
  std::map<std::string, int> known;
  for (RecordedCamera& recorded : cameras)
    if (const int before = known[recorded.camera.name]++; before > 0)
      recorded.camera.name += "_" + std::to_string(before + 1);
}

void requirePoses(const std::string& kind, const std::vector<RecordedCamera>& cameras, const RecordingOptions& options,
                  std::vector<std::string>& warnings) {
  if (!options.poses.empty() || cameras.size() < 2) return;
  const auto lost = std::find_if(cameras.begin(), cameras.end(), [](const RecordedCamera& c) { return !c.posed; });
  if (lost == cameras.end()) return;
  const std::string message = lost->file + ": does not say where camera '" + lost->camera.name + "' stands";
  if (!options.without_poses)
    throw InputError(message + "; --poses RIG.json must, as fuse_flow_calibrate writes it from such a " + kind);
  warnings.push_back(message + "; it begins at the world's origin");
}

}  // namespace

std::unique_ptr<Recording> openRecordedCameras(std::string kind, std::vector<RecordedCamera> cameras,
                                               std::vector<std::string> files, std::vector<std::string> warnings,
                                               const RecordingOptions& options) {
  if (options.slide != 0)
    throw OptionError("--slide: " + files[0] + " is a recording of cameras that stand, must be 0");
  if (!options.intrinsics.empty())
    throw OptionError("--intrinsics: " + files[0] + " has the intrinsics of its cameras, must not be given");
  dropEmpty(cameras, warnings);
  if (cameras.empty()) throw InputError(files[0] + ": has no images of a camera");
  makeNamesUnique(cameras);
  cameras = chosen(std::move(cameras), options.views);
  for (RecordedCamera& recorded : cameras) {
    if (options.depth_scale) recorded.camera.depth_scale = *options.depth_scale;
    checkCameraInput(recorded.file, recorded.camera);
  }
  requirePoses(kind, cameras, options, warnings);
  return std::make_unique<RecordedRig>(std::move(kind), std::move(cameras), std::move(files), std::move(warnings),
                                       options);
}

std::string cameraName(const std::string& path, const std::vector<std::string>& paths) {
  const auto stem = [](const std::string& file) { return std::filesystem::path(file).stem().string(); };
  const bool unique = std::count_if(paths.begin(), paths.end(),
                                    [&](const std::string& other) { return stem(other) == stem(path); }) == 1;
  const std::string folder = std::filesystem::absolute(path).parent_path().filename().string();
  return unique || folder.empty() ? stem(path) : folder;
}

}  // namespace fuse_flow::io
