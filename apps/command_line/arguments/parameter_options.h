#pragma once

#include <fuse_flow/fuse_flow.h>

#include <CLI/CLI.hpp>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace fuse_flow::command_line {

/** \brief Every parameter of the library as a command-line option, named as in the headers. */
class ParameterOptions {
 public:
  explicit ParameterOptions(CLI::App& app);
  ParameterOptions(const ParameterOptions&) = delete;
  ParameterOptions& operator=(const ParameterOptions&) = delete;

  /** \brief The defaults, or the published forms, with what was given on top. Throws io::OptionError, naming the option as
   *  the command line does. */
  FuseFlowParameters parameters() const;

  /** \brief A line for each option that was given and does less than its name says, with what would be right. */
  std::vector<std::string> advice() const;

  /** \brief From here on parameters() begins with what suits depth that was estimated from colour images, unless the command line says what made
   *  it.  \param views how many have depth; two can only agree with one another
   *  \returns the options that would do the same; empty: the command line says it */
  std::string assumeStereo(std::size_t views);
  /** \brief What made the depth: camera, stereo or network. */
  const std::string& depthSource() const { return depth_source_; }

 private:
  /** \brief Whether the command line, or its configuration file, has an option. */
  bool given(const char* option) const;

  template <typename Value>
  void add(CLI::App& app, const std::string& name, Value& member, const std::string& help);
  template <typename Enum>
  void addEnum(CLI::App& app, const std::string& name, Enum& member, const std::map<std::string, Enum>& values,
               const std::string& help);
  template <typename Value>
  void overrideWhenGiven(CLI::Option* option, const Value& member);

  const CLI::App& app_;
  bool published_{false};
  bool of_two_views_{false};  ///< the depth
  std::string depth_source_{"camera"};
  FuseFlowParameters given_;
  std::vector<float> crop_box_;
  std::vector<std::function<void(FuseFlowParameters&)>> overrides_;
  /** \brief What the library calls a parameter, and its option. */
  std::map<std::string, std::string> option_of_;
};

}  // namespace fuse_flow::command_line
