#include "recordings/readers/view_files.h"

#include "recordings/files/file_io.h"
#include "recordings/images/float_image.h"
#include "recordings/images/image_io.h"
#include "recordings/images/tiff_image.h"

#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <sstream>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

SizeCheck sizeOf(const std::string& path, const std::string& camera, const Intrinsics& K) {
  return [&path, camera, &K](int width, int height) {
    if (width == K.width && height == K.height) return;
    throw InputError(path + ": is " + std::to_string(width) + "x" + std::to_string(height) + " pixels, camera '" +
                     camera + "' is calibrated for " + std::to_string(K.width) + "x" + std::to_string(K.height));
  };
}

constexpr std::initializer_list<const char*> kFloatExtensions = {".pfm", ".npy", ".exr", ".PFM", ".NPY", ".EXR"};
constexpr std::initializer_list<const char*> kConfidenceExtensions = {".png", ".PNG"};
constexpr std::initializer_list<const char*> kImageExtensions = {".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"};

bool hasExtension(const std::string& name, std::initializer_list<const char*> extensions) {
  return std::find(extensions.begin(), extensions.end(), fs::path(name).extension()) != extensions.end();
}

/** \brief The first that exists; else "". */
std::string findFile(const std::string& folder, const std::string& stem,
                     std::initializer_list<const char*> extensions) {
  for (const char* extension : extensions) {
    const std::string path = (fs::path(folder) / (stem + extension)).string();
    if (isThere(path)) return path;
  }
  return "";
}

/** \brief Throws where confidence is not from 0 to 1. */
void checkConfidence(const std::string& path, const FloatImage& confidence) {
  for (const float c : confidence.data)
    if (c > 1.001f) {
      std::ostringstream message;
      message << path << ": has a confidence of " << c << ", must be 0 to 1";
      if (c <= 255) message << "; of a rig recording confidence_scale in rig.json may say what one step is";
      throw InputError(message.str());
    }
}

std::string noLongerThere(const std::string& path) {
  return path + ": is no longer there; it was when the recording was opened";
}

void loadColor(const std::string& path, const Camera& camera, LoadedView& images, DepthView& view) {
  const bool own = camera.color.has_value();
  readColor(path, images.color,
            sizeOf(path, camera.name + (own ? " color" : ""), own ? camera.color->intrinsics : camera.intrinsics));
  images.color_file = path;
  view.color = images.color.view();
}

}  // namespace

std::string frameStem(std::size_t frame) {
  const std::string digits = std::to_string(frame);
  return digits.size() < 6 ? std::string(6 - digits.size(), '0') + digits : digits;
}

std::string findImage(const std::string& folder, const std::string& stem) {
  return findFile(folder, stem, kImageExtensions);
}

bool isImage(const std::string& name) { return hasExtension(name, kImageExtensions); }

bool isDepthImage(const std::string& name) {
  return fs::path(name).extension() == ".png" || isFloatImage(name) || isTiff(name);
}

bool isConfidenceImage(const std::string& name) {
  return hasExtension(name, kConfidenceExtensions) || hasExtension(name, kFloatExtensions);
}

std::string findFloatImage(const std::string& folder, const std::string& stem) {
  return findFile(folder, stem, kFloatExtensions);
}

std::string findConfidence(const std::string& folder, const std::string& stem) {
  const std::string in_float = findFloatImage(folder, stem);
  return in_float.empty() ? findFile(folder, stem, kConfidenceExtensions) : in_float;
}

std::string colorFolder(const std::string& folder) {
  std::error_code error;
  for (const char* name : {"color", "rgb", "image"})
    if (const fs::path path = fs::path(folder) / name; fs::is_directory(path, error)) return path.string();
  return "";
}

void loadView(const ViewFiles& files, const Camera& camera, std::optional<float> confidence_scale, LoadedView& images,
              DepthView& view) {
  view = DepthView();
  images.color_file.clear();
  if (files.color_alone) {
    if (files.color.empty()) return;
    if (!isThere(files.color)) throw InputError(noLongerThere(files.color));
    loadColor(files.color, camera, images, view);
    return;
  }
  if (files.depth.empty()) return;
  if (!isThere(files.depth)) {
    if (!files.depth_was_there) return;
    throw InputError(noLongerThere(files.depth));
  }
  const SizeCheck depth_size = sizeOf(files.depth, camera.name, camera.intrinsics);
  if (isFloatImage(files.depth)) {
    images.depth16.resize(0, 0);
    readFloatImage(files.depth, images.depth32, depth_size);
    view.depth32 = images.depth32.view();
  } else if (isTiff(files.depth)) {
    readDepthTiff(files.depth, images.depth16, images.depth32, depth_size);
    view.depth16 = images.depth16.view();
    view.depth32 = images.depth32.view();
  } else {
    images.depth32.resize(0, 0);
    readDepthPng(files.depth, images.depth16, depth_size);
    view.depth16 = images.depth16.view();
  }
  if (!files.color.empty() && isThere(files.color)) loadColor(files.color, camera, images, view);
  if (!files.confidence.empty() && isThere(files.confidence)) {
    const SizeCheck size = sizeOf(files.confidence, camera.name, camera.intrinsics);
    images.assumed_confidence_step = 0;
    if (isFloatImage(files.confidence)) {
      readFloatImage(files.confidence, images.confidence, size);
      for (float& c : images.confidence.data) c *= confidence_scale.value_or(1.0f);
      checkConfidence(files.confidence, images.confidence);
    } else {
      const float step = readConfidencePng(files.confidence, images.confidence, confidence_scale, size);
      if (!confidence_scale) images.assumed_confidence_step = step;
    }
    view.confidence = images.confidence.view();
  }
}

void ViewLoading::load(std::size_t views, const std::function<void(std::size_t)>& load, LoadedFrame& out) const {
  std::vector<std::string> damage(views);
  host::parallelFor(host::resolveThreads(threads_), views, [&](std::size_t view, int) {
    if (!reads(view, views)) {
      out.rig.views[view] = DepthView();
      return;
    }
    try {
      load(view);
    } catch (const InputError& error) {
      if (!skip_damaged_) throw;
      damage[view] = error.what();
    }
  });
  for (std::size_t view = 0; view < views; ++view) {
    if (damage[view].empty()) continue;
    out.rig.views[view] = DepthView();
    out.damaged.push_back({view, damage[view]});
  }
}

}  // namespace fuse_flow::io
