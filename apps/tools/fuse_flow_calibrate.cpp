// Refines the poses of a rig from what its depth cameras see.

#include "calibration/board.h"
#include "calibration/pose_frames.h"
#include "calibration/poses.h"
#include "command_line/arguments/method_arguments.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/printable.h"
#include "command_line/tool.h"
#include "drawing/clouds.h"
#include "drawing/display.h"
#include "evaluation/report.h"
#include "input_checks/depth_in_range.h"
#include "input_checks/lens_check.h"
#include "methods/method.h"
#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"
#include "recordings/images/image_io.h"
#include "recordings/range.h"
#include "recordings/still_there.h"

#include <fuse_flow/calibration/coarse_alignment.h>
#include <fuse_flow/calibration/depth_correction_estimation.h>
#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/recordings/input_files.h>
#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/recordings/rig_json.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <tuple>

namespace {

using namespace fuse_flow;

struct Options {
  std::vector<std::string> inputs;
  std::string output;
  std::string json;
  std::string picture;
  std::string frames;
  std::string hold{"first"};
  std::string device{"auto"};
  unsigned int threads{0};
  bool from_scratch{false};
  std::string depth_correction{"none"};
  double least_gain{0.05};
  io::BoardKind board;
  std::string board_size;
  io::RecordingOptions recording;
  ExtrinsicParameters parameters;
  drawing::Viewpoint viewpoint;
};

/** \brief In words: "slides along (1.00, 0.00, 0.00)", "turns about …". */
std::string describe(const Eigen::Matrix<double, 6, 1>& twist) {
  const bool slides = twist.head<3>().norm() >= twist.tail<3>().norm();
  const Eigen::Vector3d axis = (slides ? twist.head<3>() : twist.tail<3>()).normalized();
  char text[96];
  std::snprintf(text, sizeof text, "%s (%.2f, %.2f, %.2f)", slides ? "slides along" : "turns about", axis.x(), axis.y(),
                axis.z());
  return text;
}

constexpr double kDegrees = 57.29577951308232;

/** \brief As it is printed. */
std::string nameOf(const Camera& camera) { return command_line::printable(io::cutShort(camera.name)); }

/** \param begin where a camera stays that depth says nothing about */
void print(const std::vector<Camera>& cameras, const ExtrinsicResult& result, std::size_t frames, const char* begin) {
  std::printf("%-20s %12s %12s %14s %10s\n", "camera", "moved", "turned", "+- (1 sigma)", "overlaps");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CameraCorrection& c = result.corrections[i];
    std::printf("%-20s %9.2f mm %8.3f deg %11.2f mm %10zu", nameOf(cameras[i]).c_str(), 1000 * c.translation,
                kDegrees * c.rotation, 1000 * c.translation_deviation, c.neighbours);
    if (c.neighbours == 0 && cameras.size() > 1) {
      std::printf("   sees nothing that another camera sees: left where %s", begin);
    } else {
      for (const auto& twist : c.free_directions) std::printf("   left open: %s", describe(twist).c_str());
    }
    std::printf("\n");
  }
  std::printf("\n%-32s %10s %12s %12s\n", "overlap", "matches", "before", "after");
  for (const CameraOverlap& o : result.overlaps)
    std::printf("%-32s %10zu %9.2f mm %9.2f mm\n",
                (nameOf(cameras[o.first]) + " - " + nameOf(cameras[o.second])).c_str(), o.correspondences,
                1000 * o.residual_before, 1000 * o.residual);
  std::printf(
      "\nsurfaces disagree by %.2f mm before, %.2f mm after (root mean square); %s after %d iterations, over %zu "
      "frame%s\n",
      1000 * result.residual_before, 1000 * result.residual, result.converged ? "converged" : "not converged",
      result.iterations, frames, frames == 1 ? "" : "s");
}

