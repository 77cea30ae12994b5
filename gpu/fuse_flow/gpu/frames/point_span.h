#pragma once

#include <cstddef>

namespace fuse_flow {
namespace gpu {

/** \brief Points in memory that someone else owns. */
template <typename PointT>
struct PointSpan {
  const PointT* points{nullptr};
  std::size_t size{0};

  const PointT* begin() const { return points; }
  const PointT* end() const { return points + size; }
};

}  // namespace gpu
}  // namespace fuse_flow
