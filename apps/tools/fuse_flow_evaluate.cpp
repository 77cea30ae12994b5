// Prints how near clouds of any origin are to the truth, if the recording is simulated, and what can be measured of
// them without it: by themselves, and against the views they came from.

#include "clouds/cloud_io.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/quality_options.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/arguments/stereo_arguments.h"
#include "command_line/threads.h"
#include "command_line/tool.h"
#include "drawing/clouds.h"
#include "drawing/display.h"
#include "evaluation/report.h"
#include "evaluation/truth.h"
#include "evaluation/truth_report.h"
#include "input_checks/input_checks.h"
#include "recordings/files/file_io.h"
#include "recordings/images/image_io.h"
#include "recordings/readers/readers.h"
#include "recordings/still_there.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/recordings/input_files.h>
#include <fuse_flow/recordings/recording.h>

#include <pcl/point_types.h>

#include <filesystem>
#include <limits>
#include <optional>

namespace {

namespace fs = std::filesystem;
using namespace fuse_flow;

struct Options {
  std::vector<std::string> recording;
  std::vector<std::string> clouds;
  std::size_t frame{0};
  std::string json;
  bool truth{false};     ///< must be there
  bool no_truth{false};  ///< is left out
  bool no_parts{false};  ///< figures by part are
  std::string error_picture;
  unsigned int threads{0};
  ReprojectionQualityParameters quality;
  io::RecordingOptions recording_options;
  io::StereoOptions stereo;
};

/** \brief A cloud of one frame of the recording. */
struct CloudFile {
  std::string path;
  std::size_t frame;
  io::EmptyCloud empty;
};

/** \brief A cloud, or the clouds of a folder, as fuse_flow_fuse writes them: NNNNNN.ply or .pcd is of frame NNNNNN, without
 *  points where every camera missed it. */
std::vector<CloudFile> filesOf(const std::string& path, std::size_t frame) {
  if (!fs::is_directory(path)) return {{path, frame, io::EmptyCloud::Refused}};
  std::vector<CloudFile> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    const std::string stem = entry.path().stem().string(), extension = entry.path().extension().string();
    const bool numbered =
        !stem.empty() && stem.size() <= 9 && stem.find_first_not_of("0123456789") == std::string::npos;
    if (numbered && (extension == ".ply" || extension == ".pcd"))
      files.push_back({entry.path().string(), static_cast<std::size_t>(std::stoul(stem)), io::EmptyCloud::Accepted});
  }
  if (files.empty()) throw io::InputError(path + ": no clouds, must hold files like 000000.ply");
  std::sort(files.begin(), files.end(), [](const CloudFile& a, const CloudFile& b) {
    return std::tie(a.frame, a.path) < std::tie(b.frame, b.path);
  });
  return files;
}

/** \brief The clouds of one command-line argument, by themselves, against the views and, where it is known, the truth. */
struct Evaluation {
  SurfaceQuality surface;
  io::QualityOfSequence quality;
  std::vector<simulation::TruthQuality> truth;
  /** \brief Of all frames together; empty where the truth names no parts. */
  std::vector<simulation::PartQuality> parts;
  std::vector<double> flicker;
  nlohmann::json frames = nlohmann::json::array();
  /** \brief Of the first cloud. */
  drawing::ColoredPoints errors;

  double meanFlicker() const {
    double sum = 0;
    for (const double f : flicker) sum += f;
    return flicker.empty() ? simulation::TruthQuality::kUnknown : sum / static_cast<double>(flicker.size());
  }
};

FuseFlowParameters rangeOf(const Options& options) {
  FuseFlowParameters parameters;
  parameters.preprocessing.min_range = options.quality.min_range;
  parameters.preprocessing.max_range = options.quality.max_range;
  return parameters;
}

class Evaluator {
 public:
  explicit Evaluator(const Options& options)
      : options_(options),
        recording_(command_line::openRecording("fuse_flow_evaluate", options.recording, options.recording_options,
                                               options.stereo)),
        checks_("concatenate", rangeOf(options), {}) {  // of images and poses alone: nothing is fused here
    if (options.no_truth) return;
    if (const std::vector<std::string> missing = simulation::Truth::missingIn(options.recording[0]);
        !missing.empty() && !options.truth)
      why_no_truth_ = "The truth is left out: it has no file " + missing[0] + ".\n";
    if (!options.truth && !simulation::Truth::isIn(options.recording[0])) return;
    truth_.emplace(options.recording[0]);
    if (truth_->cameras().size() == recording_->cameras().size()) return;
    if (options.truth) throw io::OptionError("--truth: needs all cameras of the recording, --views leaves some out");
    why_no_truth_ = "The truth is left out: it needs all cameras of the recording, and --views leaves some out.\n";
    truth_.reset();
  }

