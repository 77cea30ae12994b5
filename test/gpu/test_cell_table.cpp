#include "../test_length.h"

#include <fuse_flow/gpu/fusion/cell_table.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace {

using namespace fuse_flow;
using fuse_flow::gpu::CellTable;
using fuse_flow::gpu::CellTableView;

/** \brief Enters keys, one a thread. */
struct Enter {
  CellTableView table;
  const std::uint64_t* keys;
  std::uint32_t* slots;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    slots[k] = table.findOrAdd(keys[k]);
    table.addPoints(slots[k], k, 1);
  }
};

/** \brief A table with keys entered, read back. */
struct Entered {
  std::vector<std::uint64_t> table;
  std::vector<std::uint32_t> slots, counts, first, in_use;
  std::uint32_t used{0}, too_full{0};

  Entered(const std::vector<std::uint64_t>& keys, std::size_t capacity) {
    gpu::Execution run;
    gpu::DeviceBuffer<std::uint64_t> device_keys;
    gpu::DeviceBuffer<std::uint32_t> device_slots, counters;
    device_keys.resize(keys.size());
    device_slots.resize(keys.size());
    counters.resize(2);
    CellTable cells;
    const CellTableView view = cells.start(run, capacity, counters.data(), counters.data() + 1);
    run.copy(device_keys.data(), keys.data(), keys.size());
    run.forEach(keys.size(), Enter{view, device_keys.data(), device_slots.data()});
    const auto read = [&](const auto* from, std::size_t n, auto& to) {
      to.resize(n);
      run.copy(to.data(), from, n);
    };
    read(std::as_const(device_slots).data(), keys.size(), slots);
    read(std::as_const(view.keys), cells.capacity(), table);
    read(std::as_const(view.counts), cells.capacity(), counts);
    read(std::as_const(view.first), cells.capacity(), first);
    run.copy(&used, std::as_const(view.used), 1);
    run.copy(&too_full, std::as_const(view.too_full), 1);
    run.wait();
    read(std::as_const(view.slots), used, in_use);
    run.wait();
  }
};

/** \brief Expects each key in the slot that was returned for it, with its points, unless it was rejected; and nothing else. */
void expectEveryKeyInItsSlot(const std::vector<std::uint64_t>& keys, const Entered& entered) {
  struct Cell {
    std::uint32_t slot, count, first;
  };
  std::map<std::uint64_t, Cell> cells;
  std::size_t turned_away = 0;
  for (std::uint32_t k = 0; k < keys.size(); ++k) {
    const std::uint32_t slot = entered.slots[k];
    if (slot == CellTableView::kNone) {
      ++turned_away;
      continue;
    }
    ASSERT_LT(slot, entered.table.size());
    ASSERT_EQ(entered.table[slot], keys[k]) << "of point " << k;
    Cell& cell = cells.emplace(keys[k], Cell{slot, 0, k}).first->second;
    ASSERT_EQ(slot, cell.slot) << "of point " << k;
    ++cell.count;
  }
  EXPECT_EQ(turned_away, entered.too_full);
  EXPECT_EQ(entered.used, cells.size());
  std::vector<std::uint32_t> slots;
  for (const auto& [key, cell] : cells) {
    ASSERT_EQ(entered.counts[cell.slot], cell.count);
    ASSERT_EQ(entered.first[cell.slot], cell.first);
    slots.push_back(cell.slot);
  }
  std::vector<std::uint32_t> in_use = entered.in_use;
  std::sort(slots.begin(), slots.end());
  std::sort(in_use.begin(), in_use.end());
  EXPECT_EQ(in_use, slots);
  EXPECT_EQ(entered.table.size() - slots.size(),
            static_cast<std::size_t>(std::count(entered.table.begin(), entered.table.end(), CellTableView::kEmpty)));
}

TEST(GpuCellTable, EveryKeyHasOneSlotItsNumberOfPointsAndItsFirst) {
  std::mt19937_64 random(3);
  std::vector<std::uint64_t> keys(50000);
  for (std::uint64_t& key : keys)
    key = cellKey({static_cast<int>(random() % 20) - 10, static_cast<int>(random() % 20), 5});
  const Entered entered(keys, 1 << 14);
  EXPECT_EQ(entered.used, 400u);
  EXPECT_EQ(entered.too_full, 0u);
  expectEveryKeyInItsSlot(keys, entered);
}

