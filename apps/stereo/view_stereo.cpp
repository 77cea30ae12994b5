#include "stereo/view_stereo.h"

#include "command_line/message_of.h"
#include "stereo/stereo_geometry.h"

#include <fuse_flow/device_error.h>

#include <pcl/exceptions.h>

#include <algorithm>
#include <cstdio>
#include <new>
#include <sstream>

namespace fuse_flow::io {
namespace {

constexpr double kFewAgree = 0.1;  // of the pixels of a frame: then something is wrong with all of it

std::string counted(std::size_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

/** \brief Share of the pixels of an image that are black, or white, to which no exposure suits. */
double shareOf(const ImageView<Rgb8>& image, bool (*is)(int level)) {
  constexpr int step = 4;  // pixels
  std::size_t found = 0, all = 0;
  for (int v = 0; v < image.height; v += step)
    for (int u = 0; u < image.width; u += step) {
      const Rgb8& pixel = image.row(v)[u];
      ++all;
      found += is((pixel.r + pixel.g + pixel.b) / 3) ? 1 : 0;
    }
  return static_cast<double>(found) / static_cast<double>(all);
}

/** \brief The colour images that are black or white, in words; empty: none is. */
std::string withoutContent(const RigFrame& rig) {
  std::string names;
  std::size_t count = 0;
  for (std::size_t k = 0; k < rig.views.size(); ++k) {
    const ImageView<Rgb8>& image = rig.views[k].color;
    if (!image) continue;
    const bool black = shareOf(image, [](int level) { return level < 8; }) > 0.9;
    const bool white = shareOf(image, [](int level) { return level > 247; }) > 0.9;
    if (!black && !white) continue;
    if (++count <= 3) names += (names.empty() ? "" : ", ") + rig.cameras[k].name + (black ? " (black)" : " (white)");
  }
  if (count == 0) return "";
  return counted(count, "image") + (count == 1 ? " is" : " are") + " black or white: " + names +
         (count > 3 ? ", …" : "");
}

}  // namespace

ViewStereo::ViewStereo(std::vector<Camera> cameras, std::vector<bool> lacks_depth, const std::vector<bool>& has_color,
                       std::string path, StereoOptions options)
    : cameras_(std::move(cameras)),
      lacks_depth_(std::move(lacks_depth)),
      path_(std::move(path)),
      options_(std::move(options)),
      all_(std::all_of(lacks_depth_.begin(), lacks_depth_.end(), [](bool lacks) { return lacks; })) {
  look(has_color);
  if (estimatedViews() > 0)
    stereo_ = makeDepthEstimation(options_.parameters, options_.threads, options_.device, options_.warn);
}

/** \brief At what can be told before any image is read. */
void ViewStereo::look(const std::vector<bool>& has_color) {
  const auto images = static_cast<std::size_t>(std::count(has_color.begin(), has_color.end(), true));
  StereoSetup setup = stereoSetup(cameras_, has_color, options_.parameters);
  geometry_ = std::move(setup.geometry);
  for (std::size_t k = 0; k < cameras_.size(); ++k)
    if (lacks_depth_[k]) cameras_[k] = std::move(setup.cameras[k]);
  std::size_t views = 0;
  std::string first;
  for (std::size_t k = 0; k < cameras_.size(); ++k) {
    if (!lacks_depth_[k]) continue;
    if (first.empty()) first = cameras_[k].name;
    views += geometry_[k].sources.empty() ? 0 : 1;
  }
  if (views == 0) {
    const std::string why =
        images < 2
            ? "camera '" + first +
                  "' has no depth, and no other camera has colour images to compare with: depth is estimated from "
                  "two or more that see the same"
            : "no two of " + counted(images, "camera") +
                  " with colour images see the same between --stereo-min-depth and --stereo-max-depth, so that no "
                  "depth can be estimated; are the poses right (--pose-convention), and in metres?";
    if (all_) throw InputError(path_ + ": " + why + (images < 2 ? "; --no-stereo leaves it without" : ""));
    warnings_.push_back(why + (images < 2 ? "; it is missing" : ""));
    return;
  }
  const std::string from = "estimated from the colour images of " + counted(images, "view");
  std::string line =
      all_ ? "depth is " + from
           : "depth of " + std::to_string(views) + " of " + counted(cameras_.size(), "view") + " is " + from;
  line += " (options --stereo-…)";
  const std::string also = all_ && options_.all_estimated ? options_.all_estimated(views) : "";
  if (!also.empty()) line += "; " + also;
  warnings_.push_back(line);
  for (std::string& warning : stereoWarnings(cameras_, lacks_depth_, geometry_, options_.parameters))
    warnings_.push_back(std::move(warning));
}

void ViewStereo::complete(const std::string& of_frame, LoadedFrame& out) {
  agreeing_ = seconds_ = 0;
  if (!stereo_) return;
  estimate(of_frame, out);
  for (std::size_t k = 0; k < lacks_depth_.size(); ++k)
    if (lacks_depth_[k]) out.rig.cameras[k] = cameras_[k];
}

void ViewStereo::estimate(const std::string& of_frame, LoadedFrame& out) {
  const auto images = std::count_if(out.rig.views.begin(), out.rig.views.end(),
                                    [](const DepthView& view) { return static_cast<bool>(view.color); });
  if (images < 2) {
    warnOnce("few", of_frame + ": " + counted(static_cast<std::size_t>(images), "view") +
                        (images == 1 ? " has" : " have") +
                        " a colour image, must be two or more for depth to be estimated; its views without depth are "
                        "missing");
    return;
  }
  try {
    checkCalibration(of_frame, out.rig);
    stereo_->estimate(out.rig, found_);
  } catch (const DeviceError& error) {
    throw DeviceError(path_ + ": " + of_frame + ": " + messageOf(error));
  } catch (const pcl::PCLException& error) {
    throw InputError(path_ + ": " + of_frame + ": " + messageOf(error));
  } catch (const std::bad_alloc&) {
    throw InputError(path_ + ": " + of_frame + ": not enough memory to estimate depth from " +
                     counted(static_cast<std::size_t>(images), "colour image") + "; --views leaves some out");
  }
  std::size_t pixels = 0, agreeing = 0;
  for (std::size_t k = 0; k < lacks_depth_.size(); ++k) {
    if (!lacks_depth_[k] || !out.rig.views[k].color) continue;
    StereoView& view = found_.views[k];
    const Intrinsics& K = found_.rig.cameras[k].intrinsics;
    pixels += static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height);
    agreeing += view.agreeing;
    if (view.geometry.sources.empty()) continue;
    LoadedView& to = out.images[k];
    to.depth16.resize(0, 0);
    for (FloatImage* image : {&to.depth32, &to.confidence}) {
      image->width = K.width;
      image->height = K.height;
    }
    to.depth32.data.swap(view.depth);
    to.confidence.data.swap(view.confidence);
    to.assumed_confidence_step = 0;
    out.rig.views[k].depth32 = to.depth32.view();
    out.rig.views[k].confidence = to.confidence.view();
  }
  seconds_ = found_.total_ms / 1000;
  if (pixels > 0) agreeing_ = static_cast<double>(agreeing) / static_cast<double>(pixels);
  ++frames_;
  pixels_ += pixels;
  agreeing_pixels_ += agreeing;
  all_seconds_ += seconds_;
  checkImages(of_frame, out.rig);
}

void ViewStereo::checkImages(const std::string& of_frame, const RigFrame& rig) {
  const std::string empty = withoutContent(rig);
  if (!empty.empty())
    warnOnce("content",
             of_frame + ": " + empty + "; nothing can be matched there, must be exposed to show what is seen");
  if (agreeing_ >= kFewAgree) return;
  std::ostringstream share;
  share.precision(2);
  share << 100 * agreeing_;
  warnOnce("agreement",
           of_frame + ": another view agrees on the depth of " + share.str() +
               " % of the pixels, must be most; are poses and intrinsics right, with distortion, are all "
               "images of one instant, equally exposed, neither black nor white, and of things with texture?");
}

/** \brief It is the same in every frame: one tells. */
void ViewStereo::checkCalibration(const std::string& of_frame, const RigFrame& rig) {
  if (frames_ > 0 || !options_.warn) return;
  const std::string line = epipolarWarning(cameras_, epipolarErrors(rig, options_.parameters, options_.threads));
  if (!line.empty()) warnOnce("calibration", of_frame + ": " + line);
}

void ViewStereo::warnOnce(const std::string& thing, const std::string& line) {
  if (warned_.insert(thing).second && options_.warn) options_.warn(line);
}

std::size_t ViewStereo::estimatedViews() const {
  std::size_t views = 0;
  for (std::size_t k = 0; k < cameras_.size(); ++k) views += estimates(k) ? 1 : 0;
  return views;
}

std::string ViewStereo::summary() const {
  char text[128] = "";
  const double seconds = frames_ > 0 ? all_seconds_ / static_cast<double>(frames_) : 0;
  if (frames_ > 0 && pixels_ > 0)
    std::snprintf(text, sizeof text,
                  seconds < 9.95 ? ": %.2g s a frame; another view agrees on the depth of %.0f %% of the pixels"
                                 : ": %.0f s a frame; another view agrees on the depth of %.0f %% of the pixels",
                  seconds, 100 * static_cast<double>(agreeing_pixels_) / static_cast<double>(pixels_));
  return "depth of " + counted(estimatedViews(), "view") + " was estimated" + text;
}

nlohmann::json ViewStereo::json() const {
  nlohmann::json json;
  float smallest = 0, largest = 0;
  json["views"] = nlohmann::json::array();
  for (std::size_t k = 0; k < cameras_.size(); ++k) {
    if (!estimates(k)) continue;
    json["views"].push_back(cameras_[k].name);
    smallest = smallest == 0 ? geometry_[k].min_depth : std::min(smallest, geometry_[k].min_depth);
    largest = std::max(largest, geometry_[k].max_depth);
  }
  json["min_depth_m"] = smallest;
  json["max_depth_m"] = largest;
  json["agreeing"] = nullptr;
  json["seconds_per_frame"] = nullptr;
  if (frames_ == 0 || pixels_ == 0) return json;
  json["agreeing"] = static_cast<double>(agreeing_pixels_) / static_cast<double>(pixels_);
  json["seconds_per_frame"] = all_seconds_ / static_cast<double>(frames_);
  return json;
}

}  // namespace fuse_flow::io
