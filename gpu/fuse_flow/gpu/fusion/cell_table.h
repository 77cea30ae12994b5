#pragma once

#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/math/cell.h>

namespace fuse_flow {
namespace gpu {

/** \brief What the kernels see of a CellTable. */
struct CellTableView {
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};
  static constexpr std::uint32_t kNone = 0xffffffffu;
  /** \brief A search that takes longer says that the table is too full. */
  static constexpr std::uint32_t kMaxProbes = 256;

  std::uint64_t* keys;
  /** \brief Points of a cell, and the number of its first one. */
  std::uint32_t* counts;
  std::uint32_t* first;
  /** \brief The slots in use, in no order; used of them. */
  std::uint32_t* slots;
  std::uint32_t* used;
  std::uint32_t* too_full;
  std::uint32_t mask;

  /** \brief The slot of a key, which is entered if it is not there; kNone if the table is too full. */
  FUSE_FLOW_HD std::uint32_t findOrAdd(std::uint64_t key) const {
    std::uint32_t slot = static_cast<std::uint32_t>(hashCellKey(key)) & mask;
    for (std::uint32_t probe = 0; probe < kMaxProbes; ++probe) {
      std::uint64_t found = atomicLoad(keys + slot);
      if (found == kEmpty) {
        found = atomicExchangeIf(keys + slot, kEmpty, key);
        if (found == kEmpty) {
          const std::uint32_t place = atomicAddTo(used, 1u);
          slots[place] = slot;
          return slot;
        }
      }
      if (found == key) return slot;
      slot = (slot + 1) & mask;
    }
    atomicAddTo(too_full, 1u);
    return kNone;
  }

  /** \brief count points of a cell, of which the first has number index. */
  FUSE_FLOW_HD void addPoints(std::uint32_t slot, std::uint32_t index, std::uint32_t count) const {
    if (slot == kNone) return;
    atomicAddTo(counts + slot, count);
    atomicMinTo(first + slot, index);
  }
};

/** \brief Open-addressing hash table of the coarse cells of a frame. A slot's place depends on who came first, so nothing that
 *  leaves the device may depend on it: cells are put in order by their first points. */
class CellTable {
 public:
  /** \brief Empties it, with room for at least capacity slots. */
  CellTableView start(Execution& run, std::size_t capacity, std::uint32_t* used, std::uint32_t* too_full) {
    while (capacity_ < capacity) capacity_ *= 2;
    keys_.resize(capacity_);
    counts_.resize(capacity_);
    first_.resize(capacity_);
    slots_.resize(capacity_);
    run.fill(keys_.data(), capacity_, 0xff);
    run.fill(counts_.data(), capacity_, 0);
    run.fill(first_.data(), capacity_, 0xff);
    run.fill(used, 1, 0);
    run.fill(too_full, 1, 0);
    return {keys_.data(),
            counts_.data(),
            first_.data(),
            slots_.data(),
            used,
            too_full,
            static_cast<std::uint32_t>(capacity_ - 1)};
  }

  std::size_t capacity() const { return capacity_; }
  std::size_t bytes() const { return keys_.bytes() + counts_.bytes() + first_.bytes() + slots_.bytes(); }

 private:
  std::size_t capacity_{1 << 14};
  DeviceBuffer<std::uint64_t> keys_;
  DeviceBuffer<std::uint32_t> counts_, first_, slots_;
};

}  // namespace gpu
}  // namespace fuse_flow
