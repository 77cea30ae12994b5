#pragma once

#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/calibration/correspondence.h>
#include <fuse_flow/math/calibration/normal_space.h>

namespace fuse_flow {
namespace gpu {

// Views are numbered instant by instant here, within them camera by camera; bins of normals view by view.

/** \brief The bin of each block's normal in the world; of blocks without one, a bin behind all others. */
struct BinNormals {
  PixelGrid grid;  // of one instant
  const Vec3* normals;
  const CameraPlace* places;
  std::uint32_t first_view;  // of the instant
  std::uint32_t no_bin;
  std::uint32_t* bins;
  std::uint32_t* blocks;  // the number in the instant's grid

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const Vec3 n = normals[index];
    blocks[index] = index;
    bins[index] = no_bin;
    if (!(squaredNorm(n) > 0)) return;
    const std::uint32_t camera = grid.viewOf(index);
    bins[index] = (first_view + camera) * static_cast<std::uint32_t>(kNormalBins) +
                  static_cast<std::uint32_t>(normalBin(rotate(places[camera].to_world, n)));
  }
};

/** \brief Where a bin's blocks begin, once all are sorted by bin. */
struct FindBins {
  const std::uint32_t* sorted;
  std::uint32_t count;
  std::uint32_t* begins;

  FUSE_FLOW_HD void operator()(std::uint32_t bin) const {
    std::uint32_t low = 0, high = count;  // all before low are of earlier bins, none from high on is
    while (low < high) {
      const std::uint32_t middle = (low + high) / 2;
      if (sorted[middle] < bin) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    begins[bin] = low;
  }
};

/** \brief One sample: evenly spaced among the blocks of its bin, in their order. */
struct ChooseSample {
  const BlockImage* images;      // view by view
  const std::uint32_t* offsets;  // of each view's blocks in the grid of its instant
  const std::uint32_t* begins;   // of each bin among the sorted blocks, and the end
  const std::uint32_t* blocks;   // sorted by bin
  const std::uint32_t* firsts;   // first sample of each bin, and the end
  std::uint32_t bins;
  std::uint32_t* codes;    // place along the curve through the image
  std::uint32_t* numbers;  // of the sample
  std::uint32_t* chosen;   // its block in its view
  std::uint32_t* views;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t bin = lastUpTo(firsts, bins, k), view = bin / static_cast<std::uint32_t>(kNormalBins);
    const std::size_t place =
        evenlySpaced(k - firsts[bin], begins[bin + 1] - begins[bin], firsts[bin + 1] - firsts[bin]);
    const std::uint32_t block = blocks[begins[bin] + place] - offsets[view];
    const auto pitch = static_cast<std::uint32_t>(images[view].pitch);
    codes[k] = mortonCode(block % pitch, block / pitch);
    numbers[k] = k;
    chosen[k] = block;
    views[k] = view;
  }
};

/** \brief The view of each of the samples in their present order, to sort them by. */
struct ViewOfSample {
  const std::uint32_t* numbers;
  const std::uint32_t* views;
  std::uint32_t* keys;
  FUSE_FLOW_HD void operator()(std::uint32_t k) const { keys[k] = views[numbers[k]]; }
};

/** \brief All that is known of a sample. */
struct GatherSample {
  const BlockImage* images;
  const std::uint32_t* numbers;  // in the order in which they are to lie
  const std::uint32_t* chosen;
  const std::uint32_t* views;
  AlignmentSample* samples;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const BlockImage& image = images[views[numbers[k]]];
    const std::uint32_t block = chosen[numbers[k]], pitch = static_cast<std::uint32_t>(image.pitch);
    samples[k] = sampleOf(image, static_cast<int>(block % pitch), static_cast<int>(block / pitch));
  }
};

/** \brief What some points add up to. */
struct PointMoments {
  double sum[3];   ///< metres
  double squares;  ///< of their distances from the origin

  FUSE_FLOW_HD void add(const Vec3& p) {
    const double x = p.x, y = p.y, z = p.z;
    sum[0] += x;
    sum[1] += y;
    sum[2] += z;
    squares += x * x + y * y + z * z;
  }
  FUSE_FLOW_HD void add(const PointMoments& o) {
    for (int k = 0; k < 3; ++k) sum[k] += o.sum[k];
    squares += o.squares;
  }
};

/** \brief Of the samples of one view, in its camera's frame: always in the same order, so that sums are the same on every run. */
struct SumMoments {
  const AlignmentSample* samples;
  const std::uint32_t* begins;  // of each view's samples, and the end
  PointMoments* moments;

  FUSE_FLOW_HD PointMoments every(std::uint32_t view, std::uint32_t first, std::uint32_t stride) const {
    PointMoments result{};
    for (std::uint32_t k = begins[view] + first; k < begins[view + 1]; k += stride) result.add(samples[k].p);
    return result;
  }
  FUSE_FLOW_HD void operator()(std::uint32_t view) const { moments[view] = every(view, 0, 1); }
};

}  // namespace gpu
}  // namespace fuse_flow
