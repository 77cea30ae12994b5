#pragma once

#include <fuse_flow/depth_view.h>
#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/impl/host/wide_vectors.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Runs the steps of stereo on the threads of the CPU. */
class StereoBackend {
 public:
  template <typename Value>
  using Buffer = std::vector<Value>;

  int threads{0};

  template <typename Step>
  void forEach(std::size_t n, const Step& step) {
    constexpr std::size_t of_task = 512;
    parallelFor(resolveThreads(threads), (n + of_task - 1) / of_task, [&](std::size_t task, int) {
      const std::size_t end = std::min(n, (task + 1) * of_task);
      inWideVectors([&] {
        for (std::size_t k = task * of_task; k < end; ++k) step(static_cast<std::uint32_t>(k));
      });
    });
  }
  template <typename Value>
  void upload(const std::vector<Value>& values, Buffer<Value>& to) {
    to = values;
  }
  template <typename Value>
  void download(const Value* from, std::size_t n, Value* to) {
    std::copy(from, from + n, to);
  }
  ImageView<Rgb8> reachable(std::size_t, const ImageView<Rgb8>& image) { return image; }
  void wait() {}
};

}  // namespace host
}  // namespace fuse_flow
