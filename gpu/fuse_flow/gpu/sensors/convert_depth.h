#pragma once

#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/depth.h>

namespace fuse_flow {
namespace gpu {

/** \brief Raw depth to metres, eight pixels of a row at a time: one read of 16 bytes where the image allows it. */
struct ConvertDepth {
  static constexpr std::uint32_t kPixels = 8;

  PixelGrid grid;
  float min_range, max_range;
  float* z;
  float* q;  // 1/z as well, unless null

  struct alignas(16) Raw16 {
    std::uint16_t value[kPixels];
  };
  struct alignas(16) Metres {
    float value[kPixels];
  };

  FUSE_FLOW_HD void operator()(std::uint32_t group) const {
    const std::uint32_t index = group * kPixels;
    const PixelAddress a = grid.addressOf(index);
    const DeviceView& view = grid.views[a.view];
    if (!view.present) return;  // its pixels have numbers where others have it: see FrameViews::number_missing
    Metres out;
    if (view.depth16) {
      const Raw16 raw = read(view.depth16.row(a.v) + a.u, view.model.intrinsics.width - a.u);
      for (std::uint32_t k = 0; k < kPixels; ++k)
        out.value[k] = metres(raw.value[k], view.depth_scale, min_range, max_range);
    } else {
      const float* raw = view.depth32.row(a.v) + a.u;
      for (std::uint32_t k = 0; k < kPixels; ++k)
        out.value[k] =
            a.u + static_cast<int>(k) < view.model.intrinsics.width ? metres(raw[k], min_range, max_range) : 0.0f;
    }
    if (view.corrections != nullptr) correct(view, a, out);
    *reinterpret_cast<Metres*>(z + index) = out;
    if (q == nullptr) return;
    for (float& value : out.value) value = value > 0 ? 1.0f / value : 0.0f;
    *reinterpret_cast<Metres*>(q + index) = out;
  }

 private:
  FUSE_FLOW_HD static void correct(const DeviceView& view, const PixelAddress& a, Metres& out) {
    const int width = view.model.intrinsics.width;
    const DepthCorrectionTerms* terms =
        view.corrections + static_cast<std::size_t>(a.v) * static_cast<std::size_t>(width) + a.u;
    for (std::uint32_t k = 0; k < kPixels; ++k)
      if (a.u + static_cast<int>(k) < width) out.value[k] = correctedDepth(out.value[k], terms[k]);
  }

  /** \brief Zeros beyond the end of the row. */
  FUSE_FLOW_HD static Raw16 read(const std::uint16_t* raw, int left) {
    if (left >= static_cast<int>(kPixels) && (reinterpret_cast<std::uintptr_t>(raw) & 15u) == 0)
      return *reinterpret_cast<const Raw16*>(raw);
    Raw16 result;
    for (std::uint32_t k = 0; k < kPixels; ++k)
      result.value[k] = static_cast<int>(k) < left ? raw[k] : std::uint16_t{0};
    return result;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
