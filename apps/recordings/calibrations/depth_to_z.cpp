#include "recordings/calibrations/depth_to_z.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fuse_flow::io {

DepthToZ::DepthToZ(const Camera& camera, const DepthMeaning& meaning)
    : meaning_(meaning), depth_scale_(camera.depth_scale), intrinsics_(camera.intrinsics) {}

const std::vector<float>& DepthToZ::table() const {
  std::call_once(table_->made, [this] {
    const Intrinsics& K = intrinsics_;
    std::vector<float>& z_per_distance = table_->z_per_distance;
    z_per_distance.reserve(static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height));
    for (int v = 0; v < K.height; ++v)
      for (int u = 0; u < K.width; ++u) {
        const Ray ray = unproject(K, {static_cast<float>(u), static_cast<float>(v)});
        z_per_distance.push_back(1 / std::sqrt(1 + ray.x * ray.x + ray.y * ray.y));
      }
  });
  return table_->z_per_distance;
}

void DepthToZ::convert(LoadedView& images, DepthView& view) const {
  if (meaning_.isZ() || view.missing()) return;
  const std::vector<float>* const z_per_distance = meaning_.is_distance ? &table() : nullptr;
  const auto z = [&](float metres, std::size_t pixel) {
    if (!(metres > 0) || std::isinf(metres)) return 0.0f;
    const float corrected = metres + meaning_.offset;
    return std::max(0.0f, z_per_distance ? corrected * (*z_per_distance)[pixel] : corrected);
  };
  if (!images.depth16.empty()) {
    constexpr std::uint16_t nothing = std::numeric_limits<std::uint16_t>::max();
    images.depth32.resize(images.depth16.width, images.depth16.height);
    for (std::size_t k = 0; k < images.depth16.data.size(); ++k) {
      const std::uint16_t raw = images.depth16.data[k];
      images.depth32.data[k] = raw == nothing ? 0.0f : z(static_cast<float>(raw) * depth_scale_, k);
    }
    images.depth16.resize(0, 0);
  } else {
    for (std::size_t k = 0; k < images.depth32.data.size(); ++k) images.depth32.data[k] = z(images.depth32.data[k], k);
  }
  view.depth16 = {};
  view.depth32 = images.depth32.view();
}

}  // namespace fuse_flow::io
