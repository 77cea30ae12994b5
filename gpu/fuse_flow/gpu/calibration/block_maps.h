#pragma once

#include <fuse_flow/calibration/extrinsic_parameters.h>
#include <fuse_flow/gpu/calibration/average_blocks.h>
#include <fuse_flow/gpu/calibration/block_views.h>
#include <fuse_flow/gpu/calibration/normal_noise_kernel.h>
#include <fuse_flow/gpu/sensors/depth_maps.h>
#include <fuse_flow/math/multipath.h>

namespace fuse_flow {
namespace gpu {

/** \brief What only making the blocks of an instant needs; one does for all instants. */
struct BlockScratch {
  DeviceBuffer<float> smooth[3];
  DeviceBuffer<float> rows;  ///< of grey levels, blurred along rows alone
  DeviceBuffer<float> grey;  ///< pixel by pixel
  NoiseMeasurement noise;
  DeviceBuffer<Median> medians;
  PinnedBuffer<Median> fetched_medians;

  std::size_t bytes() const {
    return smooth[0].bytes() + smooth[1].bytes() + smooth[2].bytes() + rows.bytes() + grey.bytes() + noise.bytes() +
           medians.bytes();
  }
};

/** \brief The views of one instant as alignment sees them, on the device: host::AlignmentView's counterpart, for all cameras at
 *  once. */
class BlockMaps {
 public:
  /** \brief \param full the images on the device  \param maps their depth as measured, and noise, waited for  \param scratch busy until the
   *  stream has been waited for and keep() called */
  void make(Execution& run, StageTimes& times, const FrameViews& full, const DepthMaps& maps,
            const ExtrinsicParameters& p, BlockScratch& scratch) {
    views_.assign(run, full, [&](std::size_t i) {
      const DeviceView& view = full.hostView(i);
      return view.present
                 ? blockReduction(p, view.model.intrinsics.width, maps.noiseScales()[i] * view.noise.model_ratio)
                 : p.reduction;
    });
    normal_noises_.assign(views_.size(), 0.05f);
    noise_scales_.assign(views_.size(), 1.0f);
    if (blocks() == 0) return;
    average(run, full, maps, p, scratch);
    findNormals(run, p, scratch);
    times.mark("blocks", static_cast<double>(full.pixels()) * 4 + static_cast<double>(blocks()) * 24);
    if (!hasColor()) return;
    blur(run, full, scratch);
    times.mark("grey levels",
               static_cast<double>(full.pixels()) * 15 + static_cast<double>(blocks()) * 4 * kLumaScales);
  }

  /** \brief Takes over what make() measured. */
  void keep(const BlockScratch& scratch) {
    if (blocks() == 0) return;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const Median& median = scratch.fetched_medians.data()[i];
      normal_noises_[i] = normalNoise(median.count, median.value);
      noise_scales_[i] = scratch.noise.scales()[i];
    }
  }

  PixelGrid grid() const { return views_.grid(); }
  /** \brief Of all views, padding included. */
  std::size_t blocks() const { return views_.blocks(); }
  /** \brief Where a camera's blocks begin in the grid. */
  std::uint32_t offset(std::size_t camera) const { return views_.hostView(camera).offset; }
  const Vec3* normals() const { return normals_.data(); }
  bool missing(std::size_t camera) const { return !views_.hostView(camera).present; }
  float normalNoiseOf(std::size_t camera) const { return normal_noises_[camera]; }
  bool hasColor() const {
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (hasColor(i)) return true;
    return false;
  }

  /** \brief One view, with pointers to device memory. \param full the view of pixels that make() was given */
  BlockImage image(std::size_t camera, const DeviceView& full, const ExtrinsicParameters& p) const {
    BlockImage image;
    if (missing(camera)) return image;
    const DeviceView& view = views_.hostView(camera);
    static_cast<BlockMap&>(image) = BlockPointers{grid(), z_.data(), rays_.data()}.of(view);
    image.intrinsics = full.model.intrinsics;
    image.ideal = full.model.ideal;
    image.max_squared_radius = full.model.max_squared_radius;
    image.reduction = view.reduction;
    image.normals = normals_.data() + view.offset;
    if (p.smoothing.passes > 0) image.smooth_z = smooth_z_.data() + view.offset;
    if (hasColor(camera)) {
      for (int scale = 0; scale < kLumaScales; ++scale) image.lumas[scale] = lumas_[scale].data() + view.offset;
      image.squares = squares_.data() + full.offset;
      image.squares_pitch = static_cast<std::ptrdiff_t>(full.pitch);
    }
    image.noise = full.noise.model;
    image.noise_scale = noise_scales_[camera];
    image.residual_multipath = residualMultipath(full.model.multipath, p.residual_multipath);
    return image;
  }

