#pragma once

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/math/cell.h>
#include <fuse_flow/math/representatives.h>

#include <pcl/exceptions.h>

#include <cstdint>
#include <sstream>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Consecutive points that lie in one coarse cell. */
struct Run {
  std::uint32_t cell{0};
  std::uint32_t begin{0};
  std::uint32_t count{0};
};

/** \brief Open-addressing hash table from cell keys to numbers in order of first appearance; keeps its memory. */
class CellTable {
 public:
  void clear() {
    for (const std::uint32_t slot : used_) slots_[slot] = kEmpty;
    used_.clear();
    keys_.clear();
  }

  std::size_t size() const { return keys_.size(); }
  std::uint64_t key(std::size_t cell) const { return keys_[cell]; }

  static constexpr std::uint32_t kEmpty = 0xffffffffu;

  /** \brief kEmpty if the key is not there. */
  std::uint32_t find(std::uint64_t key) const {
    if (slots_.empty()) return kEmpty;
    std::size_t slot = hashCellKey(key) & mask();
    while (slots_[slot] != kEmpty && keys_[slots_[slot]] != key) slot = (slot + 1) & mask();
    return slots_[slot];
  }

  std::uint32_t findOrAdd(std::uint64_t key) {
    if (2 * (keys_.size() + 1) > slots_.size()) grow();
    std::size_t slot = hashCellKey(key) & mask();
    while (slots_[slot] != kEmpty) {
      if (keys_[slots_[slot]] == key) return slots_[slot];
      slot = (slot + 1) & mask();
    }
    slots_[slot] = static_cast<std::uint32_t>(keys_.size());
    used_.push_back(static_cast<std::uint32_t>(slot));
    keys_.push_back(key);
    return slots_[slot];
  }

 private:
  std::size_t mask() const { return slots_.size() - 1; }

  void grow() {
    slots_.assign(slots_.empty() ? 1024 : 2 * slots_.size(), kEmpty);
    used_.clear();
    for (std::uint32_t cell = 0; cell < keys_.size(); ++cell) {
      std::size_t slot = hashCellKey(keys_[cell]) & mask();
      while (slots_[slot] != kEmpty) slot = (slot + 1) & mask();
      slots_[slot] = cell;
      used_.push_back(static_cast<std::uint32_t>(slot));
    }
  }

  std::vector<std::uint32_t> slots_;
  std::vector<std::uint32_t> used_;
  std::vector<std::uint64_t> keys_;
};

/** \brief Cuts a stretch of points into runs of one coarse cell each. Neighbouring pixels nearly always share a cell,
 *  so that the hash table is asked once a run, not once a point. */
class RunBuilder {
 public:
  void start(float cell_size) {
    inverse_size_ = 1.0f / cell_size;
    table_.clear();
    runs_.clear();
    begin_ = next_ = 0;
    low_ = {1, 1, 1};  // no cell: nothing is ≥ 1 and < 0
    high_ = {0, 0, 0};
  }

  /** \brief Points with C = 0 must not be added; they end no run by themselves, a gap in the indices does. */
  void add(std::uint32_t index, const Vec3& p) { add(index, 1, p); }

  /** \brief The same for several points of one cell, one after the other. \param p one of them */
  void add(std::uint32_t index, std::uint32_t count, const Vec3& p) {
    const Vec3 cells = inverse_size_ * p;
    const bool same = (cells.x >= low_.x) & (cells.x < high_.x) & (cells.y >= low_.y) & (cells.y < high_.y) &
                      (cells.z >= low_.z) & (cells.z < high_.z);
    if (same & (index == next_)) {
      next_ += count;
      return;
    }
    close();
    if (!same) enterCell(cells, p);
    begin_ = index;
    next_ = index + count;
  }

  /** \brief After the last point. */
  void finish() {
    close();
    begin_ = next_ = 0;
  }

  const CellTable& table() const { return table_; }
  const std::vector<Run>& runs() const { return runs_; }

 private:
  void close() {
    if (next_ > begin_) runs_.push_back({cell_, begin_, next_ - begin_});
  }

