#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fuse_flow_fuzz {

/** \brief The path of a file with these bytes, for parsers that read no memory. In a folder of this process's, in memory where the system has such a file
 *  system; it is there until the next file of that name is written. \param name may be below folders */
std::string scratchFile(const std::string& name, std::string_view bytes);

/** \brief The folder of these files, emptied. */
std::string emptyScratchFolder();

/** \brief An input that stands for several files: its parts, between separators, in the order of the names. A name beyond the parts has no file, an empty part
 *  is an empty file. */
void scratchFiles(const std::vector<std::string>& names, std::string_view input);

/** \brief Such an input. */
std::string joinedFiles(const std::vector<std::string>& files);

}  // namespace fuse_flow_fuzz
