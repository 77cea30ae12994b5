#pragma once

#include <fuse_flow/distributed/asked_views.h>
#include <fuse_flow/distributed/block_owners.h>
#include <fuse_flow/distributed/frame_digest.h>
#include <fuse_flow/distributed/part_meeting.h>
#include <fuse_flow/distributed/pixel_window.h>
#include <fuse_flow/impl/fusion/frame_pipeline.hpp>

#include <memory>
#include <optional>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief The frame pipeline of one rank: depth and points of its own views, then the cells that it owns, of the points of all. The views of
 *  others are there where its cells look: everything that a cell reads is the same as in one process, and so is what it gives. */
class PartPipeline : public host::FramePipeline {
 public:
  PartPipeline() { number_missing = true; }

  /** \brief Eq. 3, 8 and 9 for the rank's own views. \param summary receives what the other ranks are told of them
   *  \param share_refined called where measurements need views of others that agree, to send and receive D^r; may throw */
  void measure(const RigFrame& part, PartSummary& summary, const std::function<void()>& share_refined) {
    putMapsBack();
    received_.resize(part.cameras.size());
    for (Received& received : received_) received.has_color = received.has_confidence = false;  // until others say so
    all_refined = share_refined;
    generate(part);
    whole_ = part;
    frame_ = &whole_;
    summary.rig = FrameDigest().add(part.cameras).value();
    if (summary.rig != projected_rig_) {
      projections_.clear();
      projections_.resize(part.cameras.size());
      projected_rig_ = summary.rig;
    }
    summarise(part, summary);
  }

  /** \brief What the other ranks have. \param parts of all ranks, by rank  \param own of this rank */
  void meet(const std::vector<PartSummary>& parts, int own) {
    findOrigins(parts, whole_.cameras, origin_);
    for (std::size_t r = 0; r < parts.size(); ++r) {
      if (static_cast<int>(r) == own) continue;
      for (const PartSummary::View& view : parts[r].views) {
        rig_.tabulate(view.view);
        depths_.setNoiseScale(view.view, view.noise_scale);
        Received& received = received_[view.view];
        received.has_color = with_color && view.has_color;
        received.has_confidence = view.has_confidence != 0;
      }
    }
    combineStatistics(parts, origin_, statistics);
  }

  /** \brief Whose view it is; −1: nobody's. */
  int originOf(std::size_t view) const { return origin_[view]; }
  const std::vector<Camera>& cameras() const { return whole_.cameras; }

  std::vector<ViewSet> askers() const { return askersOfViews(rig_, origin_, parameters); }
  int margin() const { return lookingMargin(parameters); }

  /** \brief Of one of the rank's own views. */
  const BoxProjection& projection(std::size_t view) {
    std::unique_ptr<BoxProjection>& projection = projections_[view];
    if (!projection) projection = std::make_unique<BoxProjection>(rig_[view]);
    return *projection;
  }
  const host::ViewGeometry& geometry(std::size_t view) const { return rig_[view]; }
  std::size_t cameraCount() const { return rig_.size(); }

  bool smooths() const { return &depths_.refined() != &depths_.measured(); }
  const host::DepthMap& measured(std::size_t view) const { return depths_.measured(view); }
  const host::DepthMap& refined(std::size_t view) const { return depths_.refined(view); }
  const float* weights(std::size_t view) const { return points_.weights() + depths_.offsets()[view]; }
  const ImageView<Rgb8>& colorImage(std::size_t view) const { return whole_.views[view].color; }
  /** \brief Null where every pixel's is 1, or where nobody asks. */
  ImageView<float> confidenceImage(std::size_t view) const {
    return parameters.consistency.weigh_contradictions ? whole_.views[view].confidence : ImageView<float>();
  }
  /** \brief Whether the colours of a view's pixels come from a camera that stands beside, and are sent as it shows them. */
  bool resolvesColors(std::size_t view) const { return rig_[view].own_color_camera; }
  /** \brief Whether a view of another rank comes with colours, and with confidence. */
  bool receivesColor(std::size_t view) const { return received_[view].has_color; }
  bool receivesConfidence(std::size_t view) const {
    return received_[view].has_confidence && parameters.consistency.weigh_contradictions;
  }

  /** \brief Where D^r of another rank's view goes before measurements are weighed: all of it. */
  host::DepthMap& landRefined(std::size_t view) {
    rig_.tabulate(view);
    const Intrinsics& K = rig_[view].intrinsics;
    land(view, {0, 0, K.width, K.height});
    return depths_.refinedToFill(view);
  }
  /** \brief D^r of one of the rank's own views, where it may agree with others: 0 where the view has no confidence. */
  float refinedToAgree(std::size_t view, int u, int v) const {
    return confidenceAt(frame_->views[view].confidence, u, v) > 0 ? depths_.refined(view).row(v)[u] : 0.0f;
  }
  /** \brief The rank's own views, while measure() runs. */
  std::vector<std::uint32_t> ownViews() const {
    std::vector<std::uint32_t> own;
    for (std::size_t i = 0; i < frame_->views.size(); ++i)
      if (!frame_->views[i].missing()) own.push_back(static_cast<std::uint32_t>(i));
    return own;
  }
  bool hasLanded(std::size_t view) const { return received_[view].swapped; }