/** \brief n distinct keys of cells drawn at random, every third of them twice, in any order. */
std::vector<std::uint64_t> distinctKeys(std::size_t n) {
  std::mt19937_64 random(4);
  std::set<std::uint64_t> distinct;
  const auto coordinate = [&] { return static_cast<int>(random() % 200) - 100; };
  while (distinct.size() < n) {
    const int x = coordinate(), y = coordinate();
    distinct.insert(cellKey({x, y, coordinate()}));
  }
  std::vector<std::uint64_t> keys(distinct.begin(), distinct.end());
  for (std::size_t k = 0; k < n; k += 3) keys.push_back(keys[k]);
  std::shuffle(keys.begin(), keys.end(), random);
  return keys;
}

TEST(GpuCellTable, FourFifthsOfTheSlotsMayBeInUse) {
  constexpr std::size_t capacity = 1 << 16;
  const std::size_t n = capacity * 4 / 5;
  const std::vector<std::uint64_t> keys = distinctKeys(n);
  const Entered entered(keys, capacity);
  EXPECT_EQ(entered.too_full, 0u);
  EXPECT_EQ(entered.used, n);
  expectEveryKeyInItsSlot(keys, entered);
}

// Beyond that a search may take too long: then it says so, and four times the slots are enough.
TEST(GpuCellTable, FullerItKeepsAllThatItDoesNotTurnAway) {
  constexpr std::size_t capacity = 1 << 16;
  for (const std::size_t percent : {90u, 95u, 100u}) {
    if (shortTests() && percent < 100) continue;
    SCOPED_TRACE(percent);
    const std::size_t n = capacity * percent / 100;
    const std::vector<std::uint64_t> keys = distinctKeys(n);
    const Entered full(keys, capacity);
    EXPECT_GT(full.used, n * 9 / 10);
    EXPECT_TRUE(full.used == n || full.too_full > 0);
    expectEveryKeyInItsSlot(keys, full);
    const Entered grown(keys, 4 * capacity);
    EXPECT_EQ(grown.too_full, 0u);
    EXPECT_EQ(grown.used, n);
    expectEveryKeyInItsSlot(keys, grown);
  }
}

TEST(GpuCellTable, KeysThatAllHashToOnePlaceAreKeptApart) {
  std::vector<std::uint64_t> keys;
  for (std::uint64_t key = 0; keys.size() < 200; ++key)
    if ((hashCellKey(key) & 0x3fffu) == 77) keys.push_back(key);
  const Entered entered(keys, 1 << 14);
  EXPECT_EQ(entered.used, 200u);
  EXPECT_EQ(entered.too_full, 0u);
  expectEveryKeyInItsSlot(keys, entered);
}

TEST(GpuCellTable, MoreCollisionsThanASearchLooksAtAreReported) {
  std::vector<std::uint64_t> keys;
  for (std::uint64_t key = 0; keys.size() < 400; ++key)
    if ((hashCellKey(key) & 0x3fffu) == 77) keys.push_back(key);
  const Entered entered(keys, 1 << 14);
  EXPECT_EQ(entered.used, std::uint32_t{CellTableView::kMaxProbes});
  EXPECT_EQ(entered.too_full, 400u - CellTableView::kMaxProbes);
  expectEveryKeyInItsSlot(keys, entered);
}

TEST(GpuCellTable, MoreKeysThanSlotsAreReportedAndNothingIsOverwritten) {
  std::vector<std::uint64_t> keys(20000);
  for (std::size_t k = 0; k < keys.size(); ++k) keys[k] = k * k;
  const Entered entered(keys, 1 << 14);
  EXPECT_GT(entered.too_full, 0u);
  EXPECT_LE(entered.used, 1u << 14);
  EXPECT_GT(entered.used, 15000u);
  expectEveryKeyInItsSlot(keys, entered);
}

}  // namespace
