#pragma once

#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::io {

/** \brief The name that was most likely meant by one that is not known: a usual other name of it, or one that differs in a letter or two.
 *  Empty: none is like it.
 *  \param known all that would be right
 *  \param aliases pairs of what others call it, and what to say of it */
std::string likelyMeant(const std::string& name, const std::vector<std::string>& known,
                        const std::vector<std::pair<std::string, std::string>>& aliases = {});

}  // namespace fuse_flow::io