/** \brief Of a correction, at a depth: how far it moves what is measured there, metres. */
struct CorrectionAt {
  double mean_square{0};
  double most{0};
};
CorrectionAt correctionAt(const DepthCorrection& correction, double z) {
  CorrectionAt result;
  for (std::size_t k = 0; k < correction.relative.size(); ++k) {
    const double by =
        z * (static_cast<double>(correction.relative[k]) + z * static_cast<double>(correction.per_metre[k]));
    result.mean_square += by * by / static_cast<double>(correction.relative.size());
    result.most = std::max(result.most, std::fabs(by));
  }
  return result;
}

/** \brief Those that cameras have are found anew, and poses that are compared with that must not know them. */
void withoutCorrections(std::vector<Camera>& cameras) {
  for (Camera& camera : cameras) camera.depth_correction = {};
}

void print(const std::vector<Eigen::Isometry3d>& initial, const DepthCorrectionResult& result, std::size_t frames) {
  std::printf("\n%-20s %12s %12s %12s %12s %12s\n", "depth correction", "moved", "at 1 m, rms", "at 2 m, rms", "most",
              "knots observable");
  for (std::size_t i = 0; i < initial.size(); ++i) {
    const Camera& camera = result.cameras[i];
    const CorrectionAt near = correctionAt(camera.depth_correction, 1);
    const CorrectionAt far = correctionAt(camera.depth_correction, 2);
    std::printf("%-20s %9.2f mm %9.2f mm %9.2f mm %9.2f mm %10.0f %%\n", nameOf(camera).c_str(),
                1000 * (camera.T_world_camera.translation() - initial[i].translation()).norm(),
                1000 * std::sqrt(near.mean_square), 1000 * std::sqrt(far.mean_square), 1000 * far.most,
                100 * result.observable[i]);
  }
  std::printf(
      "\nwith corrections surfaces disagree by %.2f mm (%.2f mm before); %s after %d iterations, over %zu frame%s\n",
      1000 * result.residual, 1000 * result.residual_before, result.converged ? "converged" : "not converged",
      result.iterations, frames, frames == 1 ? "" : "s");
}

void addTo(nlohmann::json& j, const DepthCorrectionResult& result, bool kept) {
  j["with_corrections"] = {{"residual_before_mm", 1000 * result.residual_before},
                           {"residual_mm", 1000 * result.residual},
                           {"residual_of_poses_mm", 1000 * result.residual_of_poses},
                           {"correspondences", result.correspondences},
                           {"correspondences_of_poses", result.correspondences_of_poses},
                           {"left_out", !kept},
                           {"iterations", result.iterations},
                           {"converged", result.converged}};
  for (std::size_t i = 0; i < result.cameras.size(); ++i) {
    const CorrectionAt at = correctionAt(result.cameras[i].depth_correction, 2);
    j["cameras"][i]["depth_correction_at_2_m_mm"] = 1000 * std::sqrt(at.mean_square);
    j["cameras"][i]["knots_observable"] = result.observable[i];
  }
}

nlohmann::json toJson(const std::vector<Camera>& cameras, const ExtrinsicResult& result) {
  nlohmann::json j;
  j["residual_before_mm"] = 1000 * result.residual_before;
  j["residual_mm"] = 1000 * result.residual;
  j["iterations"] = result.iterations;
  j["converged"] = result.converged;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CameraCorrection& c = result.corrections[i];
    nlohmann::json camera{{"name", cameras[i].name},
                          {"moved_mm", 1000 * c.translation},
                          {"turned_deg", kDegrees * c.rotation},
                          {"deviation_mm", 1000 * c.translation_deviation},
                          {"deviation_deg", kDegrees * c.rotation_deviation},
                          {"overlaps", c.neighbours},
                          {"constrained", c.constrained},
                          {"left_open", nlohmann::json::array()}};
    for (const auto& twist : c.free_directions) camera["left_open"].push_back(describe(twist));
    j["cameras"].push_back(camera);
  }
  j["overlaps"] = nlohmann::json::array();
  for (const CameraOverlap& o : result.overlaps)
    j["overlaps"].push_back({{"first", cameras[o.first].name},
                             {"second", cameras[o.second].name},
                             {"correspondences", o.correspondences},
                             {"before_mm", 1000 * o.residual_before},
                             {"after_mm", 1000 * o.residual}});
  return j;
}

