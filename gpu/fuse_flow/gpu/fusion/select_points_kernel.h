#pragma once

#include <fuse_flow/gpu/fusion/select_points.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

/** \brief SelectPoints, one warp a cell of at most kLevel. The cell's children lie in shared memory by position, with a border
 *  around them: ω of the weak ones that are open, infinity for what is kept, 0 where nothing is or stays. */
template <int kLevel>
__global__ void __launch_bounds__(128) selectPointsKernel(const SelectPoints step) {
  constexpr unsigned int all = 0xffffffffu;
  constexpr int kWarps = kLevel <= 3 ? 4 : 1;
  constexpr int kSide = (1 << kLevel) + 2;
  constexpr int kLayer = kSide * kSide;
  __shared__ float maps[kWarps][kLayer * kSide];
  const std::uint32_t rank = blockIdx.x * kWarps + threadIdx.x / 32;
  if (rank >= step.cell_count) return;  // whole warps
  float* map = maps[threadIdx.x / 32];
  const std::uint32_t lane = threadIdx.x % 32;
  const std::uint32_t begin = step.cells[rank].begin;
  const std::uint32_t end = step.end(rank);

  bool weak = false;
  for (std::uint32_t child = begin + lane; child < end; child += 32) weak |= step.states[child] == Weak;
  if (!__any_sync(all, weak)) return;

  const int level = step.level(rank);
  const auto placeOf = [level](int position) {
    const int x = position & ((1 << level) - 1), y = position >> level & ((1 << level) - 1), z = position >> 2 * level;
    return (x + 1) + (y + 1) * kSide + (z + 1) * kLayer;
  };
  for (int place = static_cast<int>(lane); place < kLayer * kSide; place += 32) map[place] = 0.0f;
  __syncwarp();
  const float kept = __int_as_float(0x7f800000);
  for (std::uint32_t child = begin + lane; child < end; child += 32) {
    const std::uint8_t state = step.states[child];
    if (state != Dropped) map[placeOf(step.positions[child])] = state == Kept ? kept : step.weights[child];
  }
  __syncwarp();

  for (bool open = true; open;) {
    open = false;
    for (std::uint32_t first = begin; first < end; first += 32) {
      const std::uint32_t child = first + lane;
      const int place = child < end ? placeOf(step.positions[child]) : 0;  // 0: of the border
      const float weight = map[place];
      const bool undecided = weight > 0 && weight < kept;
      if (!__any_sync(all, undecided)) continue;
      // The heaviest around it; of equal ones the one before it wins. Places ascend with positions.
      float before = 0, after = 0;
      if (undecided)
        for (int dz = -1; dz <= 1; ++dz)
#pragma unroll
          for (int k = 0; k < 9; ++k) {
            const int offset = dz * kLayer + (k / 3 - 1) * kSide + k % 3 - 1;
            const float other = map[place + offset];
            before = offset < 0 ? fmaxf(before, other) : before;
            after = offset > 0 ? fmaxf(after, other) : after;
          }
      const bool beaten = before == kept || after == kept;
      const bool waits = before >= weight || after > weight;
      __syncwarp();  // all have read
      if (undecided && (beaten || !waits)) map[place] = beaten ? 0.0f : kept;
      open |= undecided && !beaten && waits;
      __syncwarp();
    }
    open = __any_sync(all, open);
  }
  for (std::uint32_t child = begin + lane; child < end; child += 32)
    if (step.states[child] == Weak) step.states[child] = map[placeOf(step.positions[child])] > 0 ? Kept : Dropped;
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
