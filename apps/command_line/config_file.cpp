#include "command_line/config_file.h"

#include "recordings/files/cut_short.h"

#include <fuse_flow/recordings/error.h>

#include <sstream>
#include <string>

namespace fuse_flow::command_line {
namespace {

/** \brief All of a file, or of a pipe; not of what has no end. */
std::string readAll(std::istream& input) {
  constexpr std::size_t most = 1 << 20;
  std::string text(most + 1, '\0');
  input.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(input.gcount()));
  if (text.size() > most) throw CLI::ConfigError("is longer than 1 MiB, must be lines of name = value");
  return text;
}

std::string trimmed(const std::string& text) { return CLI::detail::trim_copy(text); }

/** \brief What is wrong with a line at which CLI11 would say nothing; empty if nothing is. */
std::string problemOf(const std::string& line) {
  const std::string text = trimmed(line);
  if (text.empty() || text[0] == '#' || text[0] == ';') return "";
  const std::size_t sign = text.find('=');
  if (sign == 0 || text.size() < 3) return "must be name = value";
  if (sign == std::string::npos) return "";
  const std::string value = trimmed(text.substr(sign + 1, text.find('#', sign) - sign - 1));
  return !value.empty() && value.front() == '[' && value.back() != ']' ? "must close its list with ]" : "";
}

}  // namespace

std::vector<CLI::ConfigItem> ConfigFile::from_config(std::istream& input) const {
  const std::string text = readAll(input);
  std::istringstream lines(text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::string problem = problemOf(line);
    if (!problem.empty())
      throw CLI::ConfigError("line " + std::to_string(number) + " is '" + io::cutShort(trimmed(line)) + "', " +
                             problem);
  }
  std::istringstream checked(text);
  return CLI::ConfigTOML::from_config(checked);
}

}  // namespace fuse_flow::command_line
