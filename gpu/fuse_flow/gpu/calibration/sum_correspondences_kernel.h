#pragma once

#include <fuse_flow/gpu/calibration/sum_correspondences.h>

namespace fuse_flow {
namespace gpu {

/** \brief A correspondence as factors: each number of AlignmentSums is a sum of products of two of them. Rounded as in
 *  addCorrespondence(), so that sums in the same order have the same bits. */
struct CorrespondenceFactors {
  double left[12];   ///< w a, w x, w, w r, 1
  double right[17];  ///< a, x, r, 1, b

  FUSE_FLOW_HD void set(const Correspondence& c) {
    const Vec3 m = cross(c.x, c.n);
    const float f[9] = {c.n.x, c.n.y, c.n.z, m.x, m.y, m.z, c.x.x, c.x.y, c.x.z};
    const double w = c.w, r = c.r;
    for (int k = 0; k < 9; ++k) {
      right[k] = f[k];
      left[k] = w * right[k];
    }
    left[9] = w;
    left[10] = w * r;
    left[11] = 1;
    right[9] = r;
    right[10] = 1;
    const Vec3 own = cross(c.x, c.own);
    const float b[6] = {c.own.x, c.own.y, c.own.z, own.x, own.y, own.z};
    for (int k = 0; k < 6; ++k) right[11 + k] = b[k];
  }
};

/** \brief Which factors make a number of AlignmentSums. */
struct SumTerm {
  std::uint32_t left, right;
};

/** \brief \param k place in AlignmentSums, under kAlignmentSums */
FUSE_FLOW_HD SumTerm termOf(std::uint32_t k) {
  constexpr std::uint32_t x = 6, w = 9, r = 9, wr = 10, one_left = 11, one_right = 10, a = 0, b = 11;
  const auto triangle = [](std::uint32_t place, std::uint32_t size, std::uint32_t first) {
    std::uint32_t row = 0;
    for (; place >= size - row; ++row) place -= size - row;
    return SumTerm{first + row, first + row + place};
  };
  if (k < 21) return triangle(k, 6, a);         // A
  if (k < 27) return {k - 21, r};               // g
  if (k < 28) return {w, one_right};            // w
  if (k < 31) return {x + k - 28, one_right};   // wx
  if (k < 37) return triangle(k - 31, 3, x);    // wxx
  if (k < 38) return {wr, one_right};           // wr
  if (k < 39) return {wr, r};                   // wrr
  if (k < 40) return {one_left, one_right};     // count
  if (k < 46) return {w, a + k - 40};           // wa
  if (k < 52) return {w, b + k - 46};           // wb
  return {a + (k - 52) / 6, b + (k - 52) % 6};  // shared
}

#if FUSE_FLOW_CUDA
constexpr unsigned int kSumThreads = 128;
static_assert(kAlignmentSums <= kSumThreads, "each thread adds up one number");

/** \brief What the threads of a block have found, as factors without gaps, in the order of the threads. */
struct FoundInBlock {
  CorrespondenceFactors factors[kSumThreads];
  unsigned int counts[kSumThreads / 32];  ///< of each warp

  /** \brief Adds, in each of the first kAlignmentSums threads, one number of all that was found. All threads must call it. */
  __device__ void add(bool found, const Correspondence& correspondence, const SumTerm& term, double& sum) {
    const unsigned int warp = threadIdx.x / 32, lane = threadIdx.x % 32;
    const unsigned int ballot = __ballot_sync(0xffffffffu, found);
    if (lane == 0) counts[warp] = static_cast<unsigned int>(__popc(ballot));
    __syncthreads();
    unsigned int before = static_cast<unsigned int>(__popc(ballot & ((1u << lane) - 1u))), total = 0;
    for (unsigned int k = 0; k < kSumThreads / 32; ++k) {
      before += k < warp ? counts[k] : 0u;
      total += counts[k];
    }
    if (found) factors[before].set(correspondence);
    __syncthreads();
    if (threadIdx.x < kAlignmentSums)
      for (unsigned int k = 0; k < total; ++k) sum += factors[k].left[term.left] * factors[k].right[term.right];
    __syncthreads();  // before it is written again
  }
};

/** \brief SumCorrespondences, one block a cluster with one other view: its threads look for counterparts side by side, and then each
 *  adds up one number, sample after sample. */
static __global__ void __launch_bounds__(kSumThreads) sumCorrespondencesKernel(const SumCorrespondences step) {
  __shared__ FoundInBlock shared;
  __shared__ std::uint32_t bins[kNoiseBins];
  for (unsigned int bin = threadIdx.x; bin < kNoiseBins; bin += kSumThreads) bins[bin] = 0;
  __syncthreads();
  const ClusterPair cluster = step.clusters[blockIdx.x];
  const auto stride = static_cast<std::uint32_t>(step.gates.stride);
  const SumTerm term = termOf(threadIdx.x < kAlignmentSums ? threadIdx.x : 0u);
  double geometry = 0, color = 0;
  for (std::uint32_t first = cluster.begin; first < cluster.end; first += kSumThreads * stride) {
    const std::uint32_t sample = first + threadIdx.x * stride;
    SumCorrespondences::Found found;
    if (sample < cluster.end) found = step.find(cluster, step.samples[sample]);
    if (found.matches) atomicAdd(&bins[found.bin], 1u);
    shared.add(found.matches, found.geometry, term, geometry);
    if (step.gates.color) shared.add(found.colored, found.color, term, color);
  }
  if (threadIdx.x < kAlignmentSums) {
    reinterpret_cast<double*>(step.sums + 2 * blockIdx.x)[threadIdx.x] = geometry;
    reinterpret_cast<double*>(step.sums + 2 * blockIdx.x + 1)[threadIdx.x] = color;
  }
  __syncthreads();
  for (unsigned int bin = threadIdx.x; bin < kNoiseBins; bin += kSumThreads)
    if (bins[bin] > 0) atomicAdd(step.residuals + bin, bins[bin]);
}
#endif

}  // namespace gpu
}  // namespace fuse_flow
