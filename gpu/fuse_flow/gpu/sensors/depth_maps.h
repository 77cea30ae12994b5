#pragma once

#include <fuse_flow/gpu/runtime/stage_times.h>
#include <fuse_flow/gpu/sensors/convert_depth.h>
#include <fuse_flow/gpu/sensors/correct_multipath.h>
#include <fuse_flow/gpu/sensors/fill_holes.h>
#include <fuse_flow/gpu/sensors/frame_views.h>
#include <fuse_flow/gpu/sensors/measure_noise.h>
#include <fuse_flow/gpu/sensors/smooth_bilaterally.h>
#include <fuse_flow/gpu/sensors/smooth_passes.h>
#include <fuse_flow/impl/parameters.hpp>

namespace fuse_flow {
namespace gpu {

struct DepthMapParameters {
  PreprocessingParameters preprocessing;
  SmoothingParameters smoothing;
  ConfidenceParameters confidence;
  bool adapt_noise{true};

  /** \brief For the filters that work on their own, which know of neither noise nor smoothing. */
  static DepthMapParameters withoutSmoothing(const PreprocessingParameters& preprocessing) {
    DepthMapParameters p;
    p.preprocessing = preprocessing;
    p.smoothing.passes = 0;
    p.adapt_noise = false;
    return p;
  }
};

/** \brief The depth of all views of a frame, metres, 0 where there is none: as measured, and D^r of eq. 8. */
class DepthMaps {
 public:
  void make(Execution& run, StageTimes& times, FrameViews& views, const DepthMapParameters& parameters) {
    convert(run, times, views, parameters);
    if (parameters.adapt_noise) measureNoise(run, times, views, parameters.confidence);
    refine(run, times, views, parameters);
  }

  const float* measured() const { return z_.data(); }
  const float* refined() const { return passes_ == 0 ? z_.data() : maps_[refined_].data(); }
  ///@{
  /** \brief The same, for what comes of views that others have; they are one map where nothing is smoothed. */
  float* measuredToFill() { return z_.data(); }
  float* refinedToFill() { return passes_ == 0 ? z_.data() : maps_[refined_].data(); }
  ///@}
  /** \brief Noise scale of each view, if it was measured, once the stream has been waited for. */
  const float* noiseScales() const { return noise_.scales(); }

  std::size_t bytes() const {
    return z_.bytes() + raw_z_.bytes() + maps_[0].bytes() + maps_[1].bytes() + maps_[2].bytes() + noise_.bytes() +
           bilateral_.bytes() + multipath_.bytes();
  }

 private:
  /** \brief Raw depth to metres and, for the smoothing, to 1/metres. */
  void convert(Execution& run, StageTimes& times, FrameViews& views, const DepthMapParameters& parameters) {
    const PreprocessingParameters& p = parameters.preprocessing;
    const std::size_t pixels = views.pixels();
    const auto of_pixels = static_cast<double>(pixels);
    const bool smooth = parameters.smoothing.passes > 0, fill = p.fill_neighbours > 0;
    z_.resize(pixels);
    if (fill) raw_z_.resize(pixels);
    if (smooth)
      for (DeviceBuffer<float>& map : maps_) map.resize(pixels);
    float* q = smooth && !p.bilateral ? maps_[0].data() : nullptr;
    float* const z = (fill ? raw_z_ : z_).data();
    float* const q_of_z = fill ? nullptr : q;
    const bool multipath = views.hasMultipath();
    run.forEach(pixels / ConvertDepth::kPixels,
                ConvertDepth{views.grid(), p.min_range, p.max_range, z, multipath ? nullptr : q_of_z});
    const double inverse = q ? 4 : 0;
    times.mark("metres", (2 + 4 + (fill || multipath ? 0 : inverse)) * of_pixels);
    if (multipath) {
      multipath_.correct(run, views, z, q_of_z);
      times.mark("multipath", (4 + 4 + 4 + (fill ? 0 : inverse)) * of_pixels);
    }
    if (fill) {
      run.forEach(pixels, FillHoles{views.grid(), p, raw_z_.data(), z_.data(), q});
      times.mark("holes", (4 + 4 + inverse) * of_pixels);
    }
    if (!p.bilateral) return;
    const double moved = bilateral_.smooth(run, views, p, z_.data());
    if (smooth) run.forEach(pixels, InvertDepth{z_.data(), maps_[0].data()});
    times.mark("bilateral", (smooth ? 12 : 8) * of_pixels, moved + (smooth ? 8 : 0) * of_pixels);
  }

  /** \brief How noisy each view is; stays on the device, with a copy for the statistics. */
  void measureNoise(Execution& run, StageTimes& times, FrameViews& views, const ConfidenceParameters& confidence) {
    noise_.measure(run, views.grid(), views.deviceViews(), views.pixels(), confidence, z_.data());
    times.mark("noise", static_cast<double>(views.pixels()) * 5 * 4 / (kNoiseStride * kNoiseStride));
  }

  /** \brief D^r of eq. 8. */
  void refine(Execution& run, StageTimes& times, FrameViews& views, const DepthMapParameters& parameters) {
    const SmoothingParameters& smoothing = parameters.smoothing;
    passes_ = smoothing.passes;
    refined_ = smoothingMap(smoothing, smoothingPasses(smoothing));
    smoothDepth(run, views.tiles(), views.pixels(), smoothing, maps_);
    const double pass = 8.0 * static_cast<double>(views.pixels());
    const double before_twicing = twicingPasses(smoothing) > 0 ? 0.5 * pass : 0;
    if (passes_ > 0) times.mark("smoothing", pass, smoothingPasses(smoothing) * pass + before_twicing);
  }

  DeviceBuffer<float> z_, raw_z_, maps_[3];
  MultipathCorrection multipath_;
  BilateralSmoothing bilateral_;
  int passes_{0};
  int refined_{0};  ///< of the maps
  NoiseMeasurement noise_;
};

}  // namespace gpu
}  // namespace fuse_flow
