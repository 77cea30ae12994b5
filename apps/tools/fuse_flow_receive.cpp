// Receives the clouds that a server streams: as a file, as clouds in a folder, or to see how many come, and how late.

#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/arguments/stream_arguments.h"
#include "command_line/tool.h"
#include "recordings/files/file_io.h"
#include "recordings/files/interrupt.h"
#include "sinks/cloud_files.h"
#include "sinks/cloud_mcap_writer.h"
#include "sinks/draco_file.h"

#include <fuse_flow/stream/client.h>
#include <fuse_flow/stream/stream_file.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow;
using Clock = std::chrono::steady_clock;

constexpr const char* kTool = "fuse_flow_receive";

struct Options {
  std::string link;
  std::string output;
  std::optional<std::string> format;
  std::string token_file;
  std::optional<std::uint64_t> frames;
  std::optional<double> seconds;
  std::vector<double> region;
  std::vector<double> viewpoint;
  std::optional<double> step_mm;
  double status{5};
  stream::ClientOptions client;
};

void warn(const std::vector<std::string>& lines) { command_line::printWarnings(kTool, lines); }

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/** \brief What is done with frames. */
class Output {
 public:
  virtual ~Output() = default;
  virtual void take(const stream::ReceivedFrame& frame) = 0;
  /** \brief What was noticed, a line each. */
  virtual std::vector<std::string> finish() { return {}; }
};

/** \brief A stream file: frames as they came. */
class ToStreamFile : public Output {
 public:
  explicit ToStreamFile(std::string path) : path_(std::move(path)) { io::makeFolderOf(path_); }

  void take(const stream::ReceivedFrame& frame) override {
    if (!writer_)
      writer_.emplace(path_, *frame.description);
    else if (frame.description != description_)
      writer_->describe(*frame.description);
    description_ = frame.description;
    writer_->write(frame.message.data(), frame.message.size());
  }

 private:
  std::string path_;
  std::optional<stream::StreamWriter> writer_;
  std::shared_ptr<const stream::Description> description_;
};

void unpack(stream::FrameDecoder& decoder, const stream::ReceivedFrame& frame, stream::StreamedCloud& cloud) {
  try {
    decoder.decode(frame.message.data(), frame.message.size(), cloud);
  } catch (const stream::FormatError& error) {
    throw io::InputError("frame " + std::to_string(frame.times.number) + ": " + error.what());
  }
}

/** \brief Messages of ROS 2 in a file. */
class ToMcap : public Output {
 public:
  ToMcap(const std::string& path, std::uint32_t most_points) : decoder_(0, most_points) {
    io::makeFolderOf(path);
    writer_.emplace(path);
  }

  void take(const stream::ReceivedFrame& frame) override {
    if (frame.description != description_) writer_->describe(*frame.description);
    description_ = frame.description;
    unpack(decoder_, frame, cloud_);
    writer_->write(cloud_);
  }
  std::vector<std::string> finish() override {
    writer_->finish();
    return {};
  }

 private:
  std::optional<io::CloudMcapWriter> writer_;
  std::shared_ptr<const stream::Description> description_;
  stream::FrameDecoder decoder_;
  stream::StreamedCloud cloud_;
};

/** \brief Microseconds. */
std::uint64_t stampOf(const stream::ReceivedFrame& frame) {
  const std::int64_t time = frame.times.captured != 0 ? frame.times.captured : frame.times.encoded;
  return static_cast<std::uint64_t>(std::max<std::int64_t>(time, 0) / 1000);
}

/** \brief A folder with a cloud for each frame, and when they were captured. */
class ToClouds : public Output {
 public:
  ToClouds(const std::string& path, const std::string& format, std::size_t frames, std::uint32_t most_points)
      : files_(path, format, frames, std::filesystem::path(path).extension().empty()), decoder_(0, most_points) {}

  void take(const stream::ReceivedFrame& frame) override {
    unpack(decoder_, frame, streamed_);
    const auto fused = std::make_shared<io::FusedFrame>();
    fused->number = number_++;
    fused->has_normals = !streamed_.normals.empty();
    if (fused->has_normals)
      stream::toPointCloud(streamed_, fused->with_normals);
    else
      stream::toPointCloud(streamed_, fused->cloud);
    fused->input.rig.stamp = stampOf(frame);
    files_.take(fused);
  }
  std::vector<std::string> finish() override { return files_.finish(); }

 private:
  io::CloudFiles files_;
  stream::FrameDecoder decoder_;
  stream::StreamedCloud streamed_;
  std::size_t number_{0};
};

/** \brief Draco's files: one, or one for each frame in a folder. */
class ToDraco : public Output {
 public:
  ToDraco(const Options& options, bool one_file)
      : path_(options.output), one_file_(one_file), decoder_(0, options.client.most_points) {
    if (!io::hasDraco())
      throw io::OptionError("-o: this program was built without Draco; install libdraco-dev, and build it again");
    if (one_file_ && options.frames != std::uint64_t{1})
      throw io::OptionError("-o " + path_ + ": names one file; must be with --frames 1, or a folder with --format drc");
    if (one_file_)
      io::makeFolderOf(path_);
    else
      io::makeFolder(path_);
  }