/** \brief Every measurement of a frame, a colour a camera. */
drawing::ColoredPoints byCamera(const RigFrame& frame) {
  static constexpr Rgb8 palette[] = {{228, 90, 80},   {80, 160, 235}, {110, 200, 100}, {240, 190, 70},
                                     {180, 120, 220}, {90, 210, 200}, {240, 140, 190}, {170, 170, 170}};
  drawing::ColoredPoints points;
  io::MethodOptions options;
  options.device = "cpu";
  const std::unique_ptr<io::Method> concatenate = io::makeMethod("concatenate", options);
  io::Method::Cloud cloud;
  for (std::size_t i = 0; i < frame.cameras.size(); ++i) {
    RigFrame one;
    one.cameras = {frame.cameras[i]};
    one.views = {frame.views[i]};
    if (one.views[0].missing()) continue;
    concatenate->fuse(one, cloud);
    for (const PointFused& p : cloud) {
      points.positions.emplace_back(p.x, p.y, p.z);
      points.colors.push_back(palette[i % std::size(palette)]);
    }
  }
  return points;
}

void place(const std::vector<Eigen::Isometry3d>& poses, std::vector<Camera>& cameras) {
  for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i].T_world_camera = poses[i];
}

/** \brief Poses from the views alone, in the world in which the first camera stands where it is said to. Throws io::InputError,
 *  naming the cameras, unless all of them are placed together. */
std::vector<Eigen::Isometry3d> fromScratch(CoarseAlignment& alignment, const std::vector<Camera>& cameras) {
  const CoarseAlignmentResult coarse = alignment.estimate();
  std::string lost;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const char* why = nullptr;
    if (coarse.placements[i] == Placement::Missing) why = "measured nothing";
    if (coarse.placements[i] == Placement::Alone) why = "shares too little with the others";
    if (coarse.placements[i] == Placement::Ambiguous) why = "fits in several places";
    if (coarse.placements[i] == Placement::Placed && coarse.groups[i] != coarse.groups[0])
      why = "is connected with other cameras than the first";
    if (why) lost += (lost.empty() ? "" : ", ") + ("'" + cameras[i].name + "' " + why);
  }
  if (!lost.empty())
    throw io::InputError(
        "--from-scratch cannot place every camera: " + lost +
        "; put furniture, a person or a patterned rug where the views overlap, or give poses in rig.json");
  std::vector<Eigen::Isometry3d> poses;
  for (const Eigen::Isometry3d& T : coarse.T_world_camera)
    poses.push_back(cameras[0].T_world_camera * coarse.T_world_camera[0].inverse() * T);
  return poses;
}

/** \brief None may take the place of an input, nor of another. */
void checkOutputs(const Options& options, const io::Recording& recording) {
  io::InputFiles inputs(recording.inputs());
  std::map<std::filesystem::path, std::string> taken;
  for (const auto& [option, path] :
       {std::pair("-o", options.output), std::pair("--json", options.json), std::pair("--picture", options.picture)}) {
    if (path.empty()) continue;
    inputs.refuseToReplace(option, path);
    std::error_code error;
    const auto [place, is_new] =
        taken.emplace(std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error), option);
    if (!is_new)
      throw io::OptionError(option + (' ' + path) + ": " + place->second + " goes to this file, must be another");
  }
}

/** \brief Estimated depth stands where the poses say, and tells nothing about them. */
io::StereoOptions withoutStereo() {
  io::StereoOptions options;
  options.estimate = false;
  return options;
}

