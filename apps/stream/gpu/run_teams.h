#pragma once

#include "stream/gpu/team.h"

#include <fuse_flow/gpu/runtime/execution.h>

namespace fuse_flow::stream {

#if FUSE_FLOW_CUDA
/** \brief Of a file-wide kind, as inline ones of several libraries would be joined. */
template <typename Work>
static __global__ void __launch_bounds__(kTeamThreads) teamKernel(const Work work) {
  __shared__ typename Work::Shared shared;
  __shared__ std::uint32_t sums[ThreadBlock::kWarps];
  work(ThreadBlock{sums}, blockIdx.x, shared);
}
#endif

/** \brief work(team, k, memory that the team shares) for k = 0 … teams − 1. */
template <typename Work>
void forEachTeam(gpu::Execution& run, const char* name, std::uint32_t teams, const Work& work) {
  if (teams == 0) return;
#if FUSE_FLOW_CUDA
  run.launch(name, teamKernel<Work>, dim3(teams), kTeamThreads, work);
#else
  (void)name;
  run.forEach(teams, [&work](std::uint32_t k) {
    typename Work::Shared shared;
    work(Alone(), k, shared);
  });
#endif
}

}  // namespace fuse_flow::stream
