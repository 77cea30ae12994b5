#pragma once

#include <fuse_flow/distributed/block_owners.h>
#include <fuse_flow/distributed/pixel_window.h>
#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/gpu/runtime/execution.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Which pixels of a rank's own views the cells of other ranks look at, block by block and view by view. */
struct FindWindows {
  /** \brief A block that another rank fuses. */
  struct Block {
    std::uint64_t key;
    std::uint32_t owner, padding;
  };
  /** \brief What one of the own views shows. */
  struct Projection {
    BoxProjector project;
    host::ViewFrustum frustum;
  };

  const Block* blocks;
  const std::uint64_t* views_of_blocks;  ///< that have points there: words of each block
  const std::uint64_t* askers;           ///< whose points may ask an own view: words of each
  const Projection* projections;         ///< of own views
  std::uint32_t block_count, words, ranks, first_view;
  float side;  ///< of a block, metres
  int margin;
  /** \brief Of each own view and rank: left, top, and the complements of right and bottom, so that all are minima. */
  std::uint32_t* windows;

  FUSE_FLOW_HD void operator()(std::uint32_t i) const {
    const std::uint32_t local = i / block_count, k = first_view + local, b = i - local * block_count;
    bool asks = false;
    for (std::uint32_t word = 0; word < words; ++word)
      asks |= (views_of_blocks[b * words + word] & askers[k * words + word]) != 0;
    if (!asks) return;
    const Block block = blocks[b];
    const host::Bounds box = blockBounds(block.key, side);
    if (!projections[k].frustum.mayShow(box)) return;
    const PixelWindow window = projections[k].project(box, margin);
    if (window.empty()) return;
    std::uint32_t* const least = windows + 4 * (k * ranks + block.owner);
    lower(least, static_cast<std::uint32_t>(window.left));
    lower(least + 1, static_cast<std::uint32_t>(window.top));
    lower(least + 2, ~static_cast<std::uint32_t>(window.right));
    lower(least + 3, ~static_cast<std::uint32_t>(window.bottom));
  }

 private:
  FUSE_FLOW_HD static void lower(std::uint32_t* least, std::uint32_t value) {
    if (value < gpu::atomicLoad(least)) gpu::atomicMinTo(least, value);
  }
};

/** \brief The same with the memory that it takes. */
class WindowSearch {
 public:
  /** \brief Waits for the stream. \param rig_digest differs where calibrations differ  \param views the own ones  \param askers of all views of
   *  the rig  \param side of a block, metres  \param windows receives those of each own view and rank, view by view */
  void find(gpu::Execution& run, const host::RigGeometry& rig, std::uint64_t rig_digest, const BlockOwners& owners,
            const std::vector<std::uint32_t>& views, const std::vector<ViewSet>& askers, int own, int ranks, float side,
            int margin, std::vector<PixelWindow>& windows) {
    const std::size_t n = views.size() * static_cast<std::size_t>(ranks);
    windows.assign(n, {});
    const std::size_t words = (rig.size() + kViewsOfGroup - 1) / kViewsOfGroup;
    const std::size_t blocks = putBlocks(owners, own, words);
    if (blocks == 0 || views.empty()) return;
    if (rig_digest != rig_digest_ || views != views_) project(run, rig, rig_digest, views);
    putAskers(views, askers, words);
    upload(run, host_blocks_, blocks_, blocks);
    upload(run, host_views_of_blocks_, views_of_blocks_, blocks * words);
    upload(run, host_askers_, askers_, views.size() * words);
    least_.resize(4 * n);
    host_least_.resize(4 * n);
    run.fill(least_.data(), 4 * n, 0xff);
    FindWindows step{blocks_.data(),
                     views_of_blocks_.data(),
                     askers_.data(),
                     projections_.data(),
                     static_cast<std::uint32_t>(blocks),
                     static_cast<std::uint32_t>(words),
                     static_cast<std::uint32_t>(ranks),
                     0,
                     side,
                     margin,
                     least_.data()};
    const std::size_t at_once = std::max<std::size_t>(1, (std::size_t{1} << 31) / blocks);  // numbers have 32 bits
    for (std::size_t first = 0; first < views.size(); first += at_once) {
      step.first_view = static_cast<std::uint32_t>(first);
      run.forEach(std::min(at_once, views.size() - first) * blocks, step);
    }
    run.copySmall(host_least_.data(), std::as_const(least_).data(), 4 * n);
    run.wait();
    for (std::size_t w = 0; w < n; ++w) {
      const std::uint32_t* const least = host_least_.data() + 4 * w;
      if (least[0] == 0xffffffffu) continue;
      windows[w] = {static_cast<std::int32_t>(least[0]), static_cast<std::int32_t>(least[1]),
                    static_cast<std::int32_t>(~least[2]), static_cast<std::int32_t>(~least[3])};
    }
  }

