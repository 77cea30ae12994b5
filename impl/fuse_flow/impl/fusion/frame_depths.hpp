#pragma once

#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/fusion/statistics.h>
#include <fuse_flow/impl/fusion/frame_tasks.hpp>
#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/impl/sensors/multipath_correction.hpp>
#include <fuse_flow/impl/sensors/preprocessing.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/rig_frame.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief The depth of all views of a frame, with the memory that it keeps: D as measured, in metres, and D^r of eq. 8, the paper's refined
 *  depth. Each step works on some rows of one view, so that what it needs is still in the caches. */
class FrameDepths {
 public:
  /** \brief Begins a frame, which must stay alive. \param number_missing whether the pixels of missing cameras have numbers too */
  void start(const RigFrame& frame, const RigGeometry& rig, const FuseFlowParameters& parameters, bool number_missing) {
    frame_ = &frame;
    rig_ = &rig;
    parameters_ = &parameters;
    const std::size_t n = frame.cameras.size();
    measured_.resize(n);
    refined_.resize(n);
    multipath_.resize(n);
    offsets_.assign(n + 1, 0);
    views_.resize(n);
    noise_.resize(n);
    std::size_t total = 0;
    for (std::size_t i = 0; i < n; ++i) {
      offsets_[i] = static_cast<std::uint32_t>(total);
      noise_[i] = viewNoise(parameters.confidence, rig[i].ownNoise());
      const Intrinsics& K = frame.cameras[i].intrinsics;
      const bool missing = frame.views[i].missing();
      views_[i] = {K.width, K.height, missing, needsWholeImage(parameters.preprocessing, rig[i]),
                   parameters.adapt_noise};
      if (missing) {
        measured_[i].clear();
        refined_[i].clear();  // or other views would agree with what it measured before
        if (!number_missing) continue;
      }
      total += static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height);
      if (total > std::numeric_limits<std::uint32_t>::max() - 1u)
        throw pcl::PCLException("fuse_flow::FuseFlow: a frame has more than 2^32 pixels");
      if (missing) continue;
      measured_[i].resize(K.width, K.height);
      if (passes() > 0) refined_[i].resize(K.width, K.height);
    }
    offsets_[n] = static_cast<std::uint32_t>(total);
  }

  /** \brief Scratch maps for the views that are smoothed at the same time, each as large as any view is. What is not used is address space
   *  alone. */
  void reserveScratch(std::size_t maps) {
    if (passes() == 0) return;
    std::size_t most = 0;
    for (const FrameTasks::View& view : views_)
      if (!view.missing) most = std::max(most, DepthMap::sizeOf(view.width, view.height));
    maps *= kScratchMaps;
    if (scratch_.size() < maps) scratch_.resize(maps);
    for (DepthMap& map : scratch_) map.reserve(most);
  }

  /** \brief Scratch maps become those of a view. */
  void takeScratch(std::size_t i, std::uint32_t scratch) {
    for (std::uint32_t k = 0; k < (twicing() ? kScratchMaps : 1); ++k)
      scratch_[kScratchMaps * scratch + k].resize(measured_[i].width(), measured_[i].height());
  }

  /** \brief Raw depth to metres, within the range. \param scratch number of the view's scratch map */
  void convert(std::size_t i, int v, std::uint32_t scratch) {
    const PreprocessingParameters& p = parameters_->preprocessing;
    const ViewGeometry& view = (*rig_)[i];
    convertDepthRow(frame_->views[i], view.depth_scale, p.min_range, p.max_range, v, view.corrections(v),
                    measured_[i].row(v));
    if (passes() > 0 && !views_[i].whole_image) invert(i, v, scratch);  // while it is at hand
  }

  /** \brief What is not done row by row: multipath interference, holes, the bilateral filter, and how noisy the view is. */
  void finishMeasured(std::size_t i) {
    if (views_[i].whole_image) preprocessDepthMap(parameters_->preprocessing, (*rig_)[i], multipath_[i], measured_[i]);
    if (views_[i].noise) noise_[i].scale = measureNoiseScale(noise_[i].model, measured_[i]);
  }

  /** \brief Depth to inverse depth, which smoothing works on. */
  void invert(std::size_t i, int v, std::uint32_t scratch) {
    invertRow(measured_[i].row(v), measured_[i].width(), smoothed(i, 0, scratch).row(v));
  }

  /** \brief One pass of the smoothing, 0 … smoothingPasses() − 1; the last one gives D^r. */
  void smooth(std::size_t i, int pass, int v, std::uint32_t scratch) {
    smoothRow(parameters_->smoothing, pass, noise_[i], smoothed(i, pass, scratch), v,
              smoothed(i, pass + 1, scratch).row(v), smoothed(i, parameters_->smoothing.passes, scratch));
  }

  /** \brief A view that is missing here gets maps, or gives them back. */
  void swapMaps(std::size_t i, DepthMap& measured, DepthMap& refined) {
    std::swap(measured_[i], measured);
    if (passes() > 0) std::swap(refined_[i], refined);
  }
  ///@{
  /** \brief What the maps that it got hold, to be filled. */
  DepthMap& mapToFill(std::size_t i) { return measured_[i]; }
  DepthMap& refinedToFill(std::size_t i) { return passes() > 0 ? refined_[i] : measured_[i]; }
  ///@}
  /** \brief Of a view whose noise was measured elsewhere. */
  void setNoiseScale(std::size_t i, float scale) { noise_[i].scale = scale; }

  const std::vector<FrameTasks::View>& views() const { return views_; }
  /** \brief Number of the first pixel of each view, and of all: views come one after the other, row by row. */
  const std::vector<std::uint32_t>& offsets() const { return offsets_; }
  const std::vector<DepthMap>& measured() const { return measured_; }
  const DepthMap& measured(std::size_t i) const { return measured_[i]; }
  /** \brief D^r of eq. 8. */
  const std::vector<DepthMap>& refined() const { return passes() == 0 ? measured_ : refined_; }
  const DepthMap& refined(std::size_t i) const { return refined()[i]; }
  const std::vector<ViewNoise>& noise() const { return noise_; }
  const ViewNoise& noise(std::size_t i) const { return noise_[i]; }

 private:
  int passes() const { return smoothingPasses(parameters_->smoothing); }

  bool twicing() const { return twicingPasses(parameters_->smoothing) > 0; }

  /** \brief Inverse depth before a pass: to and fro between the maps, so that the last pass writes into the one that is kept. */
  DepthMap& smoothed(std::size_t i, int pass, std::uint32_t scratch) {
    const int map = smoothingMap(parameters_->smoothing, pass);
    const int kept = smoothingMap(parameters_->smoothing, passes());
    if (map == kept) return refined_[i];
    return scratch_[kScratchMaps * scratch + static_cast<std::uint32_t>(map > kept ? map - 1 : map)];
  }

  /** \brief Of a view, beside the map that it keeps; only with twicing all of them. */
  static constexpr std::uint32_t kScratchMaps = 2;

  const RigFrame* frame_{nullptr};
  const RigGeometry* rig_{nullptr};
  const FuseFlowParameters* parameters_{nullptr};
  std::vector<FrameTasks::View> views_;
  std::vector<std::uint32_t> offsets_;
  std::vector<ViewNoise> noise_;
  std::vector<DepthMap> measured_;
  std::vector<DepthMap> refined_;  ///< where there is smoothing
  std::vector<DepthMap> scratch_;  ///< of the views that are being smoothed
  std::vector<MultipathCorrection> multipath_;
};

}  // namespace host
}  // namespace fuse_flow