  bool knowsTruth() const { return truth_.has_value(); }
  bool knowsParts() const { return truth_ && truth_->namesParts() && !options_.no_parts; }
  /** \brief A line, or nothing. */
  const std::string& whyNoTruth() const { return why_no_truth_; }
  /** \brief What is wrong with the images or the poses, one line each: what is measured against them is then of little worth. */
  std::vector<std::string> complaints() const { return checks_.complaints(); }
  const io::Recording& recording() const { return *recording_; }

  /** \brief Frame by frame, all clouds of one before the next: views and surface of a frame are looked at once. \param files of each
   *  command-line argument, by frame  \return as many */
  std::vector<Evaluation> evaluate(const std::vector<std::vector<CloudFile>>& files) {
    std::vector<Sequence> sequences(files.size());
    std::vector<std::size_t> next(files.size(), 0);
    while (true) {
      std::optional<std::size_t> frame;
      for (std::size_t k = 0; k < files.size(); ++k)
        if (next[k] < files[k].size())
          frame = std::min(frame.value_or(files[k][next[k]].frame), files[k][next[k]].frame);
      if (!frame) break;
      for (std::size_t k = 0; k < files.size(); ++k)
        for (; next[k] < files[k].size() && files[k][next[k]].frame == *frame; ++next[k])
          add(files[k][next[k]], sequences[k]);
    }
    std::vector<Evaluation> results;
    for (Sequence& sequence : sequences) results.push_back(std::move(sequence.result));
    return results;
  }

 private:
  /** \brief One command-line argument, so far. */
  struct Sequence {
    Evaluation result;
    std::optional<simulation::PlainCloud> previous;
    pcl::PointCloud<pcl::PointXYZ> cloud_before;
    std::optional<std::size_t> frame_before;
  };

  void add(const CloudFile& file, Sequence& sequence) {
    Evaluation& result = sequence.result;
    pcl::PCLPointCloud2 blob;
    io::readCloud(file.path, blob, file.empty);
    readFrame(file);
    pcl::PointCloud<pcl::PointXYZ> cloud;
    {
      const io::SilencePcl silence;
      pcl::fromPCLPointCloud2(blob, cloud);
    }
    const ReprojectionQuality quality = reprojectionQuality(cloud, loaded_.rig, options_.quality, options_.threads);
    result.quality.add(quality);
    const SurfaceQualityParameters parameters = command_line::surfaceParameters(options_.quality);
    SurfaceQuality surface = surfaceQuality(cloud, loaded_.rig, parameters, options_.threads);
    const std::optional<std::size_t> before = sequence.frame_before;
    if (before && *before + 1 == file.frame && before_frame_ == before)
      surface.flicker =
          temporalFlicker(sequence.cloud_before, before_.rig, cloud, loaded_.rig, parameters, options_.threads);
    result.surface += surface;
    sequence.frame_before = file.frame;
    sequence.cloud_before = std::move(cloud);
    nlohmann::json json = io::qualityJson(quality);
    json.update(io::surfaceJson(surface));
    json["frame"] = file.frame;
    if (truth_) {
      simulation::PlainCloud plain = simulation::plainCloud(blob);
      json["truth"] = compare(plain, file.frame, result);
      const std::optional<simulation::PlainCloud>& previous = sequence.previous;
      if (previous && !previous->positions.empty() && !plain.positions.empty())
        result.flicker.push_back(flicker(*previous, plain, truth_->frame(file.frame), threads()));
      sequence.previous = std::move(plain);
    }
    result.frames.push_back(std::move(json));
  }

  int threads() const { return host::resolveThreads(static_cast<int>(options_.threads)); }

  void readFrame(const CloudFile& file) {
    if (file.frame >= recording_->frameCount()) {
      const std::string frames = std::to_string(recording_->frameCount()) + " frames, counted from 0";
      const std::string given = " is of frame " + std::to_string(file.frame) + ": the recording has ";
      throw io::OptionError((file.frame == options_.frame ? "--frame: " : "") + file.path + given + frames);
    }
    if (file.frame == read_frame_) return;
    std::swap(loaded_, before_);
    before_frame_ = read_frame_;
    recording_->read(file.frame, loaded_);
    still_there_.check(loaded_);
    checks_.look(loaded_);
    read_frame_ = file.frame;
    visible_.clear();
    parts_.reset();
  }

