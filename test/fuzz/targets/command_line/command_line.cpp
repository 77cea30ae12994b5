#include "command_lines.h"

/** \brief The command line of fuse_flow_fuse, words between line ends: every option of a recording, of the fusion, of stereo and of quality. CLI11 keeps some KiB
 *  for each option, which the tool makes before it looks at one. */
FUSE_FLOW_FUZZ_TARGET(command_line, 4 << 20, 1024, 100) {
  std::vector<std::string> words;
  std::istringstream lines{std::string(input)};
  for (std::string line; std::getline(lines, line) && words.size() < 64;) words.push_back(line);
  fuse_flow_fuzz::parseCommandLine(words);
}
