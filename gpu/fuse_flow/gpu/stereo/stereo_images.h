#pragma once

#include <fuse_flow/depth_view.h>
#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/gpu/runtime/memory_of.h>
#include <fuse_flow/impl/host/parallel.hpp>

#include <cstring>
#include <vector>

namespace fuse_flow {
namespace gpu {

/** \brief Colour images of a frame on the device: those that are there stay, pinned ones are fetched by the copy engine, others go through a
 *  pinned buffer. */
class StereoImages {
 public:
  /** \brief Where the device reads an image. The image must stay alive until the stream has passed. */
  ImageView<Rgb8> onDevice(Execution& run, std::size_t view, const ImageView<Rgb8>& image, int threads) {
    if (!image) return image;
    const Memory memory = memoryOf(image.data);
    if (memory == Memory::Device) return image;
    if (copies_.size() <= view) copies_.resize(view + 1);
    Copy& copy = copies_[view];
    const std::size_t width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
    const std::size_t row = width * sizeof(Rgb8);
    copy.device.resize(width * height);
    const Rgb8* from = image.data;
    if (memory == Memory::Pageable || image.row_stride != row) {
      copy.pinned.resize(width * height);
      run.wait();  // the last frame's copy may not have passed
      constexpr std::size_t rows = 64;
      host::parallelFor(threads, (height + rows - 1) / rows, [&](std::size_t task, int) {
        const std::size_t end = std::min(height, (task + 1) * rows);
        for (std::size_t v = task * rows; v < end; ++v)
          std::memcpy(copy.pinned.data() + v * width, image.row(static_cast<int>(v)), row);
      });
      from = copy.pinned.data();
    }
    run.copy(copy.device.data(), from, width * height);
    return {copy.device.data(), image.width, image.height};
  }

 private:
  struct Copy {
    PinnedBuffer<Rgb8> pinned;
    DeviceBuffer<Rgb8> device;
  };
  std::vector<Copy> copies_;
};

}  // namespace gpu
}  // namespace fuse_flow
