#include <fuse_flow/gpu/cell_table.h>

#include <gtest/gtest.h>

#include <map>
#include <random>
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
  std::vector<std::uint32_t> slots, counts, first;
  std::uint32_t used{0}, too_full{0};

  Entered(const std::vector<std::uint64_t>& keys, std::size_t capacity) {
    gpu::Execution run;
    gpu::DeviceBuffer<std::uint64_t> device_keys;
    gpu::DeviceBuffer<std::uint32_t> device_slots, counters;
    device_keys.resize(keys.size());
    device_slots.resize(keys.size());
    counters.resize(2);
    CellTable table;
    const CellTableView view = table.start(run, capacity, counters.data(), counters.data() + 1);
    run.copy(device_keys.data(), keys.data(), keys.size());
    run.forEach(keys.size(), Enter{view, device_keys.data(), device_slots.data()});
    slots.resize(keys.size());
    counts.resize(table.capacity());
    first.resize(table.capacity());
    run.copy(slots.data(), static_cast<const std::uint32_t*>(device_slots.data()), keys.size());
    run.copy(counts.data(), static_cast<const std::uint32_t*>(view.counts), table.capacity());
    run.copy(first.data(), static_cast<const std::uint32_t*>(view.first), table.capacity());
    run.copy(&used, static_cast<const std::uint32_t*>(view.used), 1);
    run.copy(&too_full, static_cast<const std::uint32_t*>(view.too_full), 1);
    run.wait();
  }
};

TEST(GpuCellTable, EveryKeyHasOneSlotItsNumberOfPointsAndItsFirst) {
  std::mt19937_64 random(3);
  std::vector<std::uint64_t> keys(50000);
  for (std::uint64_t& key : keys)
    key = cellKey({static_cast<int>(random() % 20) - 10, static_cast<int>(random() % 20), 5});
  std::map<std::uint64_t, std::uint32_t> count, first;
  for (std::uint32_t k = 0; k < keys.size(); ++k) {
    ++count[keys[k]];
    first.emplace(keys[k], k);
  }
  const Entered entered(keys, 1 << 14);
  EXPECT_EQ(entered.used, count.size());
  EXPECT_EQ(entered.too_full, 0u);
  std::map<std::uint64_t, std::uint32_t> slot;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const std::uint32_t s = slot.emplace(keys[k], entered.slots[k]).first->second;
    ASSERT_EQ(entered.slots[k], s);
    ASSERT_EQ(entered.counts[s], count[keys[k]]);
    ASSERT_EQ(entered.first[s], first[keys[k]]);
  }
}

TEST(GpuCellTable, KeysThatAllHashToOnePlaceAreKeptApart) {
  std::vector<std::uint64_t> keys;
  for (std::uint64_t key = 0; keys.size() < 200; ++key)
    if ((hashCellKey(key) & 0x3fffu) == 77) keys.push_back(key);
  const Entered entered(keys, 1 << 14);
  EXPECT_EQ(entered.used, 200u);
  EXPECT_EQ(entered.too_full, 0u);
}

TEST(GpuCellTable, MoreCollisionsThanASearchLooksAtAreReported) {
  std::vector<std::uint64_t> keys;
  for (std::uint64_t key = 0; keys.size() < 400; ++key)
    if ((hashCellKey(key) & 0x3fffu) == 77) keys.push_back(key);
  const Entered entered(keys, 1 << 14);
  EXPECT_EQ(entered.used, std::uint32_t{CellTableView::kMaxProbes});
  EXPECT_EQ(entered.too_full, 400u - CellTableView::kMaxProbes);
}

TEST(GpuCellTable, MoreKeysThanSlotsAreReportedAndNothingIsOverwritten) {
  std::vector<std::uint64_t> keys(20000);
  for (std::size_t k = 0; k < keys.size(); ++k) keys[k] = k * k;
  const Entered entered(keys, 1 << 14);
  EXPECT_GT(entered.too_full, 0u);
  EXPECT_LE(entered.used, 1u << 14);
}

}  // namespace