  void take(const stream::ReceivedFrame& frame) override {
    unpack(decoder_, frame, cloud_);
    if (cloud_.size() == 0) {
      ++empty_;
      return;
    }
    char name[32];
    std::snprintf(name, sizeof(name), "%06zu.drc", number_++);
    const std::string path = one_file_ ? path_ : (std::filesystem::path(path_) / name).string();
    io::writeDraco(path, cloud_);
    if (!one_file_) io::addTime(path, stampOf(frame));
  }
  std::vector<std::string> finish() override {
    if (empty_ == 0) return {};
    return {std::to_string(empty_) + " frames without points are not written: Draco has no such files"};
  }

 private:
  std::string path_;
  bool one_file_;
  stream::FrameDecoder decoder_;
  stream::StreamedCloud cloud_;
  std::size_t number_{0}, empty_{0};
};

std::unique_ptr<Output> outputOf(const Options& options) {
  const std::string extension = std::filesystem::path(options.output).extension();
  if (options.format && (options.output.empty() || !extension.empty()))
    warn({"--format has no effect: it is of the clouds in a folder, -o names none"});
  if (options.output.empty()) return nullptr;
  if (extension == ".ffs") return std::make_unique<ToStreamFile>(options.output);
  if (extension == ".mcap") return std::make_unique<ToMcap>(options.output, options.client.most_points);
  const std::string format = options.format.value_or("ply");
  const bool one_draco = extension == ".drc";
  if (one_draco || (extension.empty() && format == "drc")) return std::make_unique<ToDraco>(options, one_draco);
  const std::size_t frames = options.frames.value_or(std::numeric_limits<std::size_t>::max());
  return std::make_unique<ToClouds>(options.output, format, frames, options.client.most_points);
}

/** \brief Times of which some are asked for in the end. */
class Latencies {
 public:
  void add(std::int64_t from, std::int64_t to) {
    if (from != 0) times_.push_back(1e-6 * static_cast<double>(to - from));
  }
  /** \brief "captured to arrived: 50 % within 41.0 ms, 95 % 46.2 ms, 99 % 50.1 ms, all 61.0 ms"; empty: none is known. */
  std::string summary(const char* name) const {
    if (times_.empty()) return "";
    std::vector<double> sorted = times_;
    std::sort(sorted.begin(), sorted.end());
    const auto at = [&](double part) {
      return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(part * static_cast<double>(sorted.size())))];
    };
    char line[160];
    std::snprintf(line, sizeof line, "  %s: 50 %% within %.1f ms, 95 %% %.1f ms, 99 %% %.1f ms, all %.1f ms\n", name,
                  at(0.5), at(0.95), at(0.99), sorted.back());
    return line;
  }

 private:
  std::vector<double> times_;  ///< ms
};

/** \brief Frames that came, counted. */
struct Counts {
  std::uint64_t frames{0}, bytes{0}, points{0}, points_of_frames{0}, partial{0};

  void add(const stream::ReceivedFrame& frame) {
    std::uint32_t whole = 0, here = 0;  // as the header has them, which is there: the client looks
    std::memcpy(&whole, frame.message.data() + 72, sizeof(whole));
    std::memcpy(&here, frame.message.data() + 76, sizeof(here));
    ++frames;
    bytes += frame.message.size();
    points += here;
    points_of_frames += whole;
    partial += here < whole ? 1 : 0;
  }
  Counts since(const Counts& before) const {
    return {frames - before.frames, bytes - before.bytes, points - before.points,
            points_of_frames - before.points_of_frames, partial - before.partial};
  }
  std::string text(double seconds) const {
    if (frames == 0) return "no frame";
    const auto each = [&](std::uint64_t sum) { return static_cast<double>(sum) / static_cast<double>(frames); };
    char line[200];
    std::snprintf(line, sizeof line, "%.1f frames/s, %.0f of %.0f points, %.2f MB a frame, %.1f Mbit/s",
                  static_cast<double>(frames) / seconds, each(points), each(points_of_frames), 1e-6 * each(bytes),
                  8e-6 * static_cast<double>(bytes) / seconds);
    return line;
  }
};

