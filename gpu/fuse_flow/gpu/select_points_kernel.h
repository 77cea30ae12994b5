#pragma once

#include <fuse_flow/gpu/select_points.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

/** \brief SelectPoints, one warp a cell of at most kLevel. The cell's children lie in shared memory by position: ω of the
 *  weak ones that are open, infinity for what is kept, 0 where nothing is or stays. */
template <int kLevel>
__global__ void __launch_bounds__(128) selectPointsKernel(const SelectPoints step) {
  constexpr unsigned int all = 0xffffffffu;
  constexpr int kWarps = kLevel <= 3 ? 4 : 1;
  __shared__ float maps[kWarps][1 << 3 * kLevel];
  const std::uint32_t rank = blockIdx.x * kWarps + threadIdx.x / 32;
  if (rank >= step.cell_count) return;  // whole warps
  float* map = maps[threadIdx.x / 32];
  const std::uint32_t lane = threadIdx.x % 32;
  const std::uint32_t begin = step.cells[rank].begin;
  const std::uint32_t end = step.end(rank);

  bool weak = false;
  for (std::uint32_t child = begin + lane; child < end; child += 32) weak |= step.states[child] == FuseChildren::Weak;
  if (!__any_sync(all, weak)) return;

  const int level = step.level(rank);
  for (int position = static_cast<int>(lane); position < 1 << 3 * level; position += 32) map[position] = 0.0f;
  __syncwarp();
  const float kept = __int_as_float(0x7f800000);
  for (std::uint32_t child = begin + lane; child < end; child += 32) {
    const std::uint8_t state = step.states[child];
    if (state != FuseChildren::Dropped)
      map[step.positions[child]] = state == FuseChildren::Kept ? kept : step.weights[child];
  }
  __syncwarp();

  for (bool open = true; open;) {
    open = false;
    for (std::uint32_t first = begin; first < end; first += 32) {
      const std::uint32_t child = first + lane;
      const int position = child < end ? step.positions[child] : 0;
      const float weight = child < end ? map[position] : 0.0f;
      const bool undecided = weight > 0 && weight < kept;
      bool beaten = false, waits = false;
      if (undecided)
        SelectPoints::forEachRowAround(position, level, [&](int row, int x_begin, int x_end) {
          for (int x = x_begin; x < x_end; ++x) {
            const float other = map[row + x];
            beaten |= other == kept;
            waits |= other > weight || (other == weight && row + x < position);
          }
        });
      __syncwarp();  // all have read
      if (undecided && (beaten || !waits)) map[position] = beaten ? 0.0f : kept;
      open |= undecided && !beaten && waits;
      __syncwarp();
    }
    open = __any_sync(all, open);
  }
  for (std::uint32_t child = begin + lane; child < end; child += 32)
    if (step.states[child] == FuseChildren::Weak)
      step.states[child] = map[step.positions[child]] > 0 ? FuseChildren::Kept : FuseChildren::Dropped;
}

/** \brief Launches it for cells of at most max_level; false if such cells do not fit shared memory. */
inline bool selectPointsInSharedMemory(const SelectPoints& step, int max_level, cudaStream_t stream) {
  if (max_level <= 3) {
    selectPointsKernel<3><<<(step.cell_count + 3) / 4, 128, 0, stream>>>(step);
  } else if (max_level == 4) {
    selectPointsKernel<4><<<step.cell_count, 32, 0, stream>>>(step);
  } else {
    return false;
  }
  check(cudaGetLastError(), "selectPointsKernel");
  return true;
}

}  // namespace gpu
}  // namespace fuse_flow

#endif
