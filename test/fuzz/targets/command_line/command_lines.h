#pragma once

#include "../../fuzz_target.h"

#include "command_line/arguments/method_arguments.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/quality_options.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/arguments/stereo_arguments.h"
#include "command_line/config_file.h"
#include "command_line/printable.h"
#include "recordings/range.h"

#include <pcl/exceptions.h>

#include <algorithm>
#include <sstream>

namespace fuse_flow_fuzz {

/** \brief What a tool does before it looks at its inputs. CLI11's errors and ours are what a user is told; what they say must be one line when it is printed. */
inline void parseCommandLine(std::vector<std::string> words) {
  using namespace fuse_flow;
  CLI::App app("fuzzed", "fuse_flow_fuse");
  ReprojectionQualityParameters quality;
  const command_line::RecordingArguments recording(app);
  command_line::addQualityOptions(app, quality);
  const command_line::MethodArguments method(app);
  const command_line::StereoArguments stereo(app);
  std::reverse(words.begin(), words.end());  // as CLI11 takes them
  try {
    app.parse(words);
    method.options();
    stereo.options("fuse_flow_fuse");
    const io::RecordingOptions options = recording.options();
    if (!options.views.empty()) io::parseRange(options.views, 1000, "--views");
    ++acceptedInputs();
  } catch (const CLI::Error& error) {
    command_line::shortened(command_line::printable(error.what()));
  } catch (const io::InputError& error) {
    command_line::shortened(command_line::printable(error.what()));
  } catch (const pcl::PCLException& error) {
    command_line::shortened(command_line::printable(error.what()));
  }
}

}  // namespace fuse_flow_fuzz