int receive(Options& options) {
  if (!options.token_file.empty()) options.client.token = command_line::readToken(options.token_file);
  if (options.step_mm) options.client.wishes.step = 1e-3 * *options.step_mm;
  if (!options.viewpoint.empty())
    options.client.wishes.viewpoint = {{options.viewpoint[0], options.viewpoint[1], options.viewpoint[2]}};
  if (const std::vector<double>& box = options.region; !box.empty()) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (box[axis] > box[axis + 3]) throw io::OptionError("--region: must be the least x y z, and then the greatest");
    options.client.wishes.region = {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
  }
  const std::unique_ptr<Output> output = outputOf(options);
  std::optional<stream::Client> client;
  try {
    client.emplace(options.link, options.client);
  } catch (const std::invalid_argument& error) {
    throw io::OptionError(command_line::withOptionNames(
        error.what(), {{"token", "--token-file"}, {"certificate_authority", "--certificate-authority"}}));
  }
  io::catchInterrupts();
  const Clock::time_point start = Clock::now();
  Clock::time_point first = start, last_status = start;
  Counts counts, at_status;
  Latencies captured, encoded;
  stream::ReceivedFrame frame;
  const auto over = [&] {
    return io::interrupt_requested || (options.frames && counts.frames >= *options.frames) ||
           secondsSince(start) >= options.seconds.value_or(1e12) || client->status().ended;
  };
  const auto tell = [&] {
    for (const std::string& line : client->takeNotices()) std::cerr << kTool << ": " << line << std::endl;
  };
  while (!over()) {
    tell();
    if (options.status > 0 && secondsSince(last_status) >= options.status) {
      char seconds[32];
      std::snprintf(seconds, sizeof seconds, "%.0f s: ", secondsSince(start));
      std::cerr << seconds << counts.since(at_status).text(secondsSince(last_status)) << std::endl;
      at_status = counts;
      last_status = Clock::now();
    }
    if (!client->pull(frame, std::chrono::milliseconds(50))) continue;
    if (counts.frames == 0) first = Clock::now();
    counts.add(frame);
    captured.add(frame.times.captured, frame.arrived);
    encoded.add(frame.times.encoded, frame.arrived);
    if (output) output->take(frame);
  }
  const double seconds = std::max(secondsSince(first), 1e-3);
  tell();
  const stream::ClientStatus status = client->status();
  if (counts.frames == 0 && !io::interrupt_requested)
    throw io::InputError(status.error.empty() ? options.link.substr(0, options.link.find('?')) + ": no frame came"
                                              : status.error);
  if (!options.output.empty()) std::cout << options.output << ": ";
  // The first frame begins the time, and is none of those that came in it.
  Counts after = counts;
  if (counts.frames > 1) --after.frames;
  std::cout << counts.frames << " frames in " << static_cast<int>(seconds * 10 + 0.5) / 10.0 << " s, "
            << after.text(seconds) << "\n"
            << captured.summary("captured to arrived") << encoded.summary("encoded to arrived") << std::flush;
  std::vector<std::string> noticed;
  if (output) {
    noticed = output->finish();
    if (counts.partial > 0)
      noticed.push_back(std::to_string(counts.partial) +
                        " frames are not whole: fewer points were asked for, or the connection is too slow for all");
    if (status.dropped > 0)
      noticed.push_back(std::to_string(status.dropped) +
                        " frames came faster than they could be written, and are lost");
  }
  warn(noticed);
  return command_line::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Receives the clouds that fuse_flow_serve streams: writes them to a stream file, which fuse_flow_viewer and "
      "fuse_flow_serve play, to a file for ROS 2 and Foxglove, or as clouds into a folder; without -o it reports how "
      "many come, and how late. Latency is "
      "right as far as the clocks of both machines agree.",
      kTool);
  app.add_option("link", options.link, "of the stream, as fuse_flow_serve prints it")->required();
  app.add_option("-o,--output", options.output,
                 "a .ffs file, a .mcap file for ROS 2 and Foxglove, or a folder for 000000.ply, … and timestamps.txt; "
                 "one .ply, "
                 ".pcd or .drc with --frames 1")
      ->check(command_line::path());
  app.add_option("--format", options.format,
                 "of the clouds in a folder: ply, the default, pcd, or drc for Draco's decoders")
      ->check(command_line::oneOf({"ply", "pcd", "drc"}));
  app.add_option("--token-file", options.token_file, "a file with one line, the token, if the link has none")
      ->check(command_line::path());
  app.add_option("--certificate-authority", options.client.certificate_authority,
                 "a PEM file with the certificate to trust, where the server has made its own; else those that the "
                 "system trusts")
      ->check(command_line::path());
  app.add_option("--frames", options.frames, "end after so many")
      ->check(command_line::wholeNumber(1, std::numeric_limits<int>::max()));
  app.add_option("--seconds", options.seconds, "end after so many")->check(command_line::positiveNumber());
  app.add_option("--points", options.client.wishes.points, "of a frame, at most: an even sample of the surface")
      ->check(command_line::wholeNumber(1, std::numeric_limits<int>::max()));
  app.add_option("--bytes-per-second", options.client.wishes.bytes_per_second, "at most, by fewer points")
      ->check(command_line::wholeNumber(1, std::numeric_limits<int>::max()));
  app.add_option("--region", options.region, "only this part, and what is near: the least x y z and the greatest, m")
      ->expected(6)
      ->check(command_line::numberFromTo(-1e9, 1e9));
  app.add_option("--viewpoint", options.viewpoint, "what is nearer to it is denser: x y z, m")
      ->expected(3)
      ->check(command_line::numberFromTo(-1e9, 1e9));
  app.add_option("--step", options.step_mm, "mm between the positions of points, coarser than the server's")
      ->check(command_line::numberFromTo(0.01, 1000));
  app.add_option("--status", options.status, "seconds between two reports; 0: none")
      ->check(command_line::nonNegativeNumber())
      ->capture_default_str();
  return command_line::runTool(app, argc, argv, [&] { return receive(options); });
}