void requireDepth(const std::string& path, const io::Recording& recording) {
  for (std::size_t k = 0; k < recording.cameras().size(); ++k)
    if (recording.hasDepth(k)) return;
  throw io::InputError(
      path +
      ": no camera has depth, from which poses are found here; of colour cameras COLMAP or OpenCV finds "
      "them");
}

int run(Options options) {
  options.parameters.gauge = options.hold == "first" ? Gauge::FirstCamera : Gauge::Mean;
  const std::unique_ptr<io::PoseEstimation> estimation =
      io::makePoseEstimation(options.device, options.parameters, options.threads);
  if (!options.picture.empty()) drawing::requireDisplay("fuse_flow_calibrate");
  std::optional<io::Board> board;
  if (options.board.side > 0) board.emplace(options.board);
  options.recording.read_color = options.parameters.use_color || board;
  options.recording.without_poses = true;  // to find them is what it is for
  const std::unique_ptr<io::Recording> recording =
      command_line::openRecording("fuse_flow_calibrate", options.inputs, options.recording, withoutStereo());
  checkOutputs(options, *recording);
  requireDepth(options.inputs[0], *recording);
  if (recording->cameras().size() < 2)
    throw io::InputError(options.inputs[0] + ": one camera alone tells nothing about its pose, must be two or more" +
                         (options.recording.views.empty() ? "" : ": --views leaves out the others"));
  const std::vector<std::size_t> frames = options.frames.empty() ? io::framesForPoses(*recording, options.parameters)
                                                                 : io::chooseFrames(*recording, options.frames);
  if (frames.empty()) throw io::InputError(options.inputs[0] + ": has no frame");

  CoarseAlignment coarse;
  coarse.setNumberOfThreads(options.threads);
  std::optional<DepthCorrectionEstimation> correction;
  if (options.depth_correction != "none") {
    DepthCorrectionParameters parameters;
    parameters.shared = options.depth_correction == "shared";
    parameters.views.gauge = options.parameters.gauge;
    correction.emplace();
    correction->setParameters(parameters);
    correction->setNumberOfThreads(options.threads);
  }
  const io::StillThere still_there(*recording);
  io::LoadedFrame loaded;
  io::DepthInRange in_range(options.parameters.preprocessing);
  io::LensCheck lenses;
  // Few are enough to place cameras, and each takes seconds. More than that tell corrections no more: they take all only where someone
  // names them.
  std::vector<char> few(frames.size(), 0);
  for (const std::size_t k : io::spreadFrames(io::kFewFrames, frames.size())) few[k] = 1;
  std::size_t corrected_by = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    recording->read(frames[k], loaded);
    still_there.check(loaded);
    in_range.look(loaded.rig);
    lenses.look(loaded.rig);
    if (correction) withoutCorrections(loaded.rig.cameras);
    estimation->addFrame(loaded.rig);
    if (options.from_scratch && few[k]) coarse.addFrame(loaded.rig);
    if (board) board->addFrame(loaded);
    if (correction && (few[k] || !options.frames.empty())) {
      correction->addFrame(loaded.rig);
      ++corrected_by;
    }
  }
  for (const std::vector<std::string>& lines : {in_range.complaints(), lenses.complaints()})
    command_line::printWarnings("fuse_flow_calibrate", lines);
  std::vector<Camera> before = recording->cameras();
  if (correction) withoutCorrections(before);
  std::vector<Eigen::Isometry3d> initial;
  for (const Camera& camera : before) initial.push_back(camera.T_world_camera);
  if (options.from_scratch) initial = fromScratch(coarse, before);
  io::MarkerRig markers;
  if (board) initial = (markers = board->place(before)).T_world_camera;
  const ExtrinsicResult result = estimation->estimate(initial);
  std::vector<Camera> after = before;
  place(result.T_world_camera, after);
  DepthCorrectionResult corrected;
  bool kept = false;
  if (correction) {
    corrected = correction->estimate(initial, result.T_world_camera);
    kept = options.least_gain <= 0 || corrected.explainsMore(options.least_gain);
    if (kept) after = corrected.cameras;
  }

  if (!options.json.empty()) {
    nlohmann::json figures = toJson(before, result);
    figures["frames"] = frames.size();
    if (correction) {
      addTo(figures, corrected, kept);
      figures["with_corrections"]["frames"] = corrected_by;
    }
    io::writeFile(options.json, io::jsonText(figures));
  }
  if (!options.picture.empty()) {
    place(initial, loaded.rig.cameras);
    std::vector<drawing::ColoredPoints> clouds{byCamera(loaded.rig)};
    loaded.rig.cameras = after;
    clouds.push_back(byCamera(loaded.rig));
    io::writeColorPng(options.picture, drawing::drawClouds(clouds, options.viewpoint));
  }
  io::RigDescription rig{{}, recording->framesPerSecond()};
  for (std::size_t i = 0; i < after.size(); ++i)
    rig.cameras.push_back(
        {after[i], recording->confidenceScale(i), recording->hasDepth(i), recording->depthMeaning(i)});
  io::writeRigJson(options.output, rig);
  if (options.from_scratch)
    std::printf(
        "Poses found from scratch. A room that looks alike after half a turn can be taken for its turned self: look at "
        "--picture.\n\n");
  if (board) std::printf("%s\n", board->summary(markers).c_str());
  if (correction)
    std::printf(kept ? "With poses alone, for comparison; %s has those found together with the corrections, below.\n\n"
                     : "With poses alone, which %s has; the corrections, below, are left out.\n\n",
                command_line::printable(options.output).c_str());
  print(before, result, frames.size(),
        board                  ? "--board placed it"
        : options.from_scratch ? "--from-scratch placed it"
                               : "it was");
  if (correction) {
    print(initial, corrected, corrected_by);
    std::printf(
        "with the poses above and no corrections by %.2f mm, in %zu places instead of %zu: corrections are %s\n",
        1000 * corrected.residual_of_poses, corrected.correspondences_of_poses, corrected.correspondences,
        kept ? "kept"
             : "left out, as they explain too little that poses do not (--least-gain 0 keeps them all the same)");
  }
  return command_line::kSuccess;
}

