#include "recordings/image_folders/rig_images.h"

#include "recordings/files/file_io.h"
#include "recordings/image_folders/image_names.h"
#include "recordings/image_folders/timestamps_file.h"
#include "recordings/readers/view_files.h"
#include "recordings/streams/time_matching.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <set>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

std::vector<Nanoseconds> stampsOf(const NamedImages& images) {
  std::vector<Nanoseconds> stamps;
  for (const NamedImage& image : images.images) stamps.push_back(*image.stamp);
  return stamps;
}

/** \brief A folder's images as their names tell, and those of them that count where frames are put together by time. */
struct FoundImages {
  NamedImages all;
  NamedImages timed;
};

/** \brief With the times of the first list that is there. A list that cannot be used hinders no recording whose names are enough. */
FoundImages imagesOfFolder(const std::string& folder, const std::string& kind, bool (*is_image)(const std::string&),
                           const std::vector<std::string>& lists, std::vector<std::string>& warnings) {
  FoundImages found;
  found.all = namedImages(folder, kind, is_image, warnings);
  found.timed = found.all;
  const auto list = std::find_if(lists.begin(), lists.end(), isThere);
  if (list == lists.end() || found.all.images.empty()) return found;
  try {
    readTimestamps(*list, found.timed, warnings);
  } catch (const InputError& error) {
    warnings.push_back(std::string(error.what()) + "; its times are not used");
    found.timed = found.all;
    return found;
  }
  std::vector<std::size_t> kept;
  ascendingStamps(*list, stampsOf(found.timed), kept, warnings);
  std::vector<NamedImage> ascending;
  for (const std::size_t k : kept) ascending.push_back(std::move(found.timed.images[k]));
  found.timed.images = std::move(ascending);
  return found;
}

std::string timestampsIn(const std::string& folder) { return (fs::path(folder) / "timestamps.txt").string(); }

FoundImages pacemakerOf(const CameraFolders& camera, std::vector<std::string>& warnings) {
  const bool depth = !camera.depth.empty();
  const std::string& folder = depth ? camera.depth : camera.color;
  return imagesOfFolder(folder, depth ? "depth" : "colour", depth ? isDepthImage : isImage,
                        {timestampsIn(folder), timestampsIn(camera.own)}, warnings);
}

std::string pathOfFirst(const NamedImages& images) {
  return (fs::path(images.folder) / images.images[0].name).string();
}

/** \brief The place of each camera's images among the frames. */
using Places = std::vector<std::vector<std::optional<std::size_t>>>;

Places placesByNumber(const std::vector<NamedImages>& cameras) {
  Places places;
  for (const NamedImages& images : cameras) {
    places.emplace_back();
    for (const NamedImage& image : images.images) places.back().push_back(image.number);
  }
  return places;
}

Places placesByTime(const std::vector<NamedImages>& cameras, const FrameSets& grouped) {
  Places places;
  for (const NamedImages& images : cameras) places.emplace_back(images.images.size());
  for (std::size_t frame = 0; frame < grouped.sets.size(); ++frame)
    for (std::size_t c = 0; c < cameras.size(); ++c)
      if (const auto& image = grouped.sets[frame].images[c]) places[c][*image] = frame;
  return places;
}

/** \brief The frame by time of each number; none if an image is in no frame, or frames by time and by number have other images. */
std::optional<std::map<std::size_t, std::size_t>> sameFrames(const Places& by_number, const Places& by_time) {
  std::map<std::size_t, std::size_t> time_of, number_of;
  for (std::size_t c = 0; c < by_number.size(); ++c)
    for (std::size_t k = 0; k < by_number[c].size(); ++k) {
      if (!by_time[c][k]) return std::nullopt;
      const std::size_t number = *by_number[c][k], frame = *by_time[c][k];
      if (time_of.emplace(number, frame).first->second != frame) return std::nullopt;
      if (number_of.emplace(frame, number).first->second != number) return std::nullopt;
    }
  return time_of;
}

