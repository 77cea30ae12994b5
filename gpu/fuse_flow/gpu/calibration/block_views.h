#pragma once

#include <fuse_flow/gpu/sensors/frame_views.h>

namespace fuse_flow {
namespace gpu {

/** \brief The views of a frame as alignment sees them: a grid of blocks of pixels instead of pixels. Their intrinsics have the
 *  size of that grid, and else those of the image. */
class BlockViews {
 public:
  /** \param reduction what makes a view's block, given the view's number */
  template <typename Reduction>
  void assign(Execution& run, const FrameViews& full, const Reduction& reduction) {
    count_ = full.rig().size();
    views_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      DeviceView& view = views_.data()[i];
      view = full.hostView(i);
      Intrinsics& K = view.model.intrinsics;
      view.reduction = reduction(i);
      K.width /= view.reduction;
      K.height /= view.reduction;
      view.present = view.present && K.width > 0;
    }
    offsets_.resize(2 * (count_ + 1));
    size_ = layOutPixels(views_.data(), count_, offsets_.data());
    device_views_.resize(count_);
    device_offsets_.resize(2 * (count_ + 1));
    run.copySmall(device_views_.data(), std::as_const(views_).data(), count_);
    run.copySmall(device_offsets_.data(), std::as_const(offsets_).data(), 2 * (count_ + 1));
  }

  PixelGrid grid() const { return {device_views_.data(), device_offsets_.data(), static_cast<std::uint32_t>(count_)}; }
  TileGrid tiles() const { return {grid(), device_offsets_.data() + count_ + 1, size_.tiles}; }
  DeviceView* deviceViews() { return device_views_.data(); }
  /** \brief As uploaded. */
  const DeviceView& hostView(std::size_t i) const { return views_.data()[i]; }
  std::size_t size() const { return count_; }
  /** \brief Blocks of all views, padding included: a multiple of kChunk. */
  std::size_t blocks() const { return size_.pixels; }
  std::size_t bytes() const { return device_views_.bytes() + device_offsets_.bytes(); }

 private:
  std::size_t count_{0};
  GridSize size_{0, 0};
  PinnedBuffer<DeviceView> views_;
  PinnedBuffer<std::uint32_t> offsets_;
  DeviceBuffer<DeviceView> device_views_;
  DeviceBuffer<std::uint32_t> device_offsets_;
};

}  // namespace gpu
}  // namespace fuse_flow