  std::size_t bytes() const {
    return blocks_.bytes() + views_of_blocks_.bytes() + askers_.bytes() + projections_.bytes() + strips_.bytes() +
           least_.bytes();
  }

 private:
  template <typename Value>
  static void upload(gpu::Execution& run, const gpu::PinnedBuffer<Value>& from, gpu::DeviceBuffer<Value>& to,
                     std::size_t n) {
    to.resize(n);
    run.copy(to.data(), from.data(), n);
  }

  /** \brief Those that others fuse; returns how many. */
  std::size_t putBlocks(const BlockOwners& owners, int own, std::size_t words) {
    host_blocks_.resize(owners.blocks().size());
    host_views_of_blocks_.resize(owners.blocks().size() * words);
    std::size_t n = 0;
    for (const BlockOwners::Block& block : owners.blocks()) {
      if (block.owner == own) continue;
      host_blocks_.data()[n] = {block.key, static_cast<std::uint32_t>(block.owner), 0};
      std::copy(block.views.words().begin(), block.views.words().end(), host_views_of_blocks_.data() + n * words);
      ++n;
    }
    return n;
  }

  void putAskers(const std::vector<std::uint32_t>& views, const std::vector<ViewSet>& askers, std::size_t words) {
    host_askers_.resize(views.size() * words);
    for (std::size_t k = 0; k < views.size(); ++k)
      std::copy(askers[views[k]].words().begin(), askers[views[k]].words().end(), host_askers_.data() + k * words);
  }

  /** \brief Once a calibration, or once other views are the rank's own. */
  void project(gpu::Execution& run, const host::RigGeometry& rig, std::uint64_t rig_digest,
               const std::vector<std::uint32_t>& views) {
    rig_digest_ = 0;
    std::vector<BoxProjection> made;
    std::size_t strips = 0;
    for (const std::uint32_t view : views) {
      made.emplace_back(rig[view]);
      strips += made.back().columns().size() + made.back().rows().size();
    }
    gpu::PinnedBuffer<RayInterval> host_strips;
    gpu::PinnedBuffer<FindWindows::Projection> host_projections;
    host_strips.resize(strips);
    host_projections.resize(views.size());
    run.wait();  // for the last frame that used what is there
    strips_.resize(strips);
    std::size_t place = 0;
    for (std::size_t k = 0; k < views.size(); ++k) {
      FindWindows::Projection& projection = host_projections.data()[k];
      projection = {made[k].projector(), rig[views[k]].frustum};
      const auto put = [&](const std::vector<RayInterval>& of_view) {
        std::copy(of_view.begin(), of_view.end(), host_strips.data() + place);
        const RayInterval* const on_device = strips_.data() + place;
        place += of_view.size();
        return on_device;
      };
      projection.project.columns = put(made[k].columns());
      projection.project.rows = put(made[k].rows());
    }
    upload(run, host_strips, strips_, strips);
    upload(run, host_projections, projections_, views.size());
    run.wait();
    views_ = views;
    rig_digest_ = rig_digest;
  }

  std::uint64_t rig_digest_{0};
  std::vector<std::uint32_t> views_;
  gpu::PinnedBuffer<FindWindows::Block> host_blocks_;
  gpu::PinnedBuffer<std::uint64_t> host_views_of_blocks_, host_askers_;
  gpu::PinnedBuffer<std::uint32_t> host_least_;
  gpu::DeviceBuffer<FindWindows::Block> blocks_;
  gpu::DeviceBuffer<std::uint64_t> views_of_blocks_, askers_;
  gpu::DeviceBuffer<FindWindows::Projection> projections_;
  gpu::DeviceBuffer<RayInterval> strips_;
  gpu::DeviceBuffer<std::uint32_t> least_;
};

}  // namespace distributed
}  // namespace fuse_flow
