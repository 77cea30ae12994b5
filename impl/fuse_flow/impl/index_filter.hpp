#pragma once

#include <pcl/types.h>

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

}  // namespace detail
}  // namespace fuse_flow
