#pragma once

#include <pcl/common/io.h>
#include <pcl/filters/impl/filter_indices.hpp>
#include <pcl/impl/pcl_base.hpp>  // PCL compiles its base classes for its own point types only

namespace fuse_flow {
namespace detail {

/** \brief The loop that every pcl::FilterIndices needs: splits indices into kept and removed. As in PCL's own filters,
 *  what is not valid() is removed whether negative or not. */
template <typename Valid, typename Keep>
void splitIndices(const pcl::Indices& indices, bool negative, bool extract_removed, pcl::Indices& kept,
                  pcl::Indices& removed, const Valid& valid, const Keep& keep) {
  pcl::Indices selected;
  selected.reserve(indices.size());
  removed.clear();
  for (const pcl::index_t index : indices) {
    if (valid(index) && keep(index) != negative) {
      selected.push_back(index);
    } else if (extract_removed) {
      removed.push_back(index);
    }
  }
  kept.swap(selected);  // indices and kept may be the same object
}

/** \brief The input point from which pcl::copyPointCloud() made point i of the output. If there are as many indices as points, it copies
 *  the whole cloud and ignores the order of the indices. */
inline std::size_t copiedFrom(const pcl::Indices& indices, std::size_t input_size, std::size_t i) {
  return indices.size() == input_size ? i : static_cast<std::size_t>(indices[i]);
}

}  // namespace detail
}  // namespace fuse_flow