bool anyShared(const Places& places) {
  std::set<std::size_t> known;
  for (const auto& camera : places) {
    for (const auto& place : camera)
      if (place && known.count(*place) > 0) return true;
    for (const auto& place : camera)
      if (place) known.insert(*place);
  }
  return false;
}

/** \brief Puts the images of cameras together. */
class Frames {
 public:
  Frames(const std::string& recording, const std::vector<CameraFolders>& folders, std::vector<FoundImages> found,
         std::vector<std::string>& warnings)
      : recording_(recording), folders_(folders), warnings_(warnings) {
    for (FoundImages& images : found) {
      all_.push_back(std::move(images.all));
      cameras_.push_back(std::move(images.timed));
    }
    for (const NamedImages& images : cameras_) {
      if (images.images.empty()) continue;
      const NamedImages*& first = images.timed() ? timed_ : untimed_;
      if (first == nullptr) first = &images;
      numbered_ = numbered_ && images.numbered();
    }
  }

  /** \brief Of each camera, those that have a place or could have one. */
  const std::vector<NamedImages>& cameras() const { return cameras_; }

  /** \brief Fills stamps and by_time of the result. */
  Places place(RigImages& result) {
    if (timed_ == nullptr) return placesByNumber(cameras_);
    if (untimed_ != nullptr) {
      refuseTimesBesideNumbers();
      return withoutTimes("the times in " + timed_->times_from + " are not used: " + pathOfFirst(*untimed_) +
                          " and the others of its folder have none");
    }
    std::vector<std::string> of_times;
    const FrameSets grouped = framesByTime(cameraTimes(), of_times);
    Places by_time = placesByTime(cameras_, grouped);
    if (numbered_ && !anyShared(by_time) && anyShared(placesByNumber(all_)))
      return withoutTimes(
          "the times of no two cameras are near each other (" + timed_->times_from +
          "), as if they were of different clocks; frames are put together by number, and have no time");
    warnings_.insert(warnings_.end(), of_times.begin(), of_times.end());
    if (numbered_ && noneLeftOut())
      if (const auto same = sameFrames(placesByNumber(cameras_), by_time)) {
        for (const auto& [number, frame] : *same) result.stamps[number] = grouped.sets[frame].stamp;
        return placesByNumber(cameras_);
      }
    result.by_time = true;
    result.without_partner = grouped.unused;
    for (std::size_t frame = 0; frame < grouped.sets.size(); ++frame) result.stamps[frame] = grouped.sets[frame].stamp;
    say("frames are put together by the times in " + timed_->times_from + periodOf(grouped) +
        (numbered_ ? "; the numbers of the images would put others together, and are not used" : ""));
    return by_time;
  }

 private:
  void say(const std::string& line) { warnings_.push_back(recording_ + ": " + line); }

  Places withoutTimes(const std::string& why) {
    say(why);
    cameras_ = all_;
    return placesByNumber(cameras_);
  }

  bool noneLeftOut() const {
    for (std::size_t c = 0; c < cameras_.size(); ++c)
      if (cameras_[c].images.size() < all_[c].images.size()) return false;
    return true;
  }

  std::vector<CameraTimes> cameraTimes() const {
    std::vector<CameraTimes> times;
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      times.push_back({folders_[c].camera, cameras_[c].folder, stampsOf(cameras_[c]), 0});
      if (!times.back().stamps.empty()) times.back().begins = times.back().stamps.front();
    }
    return times;
  }

  void refuseTimesBesideNumbers() const {
    for (const NamedImages& images : cameras_)
      if (!images.images.empty() && !images.numbered())
        throw InputError(pathOfFirst(*untimed_) + ": its name is a number, and that of " + pathOfFirst(images) +
                         " a time; the images of all cameras must have numbers, or all times, in their names or in "
                         "timestamps.txt");
  }

  static std::string periodOf(const FrameSets& grouped) {
    std::vector<Nanoseconds> stamps;
    for (const FrameSet& set : grouped.sets) stamps.push_back(set.stamp);
    char text[64] = "";
    if (stamps.size() > 1)
      std::snprintf(text, sizeof text, ", one each %.4g ms", static_cast<double>(framePeriod(stamps)) * 1e-6);
    return text;
  }

  const std::string& recording_;
  const std::vector<CameraFolders>& folders_;
  std::vector<std::string>& warnings_;
  std::vector<NamedImages> all_, cameras_;
  const NamedImages *timed_{nullptr}, *untimed_{nullptr};  ///< the first of each, where there is one
  bool numbered_{true};                                    ///< all of them
};

