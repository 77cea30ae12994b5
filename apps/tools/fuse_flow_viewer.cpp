// Plays a recording, or simulated cameras, as fused clouds in a window.

#include "command_line/arguments/method_arguments.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/arguments/simulation_arguments.h"
#include "command_line/arguments/stereo_arguments.h"
#include "command_line/config_file.h"
#include "command_line/tool.h"
#include "drawing/display.h"
#include "input_checks/estimated_depth.h"
#include "input_checks/input_checks.h"
#include "viewer/capture.h"
#include "viewer/controls/key_bindings.h"
#include "viewer/viewer.h"
#ifdef FUSE_FLOW_WITH_STREAM
#include "viewer/streamed_frames.h"
#endif

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/recordings/input_files.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace {

using namespace fuse_flow;

struct Options {
  std::vector<std::string> inputs;
  io::RecordingOptions recording;
  io::StereoOptions stereo;
  std::string simulated_scene;
  simulation::SimulationOptions simulation;
  viewing::ViewerOptions viewer;
  std::vector<std::string> keys;
  std::string screenshot;
  std::string cloud;
  std::string orbit;
  std::string config;
};

/** \brief A link, or a stream that was kept. */
std::unique_ptr<viewing::FrameSource> openStream(Options& options) {
  if (options.inputs.size() > 1) throw io::OptionError("input: must be one link, or one stream file, or a recording");
  options.viewer.method = viewing::kStreamed;
  options.viewer.measure = false;  // there is no depth to measure with
  if (options.viewer.compare != "none")
    throw io::OptionError("--compare: " + options.inputs[0] +
                          " has clouds that are fused already, and nothing beside them");
#ifdef FUSE_FLOW_WITH_STREAM
  if (std::filesystem::path(options.inputs[0]).extension() == ".ffs") {
    auto source = std::make_unique<viewing::KeptFrames>(options.inputs[0]);
    if (source->cutOff())
      command_line::printWarnings("fuse_flow_viewer",
                                  {options.inputs[0] + ": was cut off; what is before that is played"});
    return source;
  }
  try {
    return std::make_unique<viewing::StreamedFrames>(options.inputs[0], stream::ClientOptions{});
  } catch (const std::invalid_argument& error) {
    throw io::InputError(error.what());
  }
#else
  throw io::InputError(options.inputs[0] +
                       ": is a stream, and fuse_flow_viewer was built without Boost, OpenSSL or Zstandard");
#endif
}

std::unique_ptr<viewing::FrameSource> makeSource(Options& options, const command_line::MethodArguments& arguments) {
  if (options.simulated_scene.empty() == options.inputs.empty())
    throw io::OptionError("either a recording or --simulate must be given");
  const auto is_stream = [](const std::string& input) { return viewing::isStream(input); };
  if (std::any_of(options.inputs.begin(), options.inputs.end(), is_stream)) return openStream(options);
  if (!options.inputs.empty()) {
    io::RecordingOptions recording = options.recording;
    recording.skip_damaged = true;
    std::unique_ptr<io::Recording> opened =
        command_line::openRecording("fuse_flow_viewer", options.inputs, recording, options.stereo);
    options.viewer.method_options = arguments.options();  // what made the depth is known now
    command_line::printWarnings("fuse_flow_viewer",
                                io::estimatedDepthAdvice(io::stereoOf(opened.get()) ? "stereo" : opened->kind(),
                                                         "fuse_flow", options.viewer.method_options.parameters));
    return viewing::makeSource(std::move(opened), options.inputs.front());
  }
  simulation::SimulationOptions simulation = options.simulation;
  simulation.scene = options.simulated_scene;
  if (options.viewer.frames_per_second) simulation.frames_per_second = *options.viewer.frames_per_second;
  simulation.threads = host::resolveThreads(static_cast<int>(options.viewer.method_options.threads));
  return viewing::makeSimulatedSource(simulation);
}

/** \brief None of what --offscreen writes may take the place of an input; the keys of the window take names that are free. */
void checkOutputs(const Options& options, const viewing::FrameSource& source) {
  io::InputFiles inputs(source.inputs());
  inputs.add(options.config);
  if (!options.screenshot.empty()) inputs.refuseToReplace("--screenshot", options.screenshot);
  if (!options.cloud.empty()) inputs.refuseToReplace("--save-cloud", options.cloud);
  if (options.orbit.empty()) return;
  for (const std::string& file : viewing::filesOfFilm(options.orbit, options.viewer.orbit_pictures))
    inputs.refuseToReplace("--orbit", file);
}

/** \brief Before there is a window that could only stay empty: of the first frame something must be readable. */
void checkFirstFrame(const Options& options, viewing::FrameSource& source) {
  const std::optional<std::size_t> count = source.frameCount();
  const std::size_t first = options.viewer.first_frame;
  if (count && first >= *count)
    throw io::OptionError("--start is " + std::to_string(first) + ", must be under the " + std::to_string(*count) +
                          " frames of the recording");
  if (!count) return;
  io::LoadedFrame frame;
  source.read(first, frame);
  const auto missing = [](const DepthView& view) { return view.missing(); };
  if (!frame.damaged.empty() && std::all_of(frame.rig.views.begin(), frame.rig.views.end(), missing))
    throw io::InputError(frame.damaged[0].message + "; --start begins with another frame");
  io::InputChecks checks(options.viewer.method, options.viewer.method_options.parameters, {});
  checks.look(frame);
  command_line::printWarnings("fuse_flow_viewer", checks.complaints());
}

/** \brief "640:400" among the keys is a place that the cursor goes to. */
std::optional<std::array<int, 2>> cursorOf(const std::string& key) {
  std::array<int, 2> place{};
  int length = 0;
  if (std::sscanf(key.c_str(), "%d:%d%n", &place[0], &place[1], &length) != 2) return std::nullopt;
  if (key.size() != static_cast<std::size_t>(length)) return std::nullopt;
  return place;
}

void exportAll(const Options& options, viewing::Viewer& viewer) {
  viewer.settle();
  if (!viewer.error().empty()) throw io::InputError(viewer.error());
  if (!options.cloud.empty()) viewing::writeShownCloud(options.cloud, *viewer.shown()->clouds[0]->cloud);
  if (!options.screenshot.empty()) viewing::writeScreenshot(options.screenshot, viewer.window().renderWindow());
  if (!options.orbit.empty()) viewer.film(options.orbit);
  const std::vector<std::string>& problems = viewer.problems();
  if (problems.empty()) return;
  const std::string others = problems.size() > 1 ? " (" + std::to_string(problems.size() - 1) + " more)" : "";
  throw io::InputError(problems[0] + others + "; what was asked for is written without it");
}

/** \brief False if fusion had to be left to itself. */
bool show(const Options& options, std::unique_ptr<viewing::FrameSource> source) {
  viewing::Viewer viewer(std::move(source), options.viewer);
  for (const std::string& key : options.keys) {
    viewer.settle();
    if (const auto cursor = cursorOf(key))
      viewer.window().moveCursor((*cursor)[0], (*cursor)[1]);
    else
      viewer.window().pressKey(key);
  }
  options.viewer.offscreen ? exportAll(options, viewer) : viewer.run();
  return viewer.stopWithin(std::chrono::milliseconds(200));
}

int run(Options& options, const command_line::MethodArguments& arguments) {
  const bool exports = !options.screenshot.empty() || !options.cloud.empty() || !options.orbit.empty();
  if (exports != options.viewer.offscreen)
    throw io::OptionError(exports ? "--screenshot, --save-cloud and --orbit need --offscreen; in the window the keys "
                                    "j, Ctrl w and Ctrl p write into --folder, as --format and --film-format say"
                                  : "--offscreen needs --screenshot, --save-cloud or --orbit");
  if (!options.screenshot.empty() && !viewing::isPictureFile(options.screenshot))
    throw io::OptionError("--screenshot " + options.screenshot + ": must end in .png or .jpg");
  if (!options.cloud.empty() && !viewing::isCloudFile(options.cloud))
    throw io::OptionError("--save-cloud is " + options.cloud + ", must end with .ply, .pcd, .vtk, .ifs or .obj");
  for (const std::string& key : options.keys)
    if (!viewing::findBinding(key) && !cursorOf(key))
      throw io::OptionError("--press is " + key + ", which is no key of the viewer");
  std::unique_ptr<viewing::FrameSource> source = makeSource(options, arguments);
  checkOutputs(options, *source);
  checkFirstFrame(options, *source);
  if (options.viewer.color_by == viewing::ColorBy::TruthDistance && !source->knowsTruth())
    throw io::OptionError("--color-by truth: the truth of this recording is not known");
  drawing::requireDisplay("fuse_flow_viewer");
  const bool ended = show(options, std::move(source));
  const int code = io::interrupt_requested ? command_line::kInterrupted : command_line::kSuccess;
  // The window, its threads and its memory are gone by now; the frame at hand is for nobody.
  if (!ended) std::_Exit(code);
  return code;
}

/** \brief The names of a choice; CLI11's own help tells their numbers too. */
template <typename Choice>
CLI::Validator inWords(const std::map<std::string, Choice>& choices) {
  std::string names;
  for (const auto& [name, choice] : choices) names += (names.empty() ? "" : ",") + name;
  return CLI::Validator(
      [=](std::string& text) {
        const auto chosen = choices.find(text);
        if (chosen == choices.end()) return "'" + text + "' was given, must be one of " + names;
        text = std::to_string(static_cast<int>(chosen->second));
        return std::string();
      },
      "{" + names + "}", "");
}

void addViewOptions(CLI::App& app, Options& options) {
  viewing::ViewerOptions& v = options.viewer;
  static const std::map<std::string, viewing::Layout> layouts{{"side", viewing::Layout::SideBySide},
                                                              {"split", viewing::Layout::Split}};
  std::map<std::string, viewing::ColorBy> colors;
  for (std::size_t k = 0; k < viewing::colorByNames().size(); ++k)
    colors[viewing::colorByNames()[k]] = static_cast<viewing::ColorBy>(k);
  app.add_option("--fps", v.frames_per_second,
                 "frames a second at which the recording was taken; default: what it says itself, else 30")
      ->check(command_line::positiveNumber());
  app.add_option("--speed", v.speed, "at which it is played; 1: as it was taken")
      ->check(command_line::positiveNumber())
      ->capture_default_str();
  app.add_flag_callback(
      "--paused", [&v] { v.play = false; }, "start with the first frame standing");
  app.add_flag_callback(
      "--once", [&v] { v.loop = false; }, "do not loop");
  app.add_option("--start", v.first_frame, "number of the first frame, from 0, as in the names of its files")
      ->check(command_line::wholeNumber(0, 1000000))
      ->capture_default_str();
  app.add_flag("--refine-extrinsics", v.refine_extrinsics,
               "estimate the poses from what the cameras see, and follow them from frame to frame, as the key 0 does")
      ->excludes(app.get_option("--slide"));
  app.add_option("--compare", v.compare, "what is shown beside the fused cloud")
      ->check(CLI::IsMember(viewing::FusionControls::comparisonNames()))
      ->capture_default_str();
  app.add_option("--layout", v.layout, "side: side by side; split: one picture with a line to drag")
      ->transform(inWords(layouts))
      ->type_name("TEXT");
  app.add_option("--split", v.split, "where that line is, share of the width")
      ->check(CLI::Range(0.02, 0.98))
      ->capture_default_str();
  app.add_option("--color-by", v.color_by, "colour of the points")->transform(inWords(colors))->type_name("TEXT");
  app.add_option("--point-size", v.point_size, "pixels")
      ->check(command_line::positiveNumberUpTo(100))
      ->capture_default_str();
  app.add_option("--from", v.from, "where the viewer stands, m")->expected(3)->check(command_line::finiteNumber());
  app.add_option("--at", v.at, "what the viewer looks at, m")->expected(3)->check(command_line::finiteNumber());
  app.add_option("--up", v.up, "which way is up")->expected(3)->check(command_line::finiteNumber());
  app.add_option("--zoom", v.zoom, "narrows the view")->check(command_line::positiveNumber())->capture_default_str();
  app.add_option("--width", v.width, "of the window, pixels")
      ->check(command_line::wholeNumber(16, 16384))
      ->capture_default_str();
  app.add_option("--height", v.height, "pixels")->check(command_line::wholeNumber(16, 16384))->capture_default_str();
  app.add_option("--press", options.keys,
                 "keys pressed at the start, and places X:Y, pixels from the lower left, that the cursor goes to: "
                 "h,alt+plus,640:400,m")
      ->delimiter(',');
}

void addExportOptions(CLI::App& app, Options& options) {
  viewing::ViewerOptions& v = options.viewer;
  app.add_option("--folder", v.folder, "where the keys Ctrl w, j and Ctrl p write")->capture_default_str();
  app.add_option("--format", v.format, "of the clouds that the key Ctrl w writes")
      ->check(CLI::IsMember(viewing::cloudFormats()))
      ->capture_default_str();
  app.add_option("--film-format", v.film_format, "of the films that the key Ctrl p makes: a video, or a folder of PNGs")
      ->check(CLI::IsMember({"ogv", "png"}))
      ->capture_default_str();
  app.add_flag("--offscreen", v.offscreen,
               "no window: write what follows, and end. OpenGL wants a display even so: xvfb-run -a gives one");
  app.add_option("--screenshot", options.screenshot, ".png or .jpg file");
  app.add_option("--save-cloud", options.cloud, ".ply, .pcd, .vtk, .ifs or .obj file");
  app.add_option("--orbit", options.orbit, "once around the cloud: a .ogv video, or a folder of numbered PNGs");
  app.add_option("--orbit-pictures", v.orbit_pictures, "of a film")
      ->check(command_line::wholeNumber(1, 100000))
      ->capture_default_str();
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Plays a recording of several depth cameras as fused clouds. The key h lists what keys and mouse do.",
               "fuse_flow_viewer");
  command_line::RecordingArguments recording(app);
  CLI::Option* simulate =
      app.add_option("--simulate", options.simulated_scene,
                     "simulated cameras instead of a recording: " + command_line::listed(simulation::sceneNames()))
          ->check(command_line::oneOf(simulation::sceneNames()));
  command_line::SimulationArguments rig(app);
  rig.need(simulate);
  addViewOptions(app, options);
  addExportOptions(app, options);
  command_line::MethodArguments method(app);
  command_line::StereoArguments stereo(app);
  io::catchInterrupts();
  return command_line::runTool(app, argc, argv, [&] {
    options.inputs = recording.inputs();
    options.recording = recording.options();
    options.simulation = rig.options();
    options.viewer.fixed_rig = options.recording.slide == 0;
    options.config = command_line::configFileOf(app);
    options.viewer.method = method.method();
    options.viewer.method_options = method.options();
    command_line::printWarnings("fuse_flow_viewer", method.advice());
    options.stereo = stereo.options("fuse_flow_viewer");
    options.stereo.threads = options.viewer.method_options.threads;
    options.stereo.device = options.viewer.method_options.device;
    options.stereo.keep_bytes = std::size_t{1} << 30;  // it is played again and again
    options.stereo.all_estimated = [&](std::size_t views) { return method.assumeStereo(views); };
    return run(options, method);
  });
}