void addBoardOptions(CLI::App& app, io::BoardKind& board, std::string& size) {
  CLI::Option* side = app.add_option(
      "--board", board.side,
      "begin with a board or markers whose squares have this side, m, wherever the colour images show them: the black "
      "square of a marker, or a square of a chessboard or ChArUco board; the first camera stays");
  side->check(command_line::positiveNumber())->excludes("--from-scratch");
  app.add_option(
         "--board-kind", board.kind,
         "what is shown: square markers one by one, AprilTags or ArUco by --board-family; a chessboard; a ChArUco "
         "board; a grid of ArUco markers")
      ->check(command_line::oneOf(io::BoardKind::kinds()))
      ->capture_default_str()
      ->needs(side);
  app.add_option(
         "--board-size", size,
         "COLUMNSxROWS of the board: a chessboard's inner corners, where four squares meet, such as 9x6; a ChArUco "
         "board's squares; a grid's markers")
      ->check(command_line::makeCheck("COLUMNSxROWS, two whole numbers from 1 to 100, such as 9x6",
                                      [](const std::string& text) { return io::parseBoardSize(text).has_value(); }))
      ->needs(side);
  app.add_option(
         "--board-family", board.family,
         "of the markers: AprilTags' (tag…), of which tag36h11 is the default, or a dictionary of ArUco markers "
         "(DICT_…)")
      ->check(command_line::oneOf(io::BoardKind::families()))
      ->needs(side);
  app.add_option("--board-marker", board.marker, "side of the markers in the white squares of a ChArUco board, m")
      ->check(command_line::positiveNumber())
      ->needs(side);
  app.add_option("--board-gap", board.gap, "between the markers of a grid, m")
      ->check(command_line::positiveNumber())
      ->needs(side);
  app.add_flag("--board-legacy", board.legacy,
               "of a ChArUco board of an even number of rows: its upper left square is white, as OpenCV drew it before "
               "4.6; else it is black")
      ->needs(side);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ExtrinsicParameters& p = options.parameters;
  CLI::App app("Refines the poses of a rig from what its depth cameras see.", "fuse_flow_calibrate");
  command_line::RecordingArguments recording(app);
  recording.input()->required();
  app.remove_option(app.get_option("--slide"));  // one rig, calibrated once
  app.add_option("-o,--output", options.output, "rig.json with the new poses, for --poses of the other tools")
      ->check(command_line::path())
      ->required();
  app.add_option("--json", options.json, "write what is printed to this JSON file")->check(command_line::path());
  app.add_option("--picture", options.picture,
                 "PNG of all measurements, a colour a camera, before and after; needs a display")
      ->check(command_line::path());
  app.add_option(
         "--frames", options.frames,
         "A:B:STEP, B not included; default: ten, evenly spread, or forty where a sensor matches blocks, as active "
         "stereo does; --from-scratch begins with ten of them, and --depth-correction takes ten unless they are named "
         "here")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join);
  app.add_flag("--from-scratch", options.from_scratch,
               "ignore the given poses and find all of them from what upright cameras see; the first camera stays");
  app.add_option(
         "--depth-correction", options.depth_correction,
         "find what the depth cameras measure wrong, too: of each on its own, or shared, one for all views, "
         "which one sensor took that was carried around; left out where poses alone explain as much, see --least-gain")
      ->check(command_line::oneOf({"none", "each", "shared"}))
      ->capture_default_str();
  app.add_option(
         "--least-gain", options.least_gain,
         "share of the disagreement of refined poses that depth corrections must take away to be kept; 0: always")
      ->check(command_line::finiteNumber())
      ->check(CLI::Range(0.0, 0.99))
      ->needs("--depth-correction")
      ->capture_default_str();
  addBoardOptions(app, options.board, options.board_size);
  app.add_option("--hold", options.hold, "what stays: the first camera, or the mean of all")
      ->check(CLI::IsMember({"first", "mean"}))
      ->capture_default_str();
  app.add_flag("!--no-color", p.use_color, "depth alone");
  app.add_option("--samples", p.samples, "points of a view that look for counterparts")->capture_default_str();
  app.add_option("--max-correspondence-distance,--max-distance", p.max_correspondence_distance,
                 "farthest counterpart at first, m")
      ->check(command_line::lengthUpTo(10))
      ->capture_default_str();
  app.add_option("--max-iterations", p.max_iterations, "steps at most")
      ->check(command_line::wholeNumber(1, 1 << 20))
      ->capture_default_str();
  app.add_option("--from", options.viewpoint.from, "of the picture: where the viewer stands, m")
      ->expected(3)
      ->check(command_line::finiteNumber());
  app.add_option("--at", options.viewpoint.at, "what the viewer looks at, m")
      ->expected(3)
      ->check(command_line::finiteNumber());
  app.add_option("--up", options.viewpoint.up, "which way is up")
      ->expected(3)
      ->check(command_line::finiteNumber())
      ->capture_default_str();
  app.add_option("--zoom", options.viewpoint.zoom, "narrows the picture")
      ->check(command_line::positiveNumber())
      ->capture_default_str();
  command_line::addDeviceOption(app, options.device, "poses are refined, after --from-scratch or --board on the CPU");
  app.add_option("--threads", options.threads, "0: one per core")
      ->check(command_line::threadCount())
      ->capture_default_str();
  return command_line::runTool(app, argc, argv, [&] {
    options.inputs = recording.inputs();
    options.recording = recording.options();
    if (const auto size = io::parseBoardSize(options.board_size))
      std::tie(options.board.columns, options.board.rows) = *size;
    return run(options);
  });
}