std::vector<std::optional<std::size_t>> sameNumber(const NamedImages& images, const NamedImages& others) {
  std::map<std::size_t, std::size_t> by_number;
  for (std::size_t k = 0; k < others.images.size(); ++k) by_number[*others.images[k].number] = k;
  std::vector<std::optional<std::size_t>> matches;
  for (const NamedImage& image : images.images) {
    const auto found = by_number.find(*image.number);
    matches.push_back(found == by_number.end() ? std::nullopt : std::optional(found->second));
  }
  return matches;
}

/** \brief Images that go with depth. */
struct Companions {
  std::string kind;  ///< "colour" or "confidence"
  std::string folder;
  bool (*is_image)(const std::string&);
};

/** \brief Those of a camera's frames; absent where they have the names of the depth images, or their numbers, as they are read. */
std::optional<FilesByFrame> companionsOf(const CameraFolders& camera, const Companions& kind, const NamedImages& depth,
                                         const std::vector<std::optional<std::size_t>>& places, bool by_time,
                                         std::vector<std::string>& warnings) {
  NamedImages others;
  try {
    others = imagesOfFolder(kind.folder, kind.kind, kind.is_image, {timestampsIn(kind.folder)}, warnings).timed;
  } catch (const InputError& error) {
    if (by_time || !depth.plain) throw;
    warnings.push_back(std::string(error.what()) + "; those with the names of the depth images are taken");
    return std::nullopt;
  }
  const bool same_names = depth.plain && !others.timed() && (others.plain || others.images.empty());
  if (!by_time && (same_names || depth.images.empty())) return std::nullopt;
  FilesByFrame files;
  if (depth.images.empty() || others.images.empty()) return files;
  std::vector<std::optional<std::size_t>> matches;
  std::vector<std::string> of_times;
  if (depth.timed() && others.timed()) {
    matches = colorByTime(camera.camera, stampsOf(depth), stampsOf(others), 0, of_times);
    if (kind.kind == "colour") warnings.insert(warnings.end(), of_times.begin(), of_times.end());
  } else if (depth.numbered() && others.numbered()) {
    matches = sameNumber(depth, others);
  } else {
    warnings.push_back(kind.folder + ": its images are not used, nothing says which of them belongs to which of " +
                       depth.folder + "; both must have numbers, or both times");
    return files;
  }
  for (std::size_t k = 0; k < places.size(); ++k)
    if (places[k] && matches[k]) files[*places[k]] = (fs::path(kind.folder) / others.images[*matches[k]].name).string();
  return files;
}

}  // namespace

RigImages rigImages(const std::string& recording, const std::vector<CameraFolders>& cameras,
                    std::vector<std::string>& warnings) {
  std::vector<FoundImages> found;
  for (const CameraFolders& camera : cameras) found.push_back(pacemakerOf(camera, warnings));
  RigImages result;
  Frames frames(recording, cameras, std::move(found), warnings);
  const Places places = frames.place(result);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const NamedImages& images = frames.cameras()[c];
    CameraImages& camera = result.cameras.emplace_back();
    for (std::size_t k = 0; k < places[c].size(); ++k)
      if (places[c][k]) camera.images[*places[c][k]] = images.images[k].name;
    if (cameras[c].depth.empty()) continue;
    const auto companions = [&](const Companions& kind) {
      return companionsOf(cameras[c], kind, images, places[c], result.by_time, warnings);
    };
    if (!cameras[c].color.empty()) camera.color = companions({"colour", cameras[c].color, isImage});
    camera.confidence = companions({"confidence", cameras[c].confidence, isConfidenceImage});
  }
  return result;
}

}  // namespace fuse_flow::io
