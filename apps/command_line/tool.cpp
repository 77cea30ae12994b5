#include "command_line/tool.h"

#include "command_line/message_of.h"
#include "command_line/printable.h"
#include "command_line/version.h"
#include "recordings/files/cut_short.h"

#include <pcl/exceptions.h>

#include <algorithm>
#include <new>
#include <system_error>

namespace fuse_flow::command_line {
namespace {

/** \brief One line, whatever the exception said. */
int reportError(const CLI::App& app, std::string message, ExitCode code = kBadInput) {
  message = shortened(printable(message));
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::cerr << app.get_name() << ": " << message << std::endl;
  return code;
}

/** \brief A mistake in the file of --config, in CLI11's words or ours. */
std::string describeConfigError(CLI::App& app, const std::string& message) {
  const std::string prefix = "INI was not able to parse ";
  const std::string file = app.get_config_ptr() ? app.get_config_ptr()->as<std::string>() : "--config";
  if (message.rfind(prefix, 0) != 0) return file + ": " + message + "; see --help";
  return file + ": '" + io::cutShort(message.substr(prefix.size())) +
         "' is not an option, must be name = value; see --help";
}

}  // namespace

int runTool(CLI::App& app, int argc, char** argv, const std::function<int()>& run) {
  io::endCleanlyOnSignals();
  const PrintableStream out(std::cout), err(std::cerr);
  const CLI::Option* verbose =
      app.add_flag("--verbose",
                   "With --version: also the build, the machine and the libraries, as a report of a bug needs")
          ->configurable(false);
  app.set_version_flag(
      "--version", [&] { return versionOf(app.get_name()) + (verbose->count() > 0 ? "\n" + describeBuild() : ""); });
  std::signal(SIGXFSZ, SIG_IGN);  // a file past `ulimit -f` is then an error to report like a full disk
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::FileError&) {
    return reportError(app, app.get_config_ptr()->as<std::string>() + ": cannot be read, must be a file of options");
  } catch (const CLI::ConfigError& error) {
    return reportError(app, describeConfigError(app, error.what()), kWrongCommandLine);
  } catch (const CLI::ParseError& error) {
    return reportError(app, error.what() + std::string("; see --help"), kWrongCommandLine);
  }
  try {
    if (verbose->count() > 0) throw io::OptionError("--verbose: needs --version");
    const int code = run();
    if (!std::cout.flush()) throw io::OutputError("the standard output stream cannot be written");
    return code;
  } catch (const io::OptionError& error) {
    return reportError(app, error.what(), kWrongCommandLine);
  } catch (const pcl::PCLException& error) {
    return reportError(app, io::messageOf(error));
  } catch (const std::bad_alloc&) {
    return reportError(app, "not enough memory; must be less to work on, fewer --threads or --views");
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::resource_unavailable_try_again) return reportError(app, error.what());
    return reportError(app, "a thread cannot be started: " + error.code().message() + "; --threads asks for fewer");
  } catch (const std::exception& error) {
    return reportError(app, error.what());
  }
}

int endOfFrames(const std::string& tool, std::size_t done, std::size_t frames) {
  if (!io::interrupt_requested) return kSuccess;
  std::cerr << tool << ": interrupted after " << done << " of " << frames << " frames; those are complete" << std::endl;
  return kInterrupted;
}

}  // namespace fuse_flow::command_line
