#pragma once

#include <fuse_flow/distributed/part_summary.h>
#include <fuse_flow/impl/fusion/coarse_grid.hpp>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Who fuses which cells. */
enum class Ownership {
  /** \brief The blocks in the order of a space-filling curve (Morton's), cut so that all ranks get equally many points: a rank's
   *  cells lie together, so that it needs little of the views of others. Of the pieces, a rank gets one of which it has measured much. */
  Curve,
  /** \brief By a hash of the block: as equal, and needs no order; but every rank needs nearly all of every view. */
  Hash
};

/** \brief A set of views. */
class ViewSet {
 public:
  explicit ViewSet(std::size_t views = 0) : words_((views + 63) / 64, 0) {}
  void add(std::size_t view) { words_[view / 64] |= std::uint64_t{1} << view % 64; }
  bool has(std::size_t view) const { return (words_[view / 64] >> view % 64 & 1) != 0; }
  /** \brief Views group · kViewsOfGroup + k for all bits k. */
  void add(std::uint32_t group, std::uint64_t bits) { words_[group] |= bits; }
  /** \brief Whether any view is in both. */
  bool meets(const ViewSet& other) const {
    for (std::size_t k = 0; k < words_.size(); ++k)
      if ((words_[k] & other.words_[k]) != 0) return true;
    return false;
  }
  void clear() { std::fill(words_.begin(), words_.end(), 0); }
  /** \brief A word for each group of kViewsOfGroup views. */
  const std::vector<std::uint64_t>& words() const { return words_; }

 private:
  std::vector<std::uint64_t> words_;
};

/** \brief Shares out the blocks of a frame: every rank finds the same, from what all have said of their parts. Keeps nothing but memory from
 *  frame to frame. */
class BlockOwners {
 public:
  struct Block {
    std::uint64_t key{0};
    std::uint32_t points{0};
    int owner{0};
    ViewSet views;  ///< that have points there
  };

  /** \param parts of all ranks, by rank  \param cameras of the rig  \param how by what */
  void assign(const std::vector<PartSummary>& parts, std::size_t cameras, Ownership how) {
    collect(parts, cameras);
    fusing_.clear();
    for (std::size_t r = 0; r < parts.size(); ++r)
      if (parts[r].fuses) fusing_.push_back(static_cast<int>(r));
    if (fusing_.empty())
      throw pcl::PCLException("fuse_flow::distributed: no rank fuses: setFusing() of one must be on");
    if (how == Ownership::Hash) {
      for (Block& block : blocks_) block.owner = fusing_[hashCellKey(block.key) % fusing_.size()];
    } else {
      cutCurve(parts.size());
    }
    points_of_rank_.assign(parts.size(), 0);
    for (const Block& block : blocks_) points_of_rank_[static_cast<std::size_t>(block.owner)] += block.points;
  }

  const std::vector<Block>& blocks() const { return blocks_; }

  /** \brief Who fuses a coarse cell that holds a point of the frame. */
  int ownerOf(std::uint64_t cell_key) const { return blocks_[table_.find(blockOfCell(cell_key))].owner; }

  /** \brief Calls visit(who fuses it) for PartSummary::blocks of a rank, one after the other. */
  template <typename Visit>
  void forEachOwner(int rank, const Visit& visit) const {
    for (const Origin& origin : origins_)
      if (origin.rank == rank) visit(blocks_[origin.block].owner);
  }

  /** \brief Points that a rank fuses. */
  std::uint64_t pointsOf(int rank) const { return points_of_rank_[static_cast<std::size_t>(rank)]; }

  /** \brief Points that the busiest rank fuses, over the mean of those that fuse; 1: all the same. */
  double imbalance() const {
    const auto total =
        static_cast<double>(std::accumulate(points_of_rank_.begin(), points_of_rank_.end(), std::uint64_t{0}));
    const auto most = static_cast<double>(*std::max_element(points_of_rank_.begin(), points_of_rank_.end()));
    return total > 0 ? most * static_cast<double>(fusing_.size()) / total : 1.0;
  }

