#pragma once

#include <fuse_flow/distributed/message.h>
#include <fuse_flow/fusion/statistics.h>
#include <fuse_flow/math/cell.h>

#include <cstdint>
#include <string>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief A block has 2^kBlockBits coarse cells along each side. Blocks, not cells, are shared out among the ranks: some fifty times fewer, and nothing
 *  about a cell depends on the rest of its block. */
constexpr int kBlockBits = 2;

/** \brief The block that a coarse cell lies in. */
FUSE_FLOW_HD CellIndex blockOf(const CellIndex& cell) {
  return {cell.x >> kBlockBits, cell.y >> kBlockBits, cell.z >> kBlockBits};
}

/** \brief The key of the block that a coarse cell lies in. */
inline std::uint64_t blockOfCell(std::uint64_t cell_key) { return cellKey(blockOf(cellOfKey(cell_key))); }

/** \brief Views that share a BlockPoints. */
constexpr std::uint32_t kViewsOfGroup = 64;

/** \brief Points of some views in one block. */
struct BlockPoints {
  std::uint64_t block;  ///< its key
  std::uint64_t views;  ///< which have points there: bit k for view group · kViewsOfGroup + k
  std::uint32_t group;
  std::uint32_t points;  ///< of all of them
};
static_assert(sizeof(BlockPoints) == 24, "goes over the wire as it lies in memory");

/** \brief What a rank tells all others about its part of a frame, before anything large is sent. */
struct PartSummary {
  /** \brief Of a view that the rank has. */
  struct View {
    std::uint32_t view{0};
    std::uint32_t measured{0};  ///< pixels in range
    float noise_scale{1};
    std::uint8_t has_color{0}, has_confidence{0}, out_of_range{0};
    DepthOutOfRange range;  ///< where out_of_range is set
  };

  /** \brief Of what is sent; changes with every change of it. */
  static constexpr std::uint32_t kVersion = 3;

  std::uint64_t rig{0};         ///< FrameDigest of the cameras
  std::uint64_t parameters{0};  ///< of the parameters and settings
  std::uint32_t codec{0};       ///< its format; 0: none
  std::uint64_t stamp{0};       ///< of the frame, microseconds
  std::uint64_t gated{0};       ///< points
  std::uint8_t fuses{1};        ///< whether the rank takes a share of the cells
  std::string error;            ///< why it could not do its part; empty: it could
  std::vector<View> views;
  std::vector<BlockPoints> blocks;

  void write(Message& message) const {
    MessageWriter out(message);
    out.put(kMagic);
    out.put(kVersion);
    out.put(rig);
    out.put(parameters);
    out.put(codec);
    out.put(stamp);
    out.put(gated);
    out.put(fuses);
    out.put(error);
    out.put(static_cast<std::uint32_t>(views.size()));
    for (const View& view : views) {
      out.put(view.view);
      out.put(view.measured);
      out.put(view.noise_scale);
      out.put(view.has_color);
      out.put(view.has_confidence);
      out.put(view.out_of_range);
      out.put(static_cast<std::uint64_t>(view.range.measured));
      out.put(static_cast<std::uint64_t>(view.range.in_range));
      out.put(view.range.nearest);
      out.put(view.range.farthest);
    }
    out.put(static_cast<std::uint32_t>(blocks.size()));
    out.put(blocks.data(), blocks.size());
  }

  /** \brief Of another rank. \param cameras how many the rig has \throws RankError if the message is none, or of another version */
  void read(const Message& message, int from, std::size_t cameras) {
    MessageReader in(message, from);
    if (in.get<std::uint32_t>() != kMagic || in.get<std::uint32_t>() != kVersion)
      in.fail("what another version of this library sends: all ranks must run the same");
    rig = in.get<std::uint64_t>();
    parameters = in.get<std::uint64_t>();
    codec = in.get<std::uint32_t>();
    stamp = in.get<std::uint64_t>();
    gated = in.get<std::uint64_t>();
    fuses = in.get<std::uint8_t>();
    error = in.getText();
    const auto view_count = in.get<std::uint32_t>();
    if (view_count > cameras) in.fail("more views than the rig has cameras");
    views.resize(view_count);
    for (View& view : views) {
      view.view = in.get<std::uint32_t>();
      view.measured = in.get<std::uint32_t>();
      view.noise_scale = in.get<float>();
      view.has_color = in.get<std::uint8_t>();
      view.has_confidence = in.get<std::uint8_t>();
      view.out_of_range = in.get<std::uint8_t>();
      view.range.camera = view.view;
      view.range.measured = static_cast<std::size_t>(in.get<std::uint64_t>());
      view.range.in_range = static_cast<std::size_t>(in.get<std::uint64_t>());
      view.range.nearest = in.get<float>();
      view.range.farthest = in.get<float>();
      if (view.view >= cameras) in.fail("a view of a camera that the rig does not have");
    }
    const auto block_count = in.get<std::uint32_t>();
    const char* bytes = in.take(block_count, sizeof(BlockPoints));
    blocks.resize(block_count);
    if (block_count > 0) std::memcpy(blocks.data(), bytes, block_count * sizeof(BlockPoints));
    for (const BlockPoints& block : blocks) {
      const std::size_t first = std::size_t{block.group} * kViewsOfGroup;
      const bool fits = first < cameras && (cameras - first >= kViewsOfGroup || block.views >> (cameras - first) == 0);
      if (!fits) in.fail("points of a camera that the rig does not have");
      if (block.views == 0 || block.points == 0) in.fail("a block without points");
    }
    in.finish();
  }

 private:
  static constexpr std::uint32_t kMagic = 0x46464d50;  // "PMFF"
};

}  // namespace distributed
}  // namespace fuse_flow
