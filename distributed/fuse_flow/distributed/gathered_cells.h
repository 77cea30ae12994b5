#pragma once

#include <fuse_flow/distributed/coded_message.h>

#include <pcl/point_cloud.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Of a fused coarse cell. */
struct GatheredCell {
  std::uint32_t first_point;  ///< its number among the frame's
  std::uint32_t fused;        ///< how many points it gave
};

/** \brief The cells of one rank, in the order of their points in its cloud. */
using GatheredCells = std::vector<GatheredCell>;

/** \brief A rank's cells and cloud as a message. \param parts receives what its bytes are */
template <typename PointT>
void writeGathered(const GatheredCells& cells, const pcl::PointCloud<PointT>& part, Message& message,
                   MessageParts& parts) {
  MessageWriter out(message);
  out.put(static_cast<std::uint64_t>(cells.size()));
  out.put(static_cast<std::uint64_t>(part.size()));
  out.put(static_cast<std::uint8_t>(part.is_dense));
  out.put(cells.data(), cells.size());
  parts = {{message.size()}, {part.size() * sizeof(PointT), ByteKind::Words, sizeof(PointT) / sizeof(std::uint32_t)}};
  if (part.empty()) return;
  std::memcpy(out.room(part.size() * sizeof(PointT)), static_cast<const void*>(part.points.data()),
              part.size() * sizeof(PointT));
}

/** \brief Puts the clouds of all ranks together, cell by cell in the order of their first points: that of one process. \param own cells and
 *  cloud of this rank  \param from the other ranks  \param messages theirs */
template <typename PointT>
void mergeGathered(const GatheredCells& own, const pcl::PointCloud<PointT>& part, const std::vector<int>& from,
                   const std::vector<Message>& messages, pcl::PointCloud<PointT>& whole) {
  struct Piece {
    std::uint32_t first_point, count;
    const char* points;
  };
  std::vector<Piece> pieces;
  const auto add = [&](const GatheredCell* cells, std::size_t n, const char* points) {
    for (std::size_t c = 0; c < n; ++c) {
      pieces.push_back({cells[c].first_point, cells[c].fused, points});
      points += cells[c].fused * sizeof(PointT);
    }
  };
  add(own.data(), own.size(), reinterpret_cast<const char*>(part.points.data()));
  std::size_t total = part.size();
  bool dense = part.is_dense;
  for (std::size_t k = 0; k < messages.size(); ++k) {
    MessageReader in(messages[k], from[k]);
    const auto cell_count = static_cast<std::size_t>(in.get<std::uint64_t>());
    const auto points = static_cast<std::size_t>(in.get<std::uint64_t>());
    dense = in.get<std::uint8_t>() != 0 && dense;
    GatheredCells cells;
    const char* bytes = in.take(cell_count, sizeof(GatheredCell));
    cells.resize(cell_count);
    if (cell_count > 0) std::memcpy(cells.data(), bytes, cell_count * sizeof(GatheredCell));
    std::size_t fused = 0;
    for (const GatheredCell& cell : cells) fused += cell.fused;
    if (fused != points) in.fail("cells that do not have its points");
    add(cells.data(), cells.size(), in.take(points, sizeof(PointT)));
    in.finish();
    total += points;
  }
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.first_point < b.first_point; });
  whole.resize(total);
  char* to = reinterpret_cast<char*>(whole.points.data());
  for (const Piece& piece : pieces) {
    const std::size_t bytes = piece.count * sizeof(PointT);
    if (bytes > 0) std::memcpy(to, piece.points, bytes);
    to += bytes;
  }
  whole.header = part.header;
  whole.width = static_cast<std::uint32_t>(total);
  whole.height = 1;
  whole.is_dense = dense;
  whole.sensor_origin_ = part.sensor_origin_;
  whole.sensor_orientation_ = part.sensor_orientation_;
}

}  // namespace distributed
}  // namespace fuse_flow
