#include "viewer/fusing/thumbnail.h"

#include "viewer/fusing/coloring.h"

#include <algorithm>
#include <functional>
#include <numeric>

namespace fuse_flow::viewing {
namespace {

constexpr int kBorder = 3;  // pixels
constexpr double kUsualAspect = 4.0 / 3;
constexpr Rgb8 kNoImage{40, 40, 40};
constexpr float kDarkDistance = 6.0f;  // metres: depth from here on is black

Rgb8 depthColor(float z) {
  if (!(z > 0)) return {30, 30, 60};
  const auto grey = static_cast<std::uint8_t>(255 * std::clamp(1 - z / kDarkDistance, 0.05f, 1.0f));
  return {grey, grey, grey};
}

float depthAt(const Camera& camera, const DepthView& view, int u, int v) {
  if (view.depth32) return view.depth32.row(v)[u];
  const std::uint16_t raw = view.depth16.row(v)[u];
  return raw == 65535 ? 0.0f : camera.depth_scale * static_cast<float>(raw);
}

/** \brief Of each picture; where one is missing, that of the first which is there. */
std::vector<double> aspectsOf(const std::vector<io::ColorImage>& thumbnails) {
  const auto aspect = [](const io::ColorImage& image) { return static_cast<double>(image.width) / image.height; };
  const auto there = std::find_if_not(thumbnails.begin(), thumbnails.end(), std::mem_fn(&io::ColorImage::empty));
  const double missing = there == thumbnails.end() ? kUsualAspect : aspect(*there);
  std::vector<double> aspects;
  for (const io::ColorImage& image : thumbnails) aspects.push_back(image.empty() ? missing : aspect(image));
  return aspects;
}

void draw(const io::ColorImage& picture, Rgb8 border, int begin, int width, io::ColorImage& strip) {
  for (int v = 0; v < strip.height; ++v)
    for (int u = 0; u < width; ++u) {
      Rgb8& pixel = strip.at(begin + u, v);
      if (std::min({u, v, width - 1 - u, strip.height - 1 - v}) < kBorder)
        pixel = border;
      else
        pixel = picture.empty() ? kNoImage : picture.at(u * picture.width / width, v * picture.height / strip.height);
    }
}

}  // namespace

io::ColorImage thumbnailOf(const Camera& camera, const DepthView& view, int height) {
  io::ColorImage image;
  if (view.missing()) return image;
  const int from_width = view.color ? view.color.width : view.width();
  const int from_height = view.color ? view.color.height : view.height();
  image.resize(std::max(1, from_width * height / from_height), height);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const int from_u = u * from_width / image.width, from_v = v * from_height / image.height;
      image.at(u, v) = view.color ? view.color.row(from_v)[from_u] : depthColor(depthAt(camera, view, from_u, from_v));
    }
  return image;
}

Strip stripOf(const std::vector<io::ColorImage>& thumbnails, int max_width, int max_height) {
  const std::vector<double> aspects = aspectsOf(thumbnails);
  const double aspect = std::accumulate(aspects.begin(), aspects.end(), 0.0);
  const int height = std::max(1, std::min(max_height, static_cast<int>(max_width / std::max(aspect, 1e-3))));
  Strip strip;
  std::vector<int> widths;
  int end = 0;
  for (const double each : aspects) {
    strip.begin.push_back(end);
    widths.push_back(std::max(1, static_cast<int>(each * height)));
    end += widths.back();
  }
  strip.image.resize(end, height);
  for (std::size_t k = 0; k < thumbnails.size(); ++k)
    draw(thumbnails[k], cameraColor(k), strip.begin[k], widths[k], strip.image);
  return strip;
}

}  // namespace fuse_flow::viewing
