#pragma once

#include <CLI/CLI.hpp>

#include <istream>
#include <vector>

namespace fuse_flow::command_line {

/** \brief The file of --config; empty if none was given. */
inline std::string configFileOf(const CLI::App& app) {
  const CLI::Option* config = app.get_config_ptr();
  return config != nullptr && config->count() > 0 ? config->as<std::string>() : std::string();
}

/** \brief Reads the file of --config as CLI11 does, which passes over lines without a name, and takes the lines after a list that
 *  is not closed as parts of it: those are errors here. */
class ConfigFile : public CLI::ConfigTOML {
 public:
  /** \brief Throws CLI::ConfigError, naming the line. */
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;
};

}  // namespace fuse_flow::command_line