  nlohmann::json compare(const simulation::PlainCloud& cloud, std::size_t frame, Evaluation& result) {
    const simulation::RayScene& scene = truth_->frame(frame);
    if (visible_.empty()) {
      std::vector<bool> present;
      for (const DepthView& view : loaded_.rig.views) present.push_back(!view.missing() || view.color);
      simulation::Visibility visibility;
      visibility.min_range = truth_->minRange();
      visibility.max_range = truth_->maxRange();
      visible_ = simulation::visibleSurface(scene, truth_->cameras(), present, visibility, threads());
      if (knowsParts()) {
        true_cameras_.emplace(truth_->cameras(), present, visibility);
        parts_.emplace(scene, *true_cameras_, visible_, threads());
      }
    }
    simulation::TruthMatches matches;
    const simulation::TruthQuality quality = compareWithTruth(cloud, scene, visible_, threads(), &matches);
    result.truth.push_back(quality);
    if (parts_) addParts(result.parts, parts_->compare(matches));
    if (result.errors.positions.empty()) {
      result.errors.positions = cloud.positions;
      for (const simulation::NearestHit& hit : matches.surface)
        result.errors.colors.push_back(drawing::errorColor(hit.t, 0.02f));
    }
    return simulation::truthJson(quality);
  }

  const Options& options_;
  std::unique_ptr<io::Recording> recording_;
  const io::StillThere still_there_{*recording_};
  std::optional<simulation::Truth> truth_;
  io::InputChecks checks_;
  std::string why_no_truth_;
  io::LoadedFrame loaded_, before_;
  std::size_t read_frame_{std::numeric_limits<std::size_t>::max()};
  std::optional<std::size_t> before_frame_;  ///< the one that was read before it
  /** \brief Of the frame that was read last. */
  std::vector<simulation::SurfacePoint> visible_;
  std::optional<simulation::TrueCameras> true_cameras_;
  std::optional<simulation::PartComparison> parts_;
};

nlohmann::json jsonOf(const Evaluation& e, bool sequence) {
  nlohmann::json json = io::qualityJson(e.quality.result());
  json.update(io::surfaceJson(e.surface));
  if (!e.truth.empty()) {
    json["truth"] = simulation::truthJson(simulation::meanOf(e.truth));
    if (!e.flicker.empty()) json["truth"]["flicker_mm"] = e.meanFlicker();
    if (!e.parts.empty()) json["truth"]["by_part"] = simulation::partsJson(e.parts);
  }
  if (sequence) json["frames"] = e.frames;
  return json;
}

/** \brief Without --recording the first input is the recording. */
void takeInputs(std::vector<std::string> inputs, Options& options) {
  if (options.recording.empty()) {
    if (inputs.empty()) throw io::OptionError("recording is required; see --help");
    options.recording.push_back(inputs[0]);
    inputs.erase(inputs.begin());
    // The next file may be another camera of this recording, or a cloud: nothing in it tells.
    if (io::isPcdFile(options.recording[0]))
      throw io::OptionError(options.recording[0] + ": is one camera of a recording, name all after the clouds, as in " +
                            "CLOUD --recording A.pcd B.pcd");
  }
  if (inputs.empty()) throw io::OptionError("cloud is required; see --help");
  options.clouds = std::move(inputs);
}

