#include "io/demo_scene.h"
#include "io/error.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <string>

namespace {

constexpr const char* usage =
    "Usage: fuse_flow_make_demo OUT [options]\n"
    "Writes a rig recording of four simulated depth cameras around a room corner, in which a ball rolls.\n"
    "  --frames N            frames, default 6\n"
    "  --seed N              the same seed gives the same recording, default 1\n"
    "  --size WxH            image size in pixels, default 640x480\n"
    "  --pose-noise-mm S     standard deviation of the calibrated positions' error, default 2\n"
    "  --pose-noise-deg S    and of the orientations', default 0.1\n"
    "  --no-sensor-noise     exact depth: no noise, holes or mixed pixels\n";

using fuse_flow::io::InputError;

double parseNumber(const std::string& option, const char* text) {
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  if (end == text || *end != '\0') throw InputError(option + " is '" + text + "', must be a number");
  return value;
}

int parseInteger(const std::string& option, const char* text) {
  const double value = parseNumber(option, text);
  if (!(value >= 0 && value <= 1e9) || value != static_cast<int>(value))
    throw InputError(option + " is '" + text + "', must be a whole number from 0 up");
  return static_cast<int>(value);
}

void parseSize(const char* text, fuse_flow::io::DemoOptions& options) {
  char rest = 0;
  if (std::sscanf(text, "%dx%d%c", &options.width, &options.height, &rest) != 2)
    throw InputError(std::string("--size is '") + text + "', must be like 640x480");
}

/** \brief Returns the output folder. */
std::string parseArguments(int argc, char** argv, fuse_flow::io::DemoOptions& options) {
  std::string folder;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--no-sensor-noise") {
      options.sensor_noise = false;
    } else if (argument.rfind("--", 0) == 0) {
      if (i + 1 == argc) throw InputError(argument + " needs a value, or is not known; see --help");
      const char* value = argv[++i];
      if (argument == "--frames")
        options.frames = parseInteger(argument, value);
      else if (argument == "--seed")
        options.seed = static_cast<std::uint32_t>(parseInteger(argument, value));
      else if (argument == "--size")
        parseSize(value, options);
      else if (argument == "--pose-noise-mm")
        options.pose_noise = 0.001 * parseNumber(argument, value);
      else if (argument == "--pose-noise-deg")
        options.pose_noise_deg = parseNumber(argument, value);
      else
        throw InputError(argument + " is not an option; see --help");
    } else if (folder.empty()) {
      folder = argument;
    } else {
      throw InputError(argument + ": only one output folder can be given");
    }
  }
  if (folder.empty()) throw InputError("no output folder was given; see --help");
  return folder;
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (!std::strcmp(argv[i], "--help") || !std::strcmp(argv[i], "-h")) return std::cout << usage, 0;
  try {
    fuse_flow::io::DemoOptions options;
    const std::string folder = parseArguments(argc, argv, options);
    fuse_flow::io::writeDemoRecording(folder, fuse_flow::io::makeDemoRecording(options));
    std::cout << folder << ": 4 cameras, " << options.frames << " frames\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "fuse_flow_make_demo: " << error.what() << '\n';
    return 1;
  }
}
