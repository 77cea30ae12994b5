// How fast a recording is read, its frames are fused, and both side by side, as fuse_flow_fuse does without writing:
// fuse_flow_reading_bench RECORDING… [--poses RIG.json] [--frames 100] [--ahead 4] [--threads N]. Fuses on the GPU if there is one.

#include "methods/method.h"
#include "recordings/read_ahead.h"

#include <fuse_flow/recordings/recording.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow;

/** \brief Times a second that action runs. */
template <typename Action>
double rate(std::size_t times, const Action& action) {
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t k = 0; k < times; ++k) action(k);
  return static_cast<double>(times) / std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

int run(int argc, char** argv) {
  CLI::App app("Times reading a recording, fusing its frames, and both side by side.", "fuse_flow_reading_bench");
  std::vector<std::string> inputs;
  io::RecordingOptions options;
  int count = 100, ahead_of = 4;
  app.add_option("RECORDING", inputs, "a recording, or a file of each camera")->required();
  app.add_option("--poses", options.poses, "where the cameras stand");
  app.add_option("--frames", count, "how many, again and again from the first")->check(CLI::PositiveNumber);
  app.add_option("--ahead", ahead_of, "frames that are read ahead")->check(CLI::PositiveNumber);
  app.add_option("--threads", options.threads, "that read")->check(CLI::NonNegativeNumber);
  CLI11_PARSE(app, argc, argv);
  const std::unique_ptr<io::Recording> recording = io::openRecording(inputs, options);
  const std::vector<std::size_t> all = recording->frames();
  std::vector<std::size_t> frames;
  for (int k = 0; k < count; ++k) frames.push_back(all[static_cast<std::size_t>(k) % all.size()]);
  const auto ahead = static_cast<std::size_t>(ahead_of);

  const std::unique_ptr<io::Method> method = io::makeMethod("fuse_flow", {});
  io::Method::Cloud cloud;
  io::LoadedFrame frame;
  for (int k = 0; k < 3; ++k) {  // memory grows
    recording->read(frames[0], frame);
    method->fuse(frame.rig, cloud);
  }
  const double reading = rate(frames.size(), [&](std::size_t k) { recording->read(frames[k], frame); });
  const double fusing = rate(frames.size(), [&](std::size_t) { method->fuse(frame.rig, cloud); });
  double reading_ahead = 0, both = 0;
  {
    io::ReadAhead reader(*recording, frames, ahead);
    reading_ahead = rate(frames.size(), [&](std::size_t) { reader.next(frame); });
  }
  {
    io::ReadAhead reader(*recording, frames, ahead);
    both = rate(frames.size(), [&](std::size_t) {
      reader.next(frame);
      method->fuse(frame.rig, cloud);
    });
  }
  std::printf("%zu cameras, %zu frames, %zu read ahead; frames a second:\n", recording->cameras().size(), frames.size(),
              ahead);
  std::printf(
      "reading one after the other %.1f, reading ahead %.1f, fusing %.1f, side by side %.1f: %.2f of the slower\n",
      reading, reading_ahead, fusing, both, both / std::min(reading_ahead, fusing));
  return 0;
}

}  // namespace

int main(int argc, char** argv) try { return run(argc, argv); } catch (const std::exception& error) {
  std::fprintf(stderr, "fuse_flow_reading_bench: %s\n", error.what());
  return 1;
}
