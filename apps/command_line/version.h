#pragma once

#include <string>

namespace fuse_flow::command_line {

/** \brief What --version prints: the name of the tool, and FUSE-Flow's version. */
std::string versionOf(const std::string& tool);

/** \brief What --version --verbose prints below that, a line for each subject: what a report of a bug has to say of the build, the machine
 *  and the libraries. */
std::string describeBuild();

}  // namespace fuse_flow::command_line
