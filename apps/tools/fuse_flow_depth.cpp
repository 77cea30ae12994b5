// Writes a recording of colour cameras again, with the depth that is estimated from their images.

#include "command_line/arguments/method_arguments.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/arguments/stereo_arguments.h"
#include "command_line/threads.h"
#include "command_line/tool.h"
#include "recordings/files/file_io.h"
#include "recordings/images/image_io.h"
#include "recordings/readers/view_files.h"
#include "recordings/still_there.h"
#include "stereo/depth_pictures.h"
#include "stereo/stereo_recording.h"

#include <fuse_flow/recordings/input_files.h>
#include <fuse_flow/recordings/rig_writer.h>

#include <cstdio>
#include <filesystem>
#include <optional>

namespace {

namespace fs = std::filesystem;
using namespace fuse_flow;

constexpr const char* kPictures = "pictures";

struct Options {
  std::vector<std::string> inputs;
  std::string frames;
  std::string output;
  unsigned int threads{0};
  io::RecordingOptions recording;
  io::StereoOptions stereo;
};

/** \brief Outside of the recording, and new or empty. */
void checkOutput(const Options& options, const io::Recording& recording) {
  io::InputFiles inputs(recording.inputs());
  const fs::path input(options.inputs[0]);
  const fs::path folder = fs::is_directory(input) ? input : input.parent_path();
  inputs.add(folder.empty() ? "." : folder.string());
  const fs::path output(options.output);
  inputs.refuseToReplace("-o", (output / "rig.json").string());
  if (fs::exists(output) && !(fs::is_directory(output) && fs::is_empty(output)))
    throw io::OutputError(output.string() + ": exists, must be a new or empty folder");
}

std::vector<bool> estimatedViews(const io::StereoRecording& recording) {
  std::vector<bool> views;
  for (std::size_t k = 0; k < recording.cameras().size(); ++k) views.push_back(recording.estimates(k));
  return views;
}

/** \brief The cameras with the unit in which their depth is written. */
io::RigDescription rigOf(const io::StereoRecording& recording, const io::LoadedFrame& first) {
  io::RigDescription rig;
  rig.frames_per_second = recording.framesPerSecond();
  for (std::size_t k = 0; k < recording.cameras().size(); ++k) {
    io::RigCamera entry;
    entry.camera = recording.cameras()[k];
    if (entry.camera.name == kPictures)
      throw io::InputError(std::string("a camera is named ") + kPictures +
                           ", as the folder of the pictures is, must have another name");
    if (recording.estimates(k) || first.rig.views[k].depth32) entry.camera.depth_scale = 1;
    rig.cameras.push_back(std::move(entry));
  }
  return rig;
}

/** \brief Colour images that were files stay byte for byte what they were, and are not written again. */
void copyColor(const fs::path& folder, std::size_t frame, io::LoadedFrame& loaded) {
  for (std::size_t k = 0; k < loaded.rig.views.size(); ++k) {
    const std::string& from = loaded.images[k].color_file;
    if (!loaded.rig.views[k].color || from.empty()) continue;
    const std::string bytes = io::readFile(from);
    const char* extension = bytes.compare(0, 4, "\x89PNG") == 0 ? ".png" : ".jpg";
    const fs::path to = folder / loaded.rig.cameras[k].name / "color" / (io::frameStem(frame) + extension);
    io::writeFile(to.string(), bytes);
    loaded.rig.views[k].color = {};
  }
}

void drawPictures(const fs::path& folder, std::size_t frame, const std::vector<bool>& of, const io::LoadedFrame& loaded,
                  const io::PictureRange& range) {
  for (std::size_t k = 0; k < of.size(); ++k) {
    if (!of[k] || loaded.rig.views[k].missing()) continue;
    const fs::path pictures = folder / kPictures / loaded.rig.cameras[k].name;
    io::makeFolder(pictures.string());
    const auto file = [&](const char* kind) { return (pictures / (io::frameStem(frame) + kind)).string(); };
    io::writeColorPng(file("_depth.png"), io::depthPicture(loaded.images[k].depth32, range));
    io::writeColorPng(file("_confidence.png"), io::confidencePicture(loaded.images[k].confidence));
  }
}

int run(const Options& options) {
  const std::unique_ptr<io::Recording> opened =
      command_line::openRecording("fuse_flow_depth", options.inputs, options.recording, options.stereo);
  io::StereoRecording* recording = io::stereoOf(opened.get());
  if (recording == nullptr)
    throw io::InputError(options.inputs[0] +
                         ": there is no view whose depth could be estimated: every camera has depth of its own, or "
                         "nothing to be matched with");
  const std::vector<std::size_t> frames = io::chooseFrames(*recording, options.frames);
  checkOutput(options, *recording);
  const fs::path folder(options.output);
  if (fs::exists(fs::path(options.inputs[0]) / "truth"))
    command_line::printWarnings("fuse_flow_depth", {"the folder truth is not copied; fuse_flow_evaluate takes " +
                                                    options.inputs[0] + " to compare with it"});
  const std::vector<bool> estimated = estimatedViews(*recording);
  const io::StillThere still_there(*recording);
  std::optional<io::RigWriter> writer;
  io::LoadedFrame loaded;
  std::size_t done = 0;
  for (const std::size_t frame : frames) {
    if (io::interrupt_requested) break;
    recording->read(frame, loaded);
    still_there.check(loaded);
    if (!writer) writer.emplace(options.output, rigOf(*recording, loaded), true);
    const io::PictureRange range = io::pictureRange(loaded, estimated);
    drawPictures(folder, frame, estimated, loaded, range);
    copyColor(folder, frame, loaded);
    writer->write(frame, loaded);
    ++done;
    std::printf(
        "frame %s: another view agrees on the depth of %.0f %% of the pixels, %.2g s; pictures from %.2f m, "
        "yellow, to %.2f m, blue\n",
        io::frameStem(frame).c_str(), 100 * recording->agreeing(), recording->seconds(),
        static_cast<double>(range.nearest), static_cast<double>(range.farthest));
    std::fflush(stdout);
  }
  if (writer) writer->finish();
  if (const int end = command_line::endOfFrames("fuse_flow_depth", done, frames.size()); end != command_line::kSuccess)
    return end;
  std::cout << options.output << ": " << done << (done == 1 ? " frame, " : " frames, ") << recording->summary()
            << std::endl;
  return command_line::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Estimates the depth of cameras that have none from their colour images, and writes it with them as a rig "
      "recording.",
      "fuse_flow_depth");
  command_line::RecordingArguments recording(app);
  recording.input()->required();
  app.add_option("-o,--output", options.output, "folder of the new recording; new or empty")
      ->check(command_line::path())
      ->required();
  app.add_option("--frames", options.frames, "A:B:STEP, B not included")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join);
  app.add_option("--threads", options.threads, "0: one per core")
      ->check(command_line::threadCount())
      ->capture_default_str();
  command_line::addDeviceOption(app, options.stereo.device, "depth is estimated", ", until it fails; then on the CPU");
  command_line::StereoArguments stereo(app, false);
  io::catchInterrupts();
  return command_line::runTool(app, argc, argv, [&] {
    options.frames = command_line::joinedList(options.frames);
    options.inputs = recording.inputs();
    options.recording = recording.options();
    std::string device = std::move(options.stereo.device);
    options.stereo = stereo.options("fuse_flow_depth");
    options.stereo.device = std::move(device);
    options.stereo.threads = options.threads;
    command_line::requireThreads(options.threads);
    return run(options);
  });
}