  /** \brief Calls visit(number of the first point among the view's pixels, how many, key of their cell) for all points of one of the rank's own
   *  views, some at a time. */
  template <typename Visit>
  void forEachRun(std::size_t view, const Visit& visit) {
    const std::uint32_t offset = depths_.offsets()[view];
    forEachStretch(view, [&](std::size_t s) {
      const host::RunBuilder& cells = aggregation_.grid.builders()[s];
      for (const host::Run& run : cells.runs()) visit(run.begin - offset, run.count, cells.table().key(run.cell));
    });
  }

  /** \brief Where the pixels of another rank's view go. Their rows are written by the caller, from any thread. */
  struct Landing {
    host::DepthMap* measured{nullptr};
    host::DepthMap* refined{nullptr};  ///< null without smoothing
    float* weights{nullptr};           ///< C of eq. 9, of all pixels, row by row
    float* confidence{nullptr};        ///< likewise; null where there is none
    Rgb8* color{nullptr};              ///< likewise
    ViewColor* resolved{nullptr};      ///< likewise; one of the two, or neither
  };

  /** \brief Before its pixels are written. \param window where they will be; empty: the view is there, but no cell of this rank looks at it */
  Landing land(std::size_t view, const PixelWindow& window) {
    Received& received = received_[view];
    const Intrinsics& K = rig_[view].intrinsics;
    const auto pixels = static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height);
    putMapsBack(view);
    received.swapped = true;
    if (window.empty()) {
      received.blank_measured.resize(1, 1);
      if (smooths()) received.blank_refined.resize(1, 1);
      depths_.swapMaps(view, received.blank_measured, received.blank_refined);
      received.blank = true;
      return {};
    }
    received.measured.resize(K.width, K.height);
    if (smooths()) received.refined.resize(K.width, K.height);
    clear(received.measured, received.filled);
    if (smooths()) clear(received.refined, received.filled);
    received.filled = window;
    received.blank = false;
    depths_.swapMaps(view, received.measured, received.refined);
    Landing landing;
    landing.measured = &depths_.mapToFill(view);
    landing.refined = smooths() ? &depths_.refinedToFill(view) : nullptr;
    landing.weights = points_.weights() + depths_.offsets()[view];
    if (receivesConfidence(view)) {
      received.confidence.reserve(pixels);
      landing.confidence = received.confidence.data();
      whole_.views[view].confidence = {landing.confidence, K.width, K.height};
    }
    if (!received.has_color) return landing;
    if (resolvesColors(view)) {
      received.resolved.reserve(pixels);
      landing.resolved = received.resolved.data();
      resolved_colors_[view] = landing.resolved;
    } else {
      received.color.reserve(pixels);
      landing.color = received.color.data();
      whole_.views[view].color = {landing.color, K.width, K.height};
    }
    return landing;
  }

  /** \brief Before the first land() of a frame. */
  void beginLanding() { resolved_colors_.assign(rig_.size(), nullptr); }

  /** \brief Puts the points of another rank's view, all of them in cells of this rank, into these cells. */
  void takeUp() {
    const std::vector<host::FrameTasks::Stretch>& stretches = tasks_.stretches();
    host::parallelFor(threads_, stretches.size(), [&](std::size_t s, int thread) {
      const std::size_t view = stretches[s].view;
      const Received& received = received_[view];
      if (!received.swapped || received.blank) return;
      host::RunBuilder& cells = aggregation_.grid.builders()[s];
      cells.start(parameters.aggregation.cell_size);
      const PixelWindow& window = received.filled;
      const int begin = std::max(stretchBegin(s), window.top), end = std::min(stretchEnd(s), window.bottom);
      for (int v = begin; v < end; ++v)
        measurements_.takeUp(static_cast<std::uint32_t>(view), v, window.left, static_cast<int>(window.width()),
                             static_cast<std::size_t>(thread), cells);
      cells.finish();
    });
  }

  /** \brief Section 5 for the cells of this rank. \param owns whether a cell of this key is one */
  template <typename Owns>
  void fuseOwned(host::FusedPointSink& sink, const Owns& owns) {
    aggregateIf(sink, owns);
  }

  /** \brief Of each cell that has been fused, in their order, the number of its first point among those of all views: the order of one
   *  process. */
  std::uint32_t firstPointOf(std::size_t cell) const {
    const host::CoarseGrid& grid = aggregation_.grid;
    return grid.runs()[grid.cells()[cell].begin_run].begin;
  }

 private:
  /** \brief Values without a beginning: only those that come in are ever touched. */
  template <typename T>
  class Untouched {
   public:
    void reserve(std::size_t n) {
      if (n <= size_) return;
      bytes_.reset(new std::byte[n * sizeof(T) + alignof(T)]);
      size_ = n;
    }
    T* data() {
      const auto at = reinterpret_cast<std::uintptr_t>(bytes_.get());
      return reinterpret_cast<T*>((at + alignof(T) - 1) / alignof(T) * alignof(T));
    }

   private:
    std::unique_ptr<std::byte[]> bytes_;
    std::size_t size_{0};
  };

  /** \brief What is kept of another rank's view. */
  struct Received {
    bool swapped{false};  ///< its maps are in depths_
    bool blank{false};    ///< these are the blank ones
    bool has_color{false}, has_confidence{false};
    PixelWindow filled;  ///< zeros elsewhere
    host::DepthMap measured, refined, blank_measured, blank_refined;
    Untouched<float> confidence;
    Untouched<Rgb8> color;
    Untouched<ViewColor> resolved;
  };

  /** \brief The last frame's. */
  void putMapsBack() {
    for (std::size_t view = 0; view < received_.size(); ++view) putMapsBack(view);
  }
  void putMapsBack(std::size_t view) {
    Received& received = received_[view];
    if (!received.swapped) return;
    depths_.swapMaps(view, received.blank ? received.blank_measured : received.measured,
                     received.blank ? received.blank_refined : received.refined);
    received.swapped = false;
  }

  static void clear(host::DepthMap& map, const PixelWindow& window) {
    for (int v = window.top; v < window.bottom; ++v)
      std::fill(map.row(v) + window.left, map.row(v) + window.right, 0.0f);
  }

  int stretchBegin(std::size_t s) const { return tasks_.stretches()[s].begin_row; }
  /** \brief Of a view that is not this rank's own its stretches have no rows. */
  int stretchEnd(std::size_t s) const {
    const std::vector<host::FrameTasks::Stretch>& stretches = tasks_.stretches();
    const bool last = s + 1 == stretches.size() || stretches[s + 1].view != stretches[s].view;
    return last ? rig_[stretches[s].view].intrinsics.height : stretches[s + 1].begin_row;
  }

  template <typename Visit>
  void forEachStretch(std::size_t view, const Visit& visit) const {
    const std::vector<host::FrameTasks::Stretch>& stretches = tasks_.stretches();
    for (std::size_t s = 0; s < stretches.size(); ++s)
      if (stretches[s].view == view) visit(s);
  }

  void summarise(const RigFrame& part, PartSummary& summary) {
    summary.stamp = part.stamp;
    summary.gated = statistics.gated_points;
    summary.views.clear();
    summary.blocks.clear();
    host::CellTable blocks;  // of a group of views
    std::size_t first = 0;   // of the group's in the summary
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < part.views.size(); ++i) {
      if (part.views[i].missing()) continue;
      PartSummary::View view;
      view.view = static_cast<std::uint32_t>(i);
      view.measured = static_cast<std::uint32_t>(measured_[i]);
      view.noise_scale = statistics.noise_scales[i];
      view.has_color = part.views[i].color ? 1 : 0;
      view.has_confidence = part.views[i].confidence ? 1 : 0;
      for (const DepthOutOfRange& range : statistics.out_of_range)
        if (range.camera == i) {
          view.out_of_range = 1;
          view.range = range;
        }
      summary.views.push_back(view);
      if (i / kViewsOfGroup != group) {
        blocks.clear();
        first = summary.blocks.size();
        group = static_cast<std::uint32_t>(i / kViewsOfGroup);
      }
      forEachRun(i, [&](std::uint32_t, std::uint32_t count, std::uint64_t cell) {
        const std::uint64_t block = blockOfCell(cell);
        const std::size_t b = first + blocks.findOrAdd(block);
        if (b == summary.blocks.size()) summary.blocks.push_back({block, 0, group, 0});
        summary.blocks[b].views |= std::uint64_t{1} << i % kViewsOfGroup;
        summary.blocks[b].points += count;
      });
    }
  }

  RigFrame whole_;  ///< the frame with what has come of the views of others
  std::vector<int> origin_;
  std::vector<Received> received_;
  std::vector<std::unique_ptr<BoxProjection>> projections_;  ///< of own views, once asked for
  std::uint64_t projected_rig_{0};
};

}  // namespace distributed
}  // namespace fuse_flow
