#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::io {

/** \brief The input files of a tool, so that no output overwrites them. */
class InputFiles {
 public:
  /** \brief Of none. */
  InputFiles() = default;
  /** \brief Of some. \param paths as add() takes them */
  explicit InputFiles(const std::vector<std::string>& paths);

  /** \brief Adds a file, or a folder with all its files. An empty name, or a path that does not exist, is ignored. */
  void add(const std::string& path);

  /** \brief Throws OptionError if the output of an option is an input, under any name and through any links, or would lie in a folder of
   *  inputs. \param option as it is written, "-o" \param path need not exist */
  void refuseToReplace(const std::string& option, const std::string& path);

 private:
  using Identity = std::pair<std::uint64_t, std::uint64_t>;  // device and inode number of the file

  void lookInto(const std::string& folder);

  std::set<Identity> files_, folders_;
  std::vector<std::string> not_looked_into_;  ///< folders, which may contain links to files elsewhere
};

}  // namespace fuse_flow::io
