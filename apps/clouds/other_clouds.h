#pragma once

#include <functional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Clouds that an earlier run has left, and this one has not replaced: a reader of the folder would take them for frames of this
 *  recording. "OUT holds 3 clouds that this run has not written, such as …"; empty: there are none.
 *  \param output what the user named  \param folders that clouds went to: itself, or some in it; those that are not there hold none
 *  \param is_ours whether a path was written by this run */
std::string otherClouds(const std::string& output, const std::vector<std::string>& folders,
                        const std::function<bool(const std::string& path)>& is_ours);

}  // namespace fuse_flow::io