 private:
  void collect(const std::vector<PartSummary>& parts, std::size_t cameras) {
    if (cameras != cameras_) blocks_.clear();
    cameras_ = cameras;
    table_.clear();
    std::size_t used = 0;
    origins_.clear();
    for (std::size_t r = 0; r < parts.size(); ++r)
      for (const BlockPoints& points : parts[r].blocks) {
        const std::uint32_t b = table_.findOrAdd(points.block);
        if (b == used) {
          if (blocks_.size() == used) blocks_.push_back({0, 0, 0, ViewSet(cameras)});
          Block& fresh = blocks_[used++];
          fresh.key = points.block;
          fresh.points = 0;
          fresh.views.clear();
        }
        blocks_[b].points += points.points;
        blocks_[b].views.add(points.group, points.views);
        origins_.push_back({b, static_cast<int>(r), points.points});
      }
    blocks_.resize(used);
  }

  /** \brief Equal pieces of the curve, one for each rank that fuses. */
  void cutCurve(std::size_t ranks) {
    order_.clear();
    std::uint64_t total = 0;
    for (std::uint32_t b = 0; b < blocks_.size(); ++b) {
      order_.emplace_back(morton(blocks_[b].key), b);
      total += blocks_[b].points;
    }
    std::sort(order_.begin(), order_.end());
    const std::size_t pieces = fusing_.size();
    std::vector<std::size_t> piece_of(blocks_.size(), 0);
    std::uint64_t before = 0;
    for (const auto& [place, b] : order_) {
      // By the middle of the block.
      const std::uint64_t middle = 2 * before + blocks_[b].points;
      piece_of[b] = std::min<std::size_t>(pieces - 1, static_cast<std::size_t>(middle * pieces / (2 * total)));
      before += blocks_[b].points;
    }
    std::vector<std::uint64_t> measured(pieces * ranks, 0);  // of each piece by each rank
    for (const Origin& origin : origins_)
      measured[piece_of[origin.block] * ranks + static_cast<std::size_t>(origin.rank)] += origin.points;
    const std::vector<int> rank_of = ranksOfPieces(measured, pieces, ranks);
    for (std::uint32_t b = 0; b < blocks_.size(); ++b) blocks_[b].owner = rank_of[piece_of[b]];
  }

  /** \brief The piece of which a rank has measured the most goes to that rank, then the next of those that are left. */
  std::vector<int> ranksOfPieces(const std::vector<std::uint64_t>& measured, std::size_t pieces,
                                 std::size_t ranks) const {
    std::vector<std::tuple<std::uint64_t, std::size_t, int>> wishes;
    for (std::size_t piece = 0; piece < pieces; ++piece)
      for (const int rank : fusing_)
        wishes.emplace_back(measured[piece * ranks + static_cast<std::size_t>(rank)], piece, rank);
    std::sort(wishes.begin(), wishes.end(), [](const auto& a, const auto& b) {
      if (std::get<0>(a) != std::get<0>(b)) return std::get<0>(a) > std::get<0>(b);
      return std::tie(std::get<1>(a), std::get<2>(a)) < std::tie(std::get<1>(b), std::get<2>(b));
    });
    std::vector<int> rank_of(pieces, -1);
    std::vector<bool> taken(ranks, false);
    for (const auto& [points, piece, rank] : wishes) {
      if (rank_of[piece] >= 0 || taken[static_cast<std::size_t>(rank)]) continue;
      rank_of[piece] = rank;
      taken[static_cast<std::size_t>(rank)] = true;
    }
    return rank_of;
  }

  /** \brief The bits of x, y and z in turn: near on this curve is near in space. */
  static std::uint64_t morton(std::uint64_t key) {
    const auto spread = [](std::uint64_t v) {
      v &= 0x1fffff;
      v = (v | v << 32) & 0x1f00000000ffffull;
      v = (v | v << 16) & 0x1f0000ff0000ffull;
      v = (v | v << 8) & 0x100f00f00f00f00full;
      v = (v | v << 4) & 0x10c30c30c30c30c3ull;
      return (v | v << 2) & 0x1249249249249249ull;
    };
    return spread(key) | spread(key >> 21) << 1 | spread(key >> 42) << 2;
  }

  struct Origin {
    std::uint32_t block;
    int rank;
    std::uint32_t points;
  };

  host::CellTable table_;
  std::size_t cameras_{0};
  std::vector<Block> blocks_;
  std::vector<Origin> origins_;
  std::vector<int> fusing_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order_;
  std::vector<std::uint64_t> points_of_rank_;
};

}  // namespace distributed
}  // namespace fuse_flow