  std::size_t bytes() const {
    std::size_t sum =
        views_.bytes() + z_.bytes() + smooth_z_.bytes() + rays_.bytes() + normals_.bytes() + squares_.bytes();
    for (const DeviceBuffer<float>& luma : lumas_) sum += luma.bytes();
    return sum;
  }

 private:
  bool hasColor(std::size_t camera) const {
    const DeviceView& view = views_.hostView(camera);
    return view.present && view.color;
  }

  void average(Execution& run, const FrameViews& full, const DepthMaps& maps, const ExtrinsicParameters& p,
               BlockScratch& scratch) {
    z_.resize(blocks());
    rays_.resize(blocks());
    for (int map = 0; map < 2; ++map) scratch.smooth[map].resize(blocks());
    run.forEach(blocks(), AverageBlocks{grid(), full.grid().views, maps.measured(), steepestBlock(), z_.data(),
                                        scratch.smooth[1].data(), rays_.data()});
    scratch.noise.measure(run, grid(), views_.deviceViews(), blocks(), noiseParameters(p), z_.data());
  }

  void findNormals(Execution& run, const ExtrinsicParameters& p, BlockScratch& scratch) {
    run.forEach(blocks(), DespeckleBlocks{grid(), scratch.smooth[1].data(), p.max_speckle, scratch.smooth[0].data()});
    smoothDepth(run, views_.tiles(), blocks(), p.smoothing, scratch.smooth);
    DeviceBuffer<float>& result = scratch.smooth[smoothingMap(p.smoothing, smoothingPasses(p.smoothing))];
    const float* smooth = p.smoothing.passes == 0 ? z_.data() : result.data();
    normals_.resize(blocks());
    run.forEach(blocks(), FindNormals{{grid(), z_.data(), rays_.data()},
                                      {grid(), smooth, rays_.data()},
                                      2.449490f * p.smoothing.tolerance,
                                      normals_.data()});
    if (p.smoothing.passes > 0) std::swap(smooth_z_, result);
    scratch.medians.resize(views_.size());
    scratch.fetched_medians.resize(views_.size());
    const MeasureNormalNoise measure{grid(), normals_.data(), scratch.medians.data()};
#if FUSE_FLOW_CUDA
    run.launch("measureNormalNoiseKernel", measureNormalNoiseKernel, static_cast<unsigned int>(views_.size()), 1024u,
               measure);
#else
    run.forEach(views_.size(), measure);
#endif
    run.copySmall(scratch.fetched_medians.data(), std::as_const(scratch.medians).data(), views_.size());
  }

  /** \brief Grey levels at all scales. */
  void blur(Execution& run, const FrameViews& full, BlockScratch& scratch) {
    const BlockPointers map{grid(), z_.data(), rays_.data()};
    for (DeviceBuffer<float>& luma : lumas_) luma.resize(blocks());
    scratch.rows.resize(blocks());
    squares_.resize(full.pixels());
    scratch.grey.resize(full.pixels());
    run.forEach(full.pixels(), PixelLuma{map, full.grid(), scratch.grey.data()});
    run.forEach(full.pixels(), SquareLuma{grid().views, full.grid(), scratch.grey.data(), squares_.data()});
    run.forEach(blocks(), BlockLuma{grid(), full.grid().views, squares_.data(), lumas_[0].data()});
    for (int scale = 1; scale < kLumaScales; ++scale) {
      const int spacing = 1 << (scale - 1);
      run.forEach(blocks(), BlurLuma{map, lumas_[scale - 1].data(), scratch.rows.data(), spacing, 0});
      run.forEach(blocks(), BlurLuma{map, scratch.rows.data(), lumas_[scale].data(), 0, spacing});
    }
  }

  BlockViews views_;
  DeviceBuffer<float> z_, smooth_z_;
  DeviceBuffer<Ray> rays_;
  DeviceBuffer<Vec3> normals_;
  DeviceBuffer<float> lumas_[kLumaScales];
  DeviceBuffer<float> squares_;  ///< grey levels, pixel by pixel
  std::vector<float> normal_noises_, noise_scales_;
};

}  // namespace gpu
}  // namespace fuse_flow