  void enterCell(const Vec3& cells, const Vec3& p) {
    if (!fitsCellKey(cells)) {
      std::ostringstream message;
      message << "fuse_flow::AdaptiveHashFusion: point (" << p.x << ", " << p.y << ", " << p.z << ") m is more than "
              << kMaxCellCoordinate << " cells of " << 1.0f / inverse_size_ << " m from the origin";
      throw pcl::PCLException(message.str());
    }
    const CellIndex c = cellIndex(cells);
    low_ = {static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z)};
    high_ = {low_.x + 1, low_.y + 1, low_.z + 1};
    cell_ = table_.findOrAdd(cellKey(c));
  }

  float inverse_size_{1};
  CellTable table_;
  std::vector<Run> runs_;
  /** \brief The cell entered last, in cells. */
  Vec3 low_{};
  Vec3 high_{};
  /** \brief The open run. */
  std::uint32_t begin_{0};
  std::uint32_t next_{0};
  std::uint32_t cell_{0};
};

/** \brief Section 5 (1) c: the frame's coarse cells with their points. Stretches are cut into runs independently, by
 *  any thread, and merged in their order, so that the result does not depend on who did which. */
class CoarseGrid {
 public:
  struct Cell {
    std::uint64_t key{0};
    std::uint32_t points{0};
    std::uint32_t begin_run{0};
    std::uint32_t end_run{0};
  };

  /** \brief One builder a stretch; fill them in parallel, then merge(). */
  std::vector<RunBuilder>& start(std::size_t stretches) {
    if (builders_.size() < stretches) builders_.resize(stretches);
    stretches_ = stretches;
    return builders_;
  }
  /** \brief Of the stretches of start(). */
  std::vector<RunBuilder>& builders() { return builders_; }

  void merge() {
    mergeIf([](std::uint64_t) { return true; });
  }

  /** \brief The same for some of the cells. \param wanted whether a cell of this key is one */
  template <typename Wanted>
  void mergeIf(const Wanted& wanted) {
    table_.clear();
    cells_.clear();
    global_.clear();
    std::size_t total_runs = 0;
    for (std::size_t s = 0; s < stretches_; ++s) {
      const CellTable& local = builders_[s].table();
      const std::size_t first = global_.size();
      for (std::size_t c = 0; c < local.size(); ++c) {
        global_.push_back(wanted(local.key(c)) ? table_.findOrAdd(local.key(c)) : CellTable::kEmpty);
        if (global_.back() == cells_.size()) cells_.push_back({local.key(c), 0, 0, 0});
      }
      for (const Run& run : builders_[s].runs()) {
        if (global_[first + run.cell] == CellTable::kEmpty) continue;
        Cell& cell = cells_[global_[first + run.cell]];
        cell.points += run.count;
        ++cell.end_run;
        ++total_runs;
      }
    }
    std::uint32_t offset = 0;
    for (Cell& cell : cells_) {
      const std::uint32_t count = cell.end_run;
      cell.begin_run = cell.end_run = offset;
      offset += count;
    }
    runs_.resize(total_runs);
    std::size_t first = 0;
    for (std::size_t s = 0; s < stretches_; ++s) {
      for (const Run& run : builders_[s].runs())
        if (global_[first + run.cell] != CellTable::kEmpty)
          runs_[cells_[global_[first + run.cell]].end_run++] = {run.begin, run.count};
      first += builders_[s].table().size();
    }
  }

  struct Stretch {
    std::uint32_t begin{0};
    std::uint32_t count{0};
  };

  /** \brief In order of first appearance. */
  const std::vector<Cell>& cells() const { return cells_; }
  /** \brief The points of cell c are those of runs()[c.begin_run … c.end_run), in ascending order. */
  const std::vector<Stretch>& runs() const { return runs_; }

 private:
  std::vector<RunBuilder> builders_;
  std::size_t stretches_{0};
  CellTable table_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t>
      global_;  ///< number of each stretch's cells among all, stretch after stretch; kEmpty: not wanted
  std::vector<Stretch> runs_;
};

}  // namespace host
}  // namespace fuse_flow
