#pragma once

#include <fuse_flow/distributed/part_summary.h>
#include <fuse_flow/gpu/fusion/generate_points.h>
#include <fuse_flow/gpu/runtime/execution.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Groups of kViewsOfGroup views that a key of a BlockTable tells apart; one more, and a key might be that of an empty slot. */
constexpr std::uint32_t kMaxViewGroups = 127;

/** \brief Where the points of a rank's own views are counted: by the block that they lie in, and by groups of views. A key has 19 bits a
 *  coordinate of the block and 7 bits for the group. */
struct BlocksOfViews {
  gpu::CellTableView table;
  std::uint32_t* views;  ///< two words a slot: a bit for each view of the group that has points there

  FUSE_FLOW_HD std::uint64_t keyOf(const CellIndex& cell, std::uint32_t view) const {
    const CellIndex block = blockOf(cell);
    const auto biased = [](std::int32_t v) { return static_cast<std::uint64_t>(v + (1 << 18)) & 0x7ffffu; };
    return biased(block.x) | biased(block.y) << 19 | biased(block.z) << 38 |
           static_cast<std::uint64_t>(view / kViewsOfGroup) << 57;
  }
  FUSE_FLOW_HD static CellIndex blockOfKey(std::uint64_t key) {
    const auto unbiased = [](std::uint64_t bits) { return static_cast<std::int32_t>(bits & 0x7ffffu) - (1 << 18); };
    return {unbiased(key), unbiased(key >> 19), unbiased(key >> 38)};
  }

  FUSE_FLOW_HD void addPoints(std::uint32_t slot, std::uint32_t view, std::uint32_t, std::uint32_t count) const {
    if (slot == gpu::CellTableView::kNone) return;
    gpu::atomicAddTo(table.counts + slot, count);
    const std::uint32_t bit = 1u << view % 32;
    std::uint32_t* const word = views + 2 * slot + view % kViewsOfGroup / 32;
    if ((gpu::atomicLoad(word) & bit) == 0) gpu::atomicOrTo(word, bit);
  }
};

/** \brief Writes the slots in use to where the host reads them, as far as there is room. */
struct GatherBlocks {
  BlocksOfViews blocks;
  BlockPoints* to;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    if (k >= *blocks.table.used) return;
    const std::uint32_t slot = blocks.table.slots[k];
    const std::uint64_t key = blocks.table.keys[slot];
    const std::uint64_t low = blocks.views[2 * slot], high = blocks.views[2 * slot + 1];
    to[k] = {cellKey(BlocksOfViews::blockOfKey(key)), low | high << 32, static_cast<std::uint32_t>(key >> 57),
             blocks.table.counts[slot]};
  }
};

/** \brief Tells each slot in use who fuses its block. */
struct PutOwners {
  const std::uint32_t* slots;
  const std::int32_t* owners;  // in the order of slots
  std::int32_t* of_slots;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const { of_slots[slots[k]] = owners[k]; }
};

/** \brief The blocks of a rank's own points, found on the device, with their owners once these are known. */
class BlockTable {
 public:
  std::size_t capacity() const { return table_.capacity(); }
  /** \brief For generate(): how full it is. */
  const gpu::CellTable& table() const { return table_; }

  /** \brief Empties it. \param used, too_full see gpu::CellTableView */
  BlocksOfViews start(gpu::Execution& run, std::size_t capacity, std::uint32_t* used, std::uint32_t* too_full) {
    const gpu::CellTableView table = table_.start(run, capacity, used, too_full);
    views_.resize(2 * table_.capacity());
    run.fill(views_.data(), 2 * table_.capacity(), 0);
    blocks_ = {table, views_.data()};
    return blocks_;
  }

  /** \brief After the points have been counted, so that blocks() finds them. */
  void gather(gpu::Execution& run) {
    gathered_.resize(kUsual);
    run.forEach(gathered_.capacity(), GatherBlocks{blocks_, gathered_.data()});
  }

  /** \brief Once the stream has been waited for. \param used how many there are */
  void blocks(gpu::Execution& run, std::size_t used, std::vector<BlockPoints>& blocks) {
    if (used > gathered_.capacity()) {
      gathered_.resize(used);
      gather(run);
      run.wait();
    }
    blocks.assign(gathered_.data(), gathered_.data() + used);
  }

  /** \param owners of all blocks(), in their order; the stream must have been waited for */
  void setOwners(gpu::Execution& run, const std::vector<std::int32_t>& owners) {
    owners_.resize(owners.size());
    of_slots_.resize(table_.capacity());
    std::copy(owners.begin(), owners.end(), owners_.data());
    run.forEach(owners.size(), PutOwners{blocks_.table.slots, owners_.data(), of_slots_.data()});
  }

  /** \brief Of each slot in use. */
  const std::int32_t* owners() const { return of_slots_.data(); }

  std::size_t bytes() const { return table_.bytes() + views_.bytes() + of_slots_.bytes(); }

 private:
  static constexpr std::size_t kUsual = std::size_t{1} << 14;

  gpu::CellTable table_;
  BlocksOfViews blocks_{};
  gpu::DeviceBuffer<std::uint32_t> views_;
  gpu::DeviceBuffer<std::int32_t> of_slots_;
  gpu::PinnedBuffer<BlockPoints> gathered_;
  gpu::PinnedBuffer<std::int32_t> owners_;
};

}  // namespace distributed
}  // namespace fuse_flow