int run(const Options& options) {
  if (!(options.quality.min_range < options.quality.max_range))
    throw io::OptionError("--min-range must be below --max-range");
  if (!options.error_picture.empty()) {
    if (options.no_truth || !(options.truth || simulation::Truth::isIn(options.recording[0])))
      throw io::OptionError("--error-picture needs the truth, which a recording of fuse_flow_simulate has");
    drawing::requireDisplay("fuse_flow_evaluate");
  }
  Evaluator evaluator(options);
  io::InputFiles inputs(evaluator.recording().inputs());
  std::vector<std::vector<CloudFile>> files;
  for (const std::string& path : options.clouds) {
    files.push_back(filesOf(path, options.frame));
    for (const CloudFile& file : files.back()) inputs.add(file.path);
  }
  if (!options.json.empty()) inputs.refuseToReplace("--json", options.json);
  if (!options.error_picture.empty()) inputs.refuseToReplace("--error-picture", options.error_picture);
  std::error_code error;
  if (!options.json.empty() && fs::weakly_canonical(fs::absolute(options.json, error), error) ==
                                   fs::weakly_canonical(fs::absolute(options.error_picture, error), error))
    throw io::OptionError("--json " + options.json + ": the picture goes to this file, must be another");
  std::size_t width = 5;
  for (const std::string& path : options.clouds) width = std::max(width, path.size());
  nlohmann::json json;
  std::vector<drawing::ColoredPoints> pictures;
  std::vector<std::vector<simulation::PartQuality>> parts;
  std::string truth_table, surface_table, quality_table;
  std::vector<Evaluation> evaluations = evaluator.evaluate(files);
  for (std::size_t k = 0; k < files.size(); ++k) {
    Evaluation& e = evaluations[k];
    const std::string& path = options.clouds[k];
    if (evaluator.knowsTruth())
      truth_table += simulation::truthRow(path, width, simulation::meanOf(e.truth), e.meanFlicker()) + '\n';
    parts.push_back(e.parts);
    surface_table += io::surfaceRow(path, width, e.surface) + '\n';
    quality_table += io::qualityRow(path, width, e.quality.result()) + '\n';
    json[path] = jsonOf(e, fs::is_directory(path));
    if (!options.error_picture.empty()) pictures.push_back(std::move(e.errors));
  }
  command_line::printWarnings("fuse_flow_evaluate", evaluator.complaints());
  std::cout << evaluator.whyNoTruth();
  if (evaluator.knowsTruth())
    std::cout << "Against the true surface\n" << simulation::truthHeader(width) << '\n' << truth_table << '\n';
  if (evaluator.knowsParts())
    std::cout << "By part of the true surface, all frames together; speed, incidence and cameras: of what moves, where "
                 "something does\n"
              << simulation::partsTable(options.clouds, width, parts) << '\n';
  else if (evaluator.knowsTruth() && !options.no_parts)
    std::cout << "No figures by part: this truth names no parts, simulate the recording again for them.\n\n";
  std::cout
      << "By the cloud and the views alone\n"
      << io::surfaceHeader(width) << '\n'
      << surface_table << "\nAgainst what the cameras measured, noise and all\n"
      << io::qualityHeader(width) << '\n'
      << quality_table
      << (evaluator.knowsTruth()
              ? "Believe the figures against the true surface; points left as they were measured have the least E_MC.\n"
              : "No truth is known here. On simulated rigs clouds nearer to it mostly had fewer violations off "
                "silhouettes and less flicker, less surely fewer double surfaces; a smooth surface in a wrong place "
                "shows in none of them. Coverage and E_MC are best for points left as they were measured.\n")
      << std::flush;
  if (!options.json.empty()) io::writeFile(options.json, io::jsonText(json));
  if (!options.error_picture.empty()) {
    drawing::Viewpoint viewpoint;
    viewpoint.width = 800 * static_cast<int>(pictures.size());
    io::writeColorPng(options.error_picture, drawing::drawClouds(pictures, viewpoint));
  }
  return command_line::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Measures how well clouds agree with the depth views of a recording, and with the truth of a simulated one.",
      "fuse_flow_evaluate");
  std::vector<std::string> inputs;
  app.add_option("input", inputs,
                 "a recording, then PLY or PCD files in the world frame, or folders of them, one a frame: 000000.ply");
  app.add_option("--recording", options.recording,
                 "the recording, and all before this are clouds; organised PCD files, one a camera, are named so");
  app.add_option("--frame", options.frame, "frame of the recording to compare single clouds with")
      ->check(command_line::wholeNumber(0, std::numeric_limits<int>::max()))
      ->capture_default_str();
  CLI::Option* truth = app.add_flag(
      "--truth", options.truth,
      "the exact surface must be there; where it is, as in recordings of fuse_flow_simulate, it is compared "
      "with unasked");
  app.add_flag("--no-truth", options.no_truth, "do not compare with the exact surface")->excludes(truth);
  app.add_flag("--no-parts", options.no_parts, "no figures by part of the exact surface: head, hand, floor …");
  app.add_option(
         "--error-picture", options.error_picture,
         "where the truth is known: PNG of the first clouds, blue on the true surface to red 20 mm or more from it")
      ->check(command_line::path());
  app.add_option("--views", options.recording_options.views,
                 "frames that act as the cameras of one instant; of a rig recording, the cameras to use");
  app.add_option("--slide", options.recording_options.slide, "move those views on by this many frames a frame")
      ->check(command_line::wholeNumber(0, std::numeric_limits<int>::max()));
  app.add_option("--poses", options.recording_options.poses, "rig.json whose poses replace the recording's")
      ->check(command_line::path());
  command_line::addCalibrationOptions(app, options.recording_options);
  app.add_option("--depth-scale", options.recording_options.depth_scale, "metres per unit of depth")
      ->check(command_line::positiveNumber());
  command_line::addQualityOptions(app, options.quality);
  app.add_option("--min-range", options.quality.min_range, "m")
      ->check(command_line::nonNegativeNumber())
      ->capture_default_str();
  app.add_option("--max-range", options.quality.max_range, "m")
      ->check(command_line::positiveNumber())
      ->capture_default_str();
  app.add_option("--json", options.json, "write the figures to this file too")->check(command_line::path());
  app.add_option("--threads", options.threads, "0: one per core")
      ->check(command_line::threadCount())
      ->capture_default_str();
  command_line::StereoArguments stereo(app);
  return command_line::runTool(app, argc, argv, [&] {
    takeInputs(inputs, options);
    options.stereo = stereo.options("fuse_flow_evaluate");
    options.stereo.threads = options.threads;
    command_line::requireThreads(options.threads);
    return run(options);
  });
}
