#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::io {

/** \brief What a tool reads, so that none of its outputs takes the place of it. */
class InputFiles {
 public:
  /** \brief Of none. */
  InputFiles() = default;
  /** \brief Of some. \param paths as add() takes them */
  explicit InputFiles(const std::vector<std::string>& paths);

  /** \brief A file, or a folder all of which is input. An empty name, and what is not there, is none. */
  void add(const std::string& path);

  /** \brief Throws OptionError if the output of an option is an input, by whatever name and through whatever links, or would lie in
   *  a folder of inputs. \param option as it is written, "-o"  \param path need not be there */
  void refuseToReplace(const std::string& option, const std::string& path);

 private:
  using Identity = std::pair<std::uint64_t, std::uint64_t>;  // device and number of what a name stands for

  void lookInto(const std::string& folder);

  std::set<Identity> files_, folders_;
  std::vector<std::string> not_looked_into_;  ///< folders, which may hold links to what lies elsewhere
};

}  // namespace fuse_flow::io
