// The tables of doc/notes/calibration_measured.md and the pages that it names: how near the truth extrinsic estimation comes, beside PCL's registration, and what it costs
// beside the fusion. fuse_flow_calibration_bench [accuracy | accuracy-tuning | frames | multipath | floor | registration | peers | scratch | scratch-peers |
// scratch-tuning | scratch-near-tuning | board | distortion | real | beside | bump]…; without a name all but those that are of scenes that
// served tuning. Of accuracy, frames, multipath, and of the tables that begin from scratch, SCENE/RIG/SENSOR selects one row; with /N
// behind it, the row of N trials.

#include "median.h"
#include "pose_floor.h"
#include "registration_peers.h"
#include "rig_error.h"

#include "calibration/board.h"
#include "calibration/pose_frames.h"
#include "methods/instances.h"
#include "simulation/simulator.h"

#include <fuse_flow/calibration/coarse_alignment.h>
#include <fuse_flow/calibration/depth_correction_estimation.h>
#include <fuse_flow/calibration/extrinsic_tracking.h>
#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/point_types.h>
#include <fuse_flow/quality/reprojection_quality.h>
#include <fuse_flow/recordings/error.h>
#include <fuse_flow/recordings/recording.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <random>
#include <string>

namespace {

using namespace fuse_flow;
using Clock = std::chrono::steady_clock;
using Poses = std::vector<Eigen::Isometry3d>;
using Estimation = ExtrinsicEstimation<PointFused>;
using Tracking = ExtrinsicTracking<PointFused>;

double since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

simulation::SimulationOptions rigOf(const std::string& scene, const std::string& rig, const std::string& sensor,
                                    double fps) {
  simulation::SimulationOptions options;
  options.scene = scene;
  options.rig = rig;
  options.sensor = sensor;
  options.frames_per_second = fps;
  options.threads = host::resolveThreads(0);
  return options;
}

Poses truePoses(const simulation::Simulator& simulator) {
  Poses poses;
  for (const Camera& camera : simulator.trueCameras()) poses.push_back(camera.T_world_camera);
  return poses;
}

/** \brief Every camera 20 mm off in a random direction, and turned by a degree about a random axis. */
Poses disturbed(Poses poses, unsigned int trial) {
  std::mt19937 random(trial + 1);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized(); };
  for (Eigen::Isometry3d& T : poses) {
    T.pretranslate(0.02 * direction());
    T.rotate(Eigen::AngleAxisd(0.017453292519943295, direction()));
  }
  return poses;
}

/** \brief Errors of all cameras of all trials. */
struct Errors {
  std::vector<double> mm, degrees;
  double worst_change{-1e9};  ///< of a trial's mean error, mm

  void add(const Poses& before, const Poses& after, const Poses& truth) {
    double change = 0;
    const auto was = bench::rigError(before, truth), is = bench::rigError(after, truth);
    for (std::size_t i = 0; i < is.size(); ++i) {
      mm.push_back(is[i].mm);
      degrees.push_back(is[i].degrees);
      change += (is[i].mm - was[i].mm) / static_cast<double>(is.size());
    }
    worst_change = std::max(worst_change, change);
  }
  double largest() const { return *std::max_element(mm.begin(), mm.end()); }
};

const std::vector<std::string> kSensors{"ideal", "structured_light", "time_of_flight", "time_of_flight_multipath",
                                        "active_stereo"};

/** \brief The rows that are wanted, as SCENE/RIG/SENSOR or SCENE/RIG/SENSOR/TRIALS; empty: all. */
std::vector<std::string> wanted_rows;

/** \brief How many trials of a row are wanted, where usual are so many; 0: it is not wanted. */
int wantedTrials(const std::string& row, int usual) {
  if (wanted_rows.empty()) return usual;
  for (const std::string& wanted : wanted_rows) {
    if (wanted == row) return usual;
    if (wanted.compare(0, row.size() + 1, row + '/') == 0) return std::atoi(wanted.c_str() + row.size() + 1);
  }
  return 0;
}

void accuracyTable(const std::vector<std::string>& scenes, const std::vector<std::string>& rigs,
                   const std::vector<std::string>& sensors) {
  std::printf(
      "| scene | rig | sensor | 1 frame: median mm, deg | largest mm | worst change mm | iterations | 5 frames: median "
      "mm, deg | largest mm | worst change mm | iterations |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string& scene : scenes)
    for (const std::string& rig : rigs)
      for (const std::string& sensor : sensors) {
        const int trials = wantedTrials(scene + '/' + rig + '/' + sensor, 3);
        if (trials < 1) continue;
        simulation::Simulator simulator(rigOf(scene, rig, sensor, 3));
        const Poses truth = truePoses(simulator);
        std::printf("| %s | %s | %s", scene.c_str(), rig.c_str(), sensor.c_str());
        Estimation estimation;
        std::size_t frame = 0;
        for (const std::size_t frames : {std::size_t{1}, std::size_t{5}}) {
          io::LoadedFrame loaded;
          for (; frame < frames; ++frame) {
            simulator.measure(frame, loaded);
            estimation.addFrame(loaded.rig);
          }
          Errors errors;
          std::vector<double> iterations;
          for (int trial = 0; trial < trials; ++trial) {
            const Poses start = disturbed(truth, static_cast<unsigned int>(trial));
            const ExtrinsicResult result = estimation.estimate(start);
            errors.add(start, result.T_world_camera, truth);
            iterations.push_back(result.iterations);
          }
          std::printf(" | %.2f, %.3f | %.1f | %.1f | %.0f", bench::median(errors.mm), bench::median(errors.degrees),
                      errors.largest(), errors.worst_change, bench::median(iterations));
        }
        std::printf(" |\n");
        std::fflush(stdout);
      }
}

void accuracy() { accuracyTable({"thin", "person"}, {"ring-4", "ring-8", "walls-16"}, kSensors); }

void accuracyTuning() {
  accuracyTable({"room", "table"}, {"ring-4", "ring-8", "walls-8"}, {kSensors[1], kSensors[2], kSensors[4]});
}

/** \brief Of three trials that begin beside the truth. */
Errors errorsOfTrials(Estimation& estimation, const Poses& truth) {
  Errors errors;
  for (unsigned int trial = 0; trial < 3; ++trial) {
    const Poses start = disturbed(truth, trial);
    errors.add(start, estimation.estimate(start).T_world_camera, truth);
  }
  return errors;
}

void printMedians(const Errors& errors) {
  std::printf(" | %.2f, %.3f", bench::median(errors.mm), bench::median(errors.degrees));
  std::fflush(stdout);
}

/** \brief What more frames do against noise that neighbouring pixels share. */
void frames() {
  constexpr std::size_t counts[] = {1, 5, 10, 20, 40};
  std::printf(
      "| scene | rig | sensor | 1 frame: median mm, deg | 5 | 10 | 20 | 40 |\n|---|---|---|---|---|---|---|---|\n");
  for (const char* scene : {"thin", "person"})
    for (const char* rig : {"ring-4", "ring-8", "walls-16"}) {
      const std::string& sensor = kSensors[4];
      if (wantedTrials(std::string(scene) + '/' + rig + '/' + sensor, 1) < 1) continue;
      simulation::Simulator simulator(rigOf(scene, rig, sensor, 3));
      const Poses truth = truePoses(simulator);
      std::printf("| %s | %s | %s", scene, rig, sensor.c_str());
      Estimation estimation;
      io::LoadedFrame loaded;
      std::size_t frame = 0;
      for (const std::size_t count : counts) {
        for (; frame < count; ++frame) {
          simulator.measure(frame, loaded);
          estimation.addFrame(loaded.rig);
        }
        printMedians(errorsOfTrials(estimation, truth));
      }
      std::printf(" |\n");
    }
}

/** \brief What it is worth to take away what multipath interference adds, and to count with what is left of it. */
void multipath() {
  std::printf(
      "| scene | rig | as measured: median mm, deg | corrected | and far depth less certain "
      "|\n|---|---|---|---|---|\n");
  for (const char* scene : {"thin", "person"})
    for (const char* rig : {"ring-4", "ring-8", "walls-16"}) {
      const std::string& sensor = kSensors[3];
      if (wantedTrials(std::string(scene) + '/' + rig + '/' + sensor, 1) < 1) continue;
      simulation::Simulator simulator(rigOf(scene, rig, sensor, 3));
      const Poses truth = truePoses(simulator);
      std::printf("| %s | %s", scene, rig);
      io::LoadedFrame loaded;
      simulator.measure(0, loaded);
      enum Done { kNothing, kCorrected, kWeighed };
      for (const Done done : {kNothing, kCorrected, kWeighed}) {
        RigFrame frame = loaded.rig;
        if (done == kNothing)
          for (Camera& camera : frame.cameras) camera.multipath = {};
        ExtrinsicParameters p;
        if (done == kCorrected) p.residual_multipath = 0;
        Estimation estimation;
        estimation.setParameters(p);
        estimation.addFrame(frame);
        printMedians(errorsOfTrials(estimation, truth));
      }
      std::printf(" |\n");
    }
}

/** \brief What is left by depth alone where everything but its errors is known; one draw of the noise. */
void floorTable() {
  std::printf("| scene | rig | sensor | 1 frame: median mm, deg | 5 frames: median mm, deg |\n|---|---|---|---|---|\n");
  for (const char* scene : {"thin", "person"})
    for (const char* rig : {"ring-4", "ring-8", "walls-16"})
      for (const std::string& sensor : kSensors) {
        simulation::Simulator simulator(rigOf(scene, rig, sensor, 3));
        const Poses truth = truePoses(simulator);
        std::printf("| %s | %s | %s", scene, rig, sensor.c_str());
        for (const std::size_t frames : {std::size_t{1}, std::size_t{5}}) {
          Errors errors;
          errors.add(truth, bench::posesOfExactCorrespondences(simulator, frames, 2), truth);
          std::printf(" | %.2f, %.3f", bench::median(errors.mm), bench::median(errors.degrees));
        }
        std::printf(" |\n");
        std::fflush(stdout);
      }
}

/** \brief Every camera's colour so many pixels beside its depth, each in a direction of its own. */
void misregister(io::LoadedFrame& frame, int pixels) {
  constexpr int directions[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    io::ColorImage& color = frame.images[i].color;
    const io::ColorImage registered = color;
    const auto& [du, dv] = directions[i % 4];
    for (int v = 0; v < color.height; ++v)
      for (int u = 0; u < color.width; ++u)
        color.at(u, v) = registered.at(std::clamp(u + pixels * du, 0, color.width - 1),
                                       std::clamp(v + pixels * dv, 0, color.height - 1));
  }
}

/** \brief What colour does that does not lie on the depth it belongs to. */
void registration() {
  std::printf(
      "| scene | rig | sensor | without colour: median mm, largest | registered | one pixel beside | two pixels "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const char* scene : {"room", "table", "thin"})
    for (const char* rig : {"ring-4", "ring-8"})
      for (const std::string& sensor : {kSensors[1], kSensors[2]}) {
        simulation::Simulator simulator(rigOf(scene, rig, sensor, 3));
        const Poses truth = truePoses(simulator);
        std::printf("| %s | %s | %s", scene, rig, sensor.c_str());
        for (const int pixels : {-1, 0, 1, 2}) {
          io::LoadedFrame loaded;
          simulator.measure(0, loaded);
          Estimation estimation;
          ExtrinsicParameters parameters;
          parameters.use_color = pixels >= 0;
          estimation.setParameters(parameters);
          if (pixels > 0) misregister(loaded, pixels);
          estimation.addFrame(loaded.rig);
          const Errors errors = errorsOfTrials(estimation, truth);
          std::printf(" | %.2f, %.1f", bench::median(errors.mm), errors.largest());
        }
        std::printf(" |\n");
        std::fflush(stdout);
      }
}

std::vector<std::pair<std::size_t, std::size_t>> byOverlap(const ExtrinsicResult& result) {
  std::vector<CameraOverlap> overlaps = result.overlaps;
  std::sort(overlaps.begin(), overlaps.end(),
            [](const auto& a, const auto& b) { return a.correspondences > b.correspondences; });
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const CameraOverlap& o : overlaps) pairs.emplace_back(o.first, o.second);
  return pairs;
}

void peers() {
  std::printf(
      "| scene | rig | sensor | ours: median mm, deg, ms | GICP along the tree | LUM | time of GICP, LUM over ours "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const char* scene : {"thin", "person"})
    for (const char* rig : {"ring-4", "ring-8"})
      for (const std::string& sensor : {kSensors[1], kSensors[2], kSensors[4]}) {
        simulation::Simulator simulator(rigOf(scene, rig, sensor, 3));
        const Poses truth = truePoses(simulator);
        io::LoadedFrame loaded;
        simulator.measure(0, loaded);
        Errors ours, gicp, lum;
        std::vector<double> ms, gicp_ms, lum_ms;
        for (unsigned int trial = 0; trial < 3; ++trial) {
          const Poses start = disturbed(truth, trial);
          const auto begin = Clock::now();
          Estimation estimation;
          estimation.addFrame(loaded.rig);
          const ExtrinsicResult result = estimation.estimate(start);
          ms.push_back(since(begin));
          ours.add(start, result.T_world_camera, truth);
          const auto overlaps = byOverlap(result);
          const bench::PeerResult a = bench::gicpAlongTree(loaded.rig, start, overlaps, 0.03f, 0.1f);
          gicp.add(start, a.T_world_camera, truth);
          gicp_ms.push_back(a.milliseconds);
          const bench::PeerResult b = bench::lum(loaded.rig, start, overlaps, 0.03f, 0.25f, 8);
          lum.add(start, b.T_world_camera, truth);
          lum_ms.push_back(b.milliseconds);
        }
        const auto show = [](const Errors& e, const std::vector<double>& t) {
          std::printf(" | %.2f, %.3f, %.0f", bench::median(e.mm), bench::median(e.degrees), bench::median(t));
        };
        std::printf("| %s | %s | %s", scene, rig, sensor.c_str());
        show(ours, ms);
        show(gicp, gicp_ms);
        show(lum, lum_ms);
        std::printf(" | %.1f, %.1f |\n", bench::median(gicp_ms) / bench::median(ms),
                    bench::median(lum_ms) / bench::median(ms));
        std::fflush(stdout);
      }
}

/** \brief Whether poses without any start come, refined, to where the true ones do. */
bool samePlaces(const Poses& poses, const Poses& expected) {
  for (const bench::PoseError& e : bench::rigError(poses, expected))
    if (e.mm > 20 || e.degrees > 1) return false;
  return true;
}

/** \brief What became of the trials of one rig without poses. */
struct ScratchTrials {
  struct Found {
    Poses poses;
    bool complete;
    double milliseconds;
  };
  int trials{0}, right{0}, open{0};
  struct Refined {
    int within{0};
    Errors errors;  ///< of those that came out right
  };
  Refined by_one, by_many;  ///< frames
  std::vector<double> ms;

  void add(const ScratchTrials& others) {
    trials += others.trials;
    right += others.right;
    open += others.open;
    by_one.within += others.by_one.within;
    by_many.within += others.by_many.within;
  }
  void print(bool many) const {
    std::printf("%d of %d right, %d open, %d wrong, %d within the target from one frame", right, trials, open,
                trials - right - open, by_one.within);
    if (many) std::printf(", %d from many", by_many.within);
    std::printf("\n");
  }
};

/** \brief What finds poses without any start. */
using FromScratch = std::function<ScratchTrials::Found(const RigFrame&)>;

/** \brief Ours. */
ScratchTrials::Found coarseAlignment(const RigFrame& frame, const CoarseAlignmentParameters& parameters) {
  const auto begin = Clock::now();
  CoarseAlignment alignment;
  alignment.setParameters(parameters);
  alignment.addFrame(frame);
  const CoarseAlignmentResult coarse = alignment.estimate();
  return {coarse.T_world_camera, coarse.complete(), since(begin)};
}

/** \brief PCL's. It says of no camera that it is left open. */
ScratchTrials::Found fpfh(const RigFrame& frame) {
  const bench::PeerResult result = bench::fpfhAlongTree(frame, 0.05f);
  return {result.T_world_camera, true, result.milliseconds};
}

/** \brief Trials are seeds: where the small things lie, and the noise. Poses are found from one frame, and then refined by it alone and,
 *  if wanted, by as many as fuse_flow_calibrate takes by itself. */
ScratchTrials scratchTrials(const std::string& scene, const std::string& rig, const std::string& sensor, int seeds,
                            const FromScratch& find, bool many = false) {
  ScratchTrials result;
  const double factor = sensor == "structured_light" ? 2 : 1;
  for (int seed = 1; seed <= seeds; ++seed) {
    simulation::SimulationOptions options = rigOf(scene, rig, sensor, 3);
    options.seed = static_cast<std::uint64_t>(seed);
    simulation::Simulator simulator(options);
    const Poses truth = truePoses(simulator);
    io::LoadedFrame loaded;
    simulator.measure(0, loaded);
    Estimation estimation;
    estimation.addFrame(loaded.rig);
    const Poses expected = estimation.estimate(truth).T_world_camera;
    const ScratchTrials::Found found = find(loaded.rig);
    ++result.trials;
    result.ms.push_back(found.milliseconds);
    if (!found.complete) {
      ++result.open;
      continue;
    }
    const Poses refined = estimation.estimate(found.poses).T_world_camera;
    if (!samePlaces(refined, expected)) continue;
    ++result.right;
    const auto add = [&](const Poses& poses, ScratchTrials::Refined& to) {
      Errors own;
      own.add(expected, poses, truth);
      if (bench::median(own.mm) <= factor && bench::median(own.degrees) <= 0.05 * factor) ++to.within;
      to.errors.add(expected, poses, truth);
    };
    add(refined, result.by_one);
    if (!many) continue;
    const std::size_t enough = io::enoughFrames(loaded.rig, estimation.getParameters());
    for (std::size_t frame = 1; frame < enough; ++frame) {
      simulator.measure(frame, loaded);
      estimation.addFrame(loaded.rig);
    }
    add(estimation.estimate(found.poses).T_world_camera, result.by_many);
  }
  return result;
}

void scratchTable(const std::vector<std::string>& scenes, const std::vector<std::string>& rigs,
                  const std::vector<std::string>& sensors, int seeds, const FromScratch& find, bool many) {
  std::printf("| scene | rig | sensor | right | said to be open | wrong unnoticed");
  std::vector<const char*> columns{"1 frame"};
  if (many) columns.push_back("10 or 40 frames");
  for (const char* frames : columns) std::printf(" | within the target, %s | of those right: median mm, deg", frames);
  std::printf(" | ms |\n|---|---|---|---|---|---|%s---|\n", many ? "---|---|---|---|" : "---|---|");
  ScratchTrials all;
  for (const std::string& rig : rigs)
    for (const std::string& scene : scenes)
      for (const std::string& sensor : sensors) {
        const int trials =
            wantedTrials(scene + '/' + rig + '/' + sensor, rig == "walls-16" ? 1 : seeds);  // minutes each
        if (trials < 1) continue;
        const ScratchTrials t = scratchTrials(scene, rig, sensor, trials, find, many);
        std::printf("| %s | %s | %s | %d of %d | %d | %d", scene.c_str(), rig.c_str(), sensor.c_str(), t.right,
                    t.trials, t.open, t.trials - t.right - t.open);
        std::printf(" | %d", t.by_one.within);
        printMedians(t.by_one.errors);
        if (many) {
          std::printf(" | %d", t.by_many.within);
          printMedians(t.by_many.errors);
        }
        std::printf(" | %.0f |\n", bench::median(t.ms));
        std::fflush(stdout);
        all.add(t);
      }
  all.print(many);
}

ScratchTrials::Found ours(const RigFrame& frame) { return coarseAlignment(frame, {}); }

void scratch() { scratchTable({"thin", "person"}, {"ring-4", "ring-8", "walls-16"}, kSensors, 3, ours, true); }

void scratchPeers() { scratchTable({"thin", "person"}, {"ring-4"}, kSensors, 3, fpfh, false); }

void scratchTuning() {
  scratchTable({"room", "table"}, {"ring-4", "ring-8", "walls-8"}, {kSensors[1], kSensors[2], kSensors[4]}, 2, ours,
               false);
}

/** \brief The same for cameras that see less and less of the walls: the floor, and what stands on it, remain. */
void scratchNear() {
  std::printf(
      "| scene | sensor | as far as, m | right | said to be open | wrong unnoticed | ms "
      "|\n|---|---|---|---|---|---|---|\n");
  ScratchTrials all;
  for (const std::string scene : {"room", "table"})
    for (const std::string& sensor : {kSensors[2], kSensors[1]})
      for (const float range : {2.6f, 3.0f, 3.4f}) {
        CoarseAlignmentParameters p;
        p.preprocessing.max_range = range;
        const ScratchTrials t = scratchTrials(scene, "ring-4", sensor, 4,
                                              [&p](const RigFrame& frame) { return coarseAlignment(frame, p); });
        std::printf("| %s | %s | %.1f | %d of %d | %d | %d | %.0f |\n", scene.c_str(), sensor.c_str(),
                    static_cast<double>(range), t.right, t.trials, t.open, t.trials - t.right - t.open,
                    bench::median(t.ms));
        std::fflush(stdout);
        all.add(t);
      }
  all.print(false);
}

/** \brief Poses from a marker that someone waves, and refined from there; nothing is known before. */
void board() {
  constexpr double side = 0.4;
  constexpr std::size_t frames = 10;
  std::printf(
      "| scene | rig | sensor | markers seen by several cameras | corners, pixels | markers alone: median mm, deg | "
      "largest "
      "mm | refined: median mm, deg | largest mm |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const char* scene : {"thin", "person"})
    for (const char* rig : {"ring-4", "ring-8"})
      for (const std::string& sensor : {kSensors[1], kSensors[2], kSensors[4]}) {
        simulation::SimulationOptions options = rigOf(scene, rig, sensor, 3);
        options.marker = side;
        simulation::Simulator simulator(options);
        io::BoardKind kind;
        kind.side = side;
        io::Board board(kind);
        Estimation estimation;
        io::LoadedFrame loaded;
        for (std::size_t frame = 0; frame < frames; ++frame) {
          simulator.measure(frame, loaded);
          board.addFrame(loaded);
          estimation.addFrame(loaded.rig);
        }
        std::vector<Camera> cameras = simulator.cameras();
        for (std::size_t i = 1; i < cameras.size(); ++i) cameras[i].T_world_camera.setIdentity();
        std::printf("| %s | %s | %s |", scene, rig, sensor.c_str());
        try {
          const Poses truth = truePoses(simulator);
          const io::MarkerRig markers = board.place(cameras);
          Errors alone, refined;
          alone.add(truth, markers.T_world_camera, truth);
          refined.add(truth, estimation.estimate(markers.T_world_camera).T_world_camera, truth);
          std::printf(" %zu | %.2f | %.2f, %.3f | %.1f | %.2f, %.3f | %.1f |\n", markers.markers, markers.residual,
                      bench::median(alone.mm), bench::median(alone.degrees), alone.largest(), bench::median(refined.mm),
                      bench::median(refined.degrees), refined.largest());
        } catch (const io::InputError& error) {
          std::printf(" %s | | | | | |\n", error.what());
        }
        std::fflush(stdout);
      }
}

/** \brief Where measurements lie by cameras and their corrections, every 11th pixel each way. */
Eigen::Matrix3Xd placed(const io::LoadedFrame& frame, const std::vector<Camera>& cameras) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const DepthView& view = frame.rig.views[i];
    for (int v = 0; v < view.height(); v += 11)
      for (int u = 0; u < view.width(); u += 11) {
        const float z = cameras[i].depth_scale * static_cast<float>(view.depth16.row(v)[u]);
        if (!(z > 0)) continue;
        const Vec3 p = pointOnRay(unproject(cameras[i].intrinsics, {static_cast<float>(u), static_cast<float>(v)}),
                                  correctedDepth(z, cameras[i].depth_correction.at(u, v, view.width(), view.height())));
        points.push_back(cameras[i].T_world_camera * Eigen::Vector3d(p.x, p.y, p.z));
      }
  }
  Eigen::Matrix3Xd result(3, points.size());
  for (std::size_t k = 0; k < points.size(); ++k) result.col(static_cast<Eigen::Index>(k)) = points[k];
  return result;
}

/** \brief Root mean square distance of measurements from where they truly lie, millimetres, after the whole was laid onto it: neither its
 *  scale nor its place can be known. */
double misplaced(const io::LoadedFrame& frame, const std::vector<Camera>& cameras, const std::vector<Camera>& truth) {
  const Eigen::Matrix3Xd found = placed(frame, cameras), right = placed(frame, truth);
  const Eigen::Matrix4d T = Eigen::umeyama(found, right, true);
  const Eigen::Matrix3Xd off = ((T.topLeftCorner<3, 3>() * found).colwise() + T.topRightCorner<3, 1>()) - right;
  return 1000 * std::sqrt(off.colwise().squaredNorm().mean());
}

std::vector<Camera> at(std::vector<Camera> cameras, const Poses& poses) {
  for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i].T_world_camera = poses[i];
  return cameras;
}

/** \brief Sensors that bend what they measure, each in its own way, at poses that are off. */
void distortion() {
  std::printf(
      "| scene | rig | sensor | misplaced by, mm: at the given poses | poses refined | poses and corrections | "
      "cameras, median mm, "
      "deg: poses refined | poses and corrections | knots observable | s "
      "|\n|---|---|---|---|---|---|---|---|---|---|\n");
  for (const char* scene : {"person", "thin"})
    for (const char* rig : {"ring-6", "walls-16"})
      for (const std::string& sensor : {kSensors[1], kSensors[2], kSensors[4]}) {
        simulation::SimulationOptions options = rigOf(scene, rig, sensor, 3);
        options.faults.depth_distortion = 0.015;
        simulation::Simulator simulator(options);
        Estimation extrinsics;
        DepthCorrectionEstimation corrections;
        io::LoadedFrame loaded;
        for (std::size_t frame = 0; frame < 10; ++frame) {
          simulator.measure(frame, loaded);
          extrinsics.addFrame(loaded.rig);
          corrections.addFrame(loaded.rig);
        }
        const std::vector<Camera>& truth = simulator.trueCameras();
        const Poses true_poses = truePoses(simulator), initial = disturbed(true_poses, 1);
        const Poses refined = extrinsics.estimate(initial).T_world_camera;
        const Clock::time_point start = Clock::now();
        const DepthCorrectionResult result = corrections.estimate(initial);
        const double seconds = since(start) / 1000;
        Poses corrected;
        for (const Camera& camera : result.cameras) corrected.push_back(camera.T_world_camera);
        Errors alone, together;
        alone.add(initial, refined, true_poses);
        together.add(initial, corrected, true_poses);
        const std::vector<Camera>& given = simulator.cameras();
        double observable = 0;
        for (const double share : result.observable)
          observable += share / static_cast<double>(result.observable.size());
        std::printf("| %s | %s | %s | %.1f | %.1f | %.1f | %.1f, %.2f | %.1f, %.2f | %.0f %% | %.1f |\n", scene, rig,
                    sensor.c_str(), misplaced(loaded, at(given, initial), truth),
                    misplaced(loaded, at(given, refined), truth), misplaced(loaded, result.cameras, truth),
                    bench::median(alone.mm), bench::median(alone.degrees), bench::median(together.mm),
                    bench::median(together.degrees), 100 * observable, seconds);
        std::fflush(stdout);
      }
}

void printQuality(const char* views, const char* poses, double residual, const RigFrame& frame) {
  FuseFlow<PointFused> fusion;
  pcl::PointCloud<PointFused> cloud;
  fusion.fuse(frame, cloud);
  const ReprojectionQuality q = reprojectionQuality(cloud, frame);
  std::printf("| %s | %s | %.2f | %.2f | %.2f %% | %.2f %% |\n", views, poses, 1000 * residual,
              1000 * q.multi_view_error, 100 * q.violationShare(), 100 * q.coverage());
}

/** \brief Poses from a frame whose cameras have the corrections that they have. */
ExtrinsicResult refine(RigFrame& frame) {
  Estimation estimation;
  estimation.addFrame(frame);
  const ExtrinsicResult result = estimation.estimate();
  frame.cameras = at(frame.cameras, result.T_world_camera);
  return result;
}

DepthCorrectionResult correct(const RigFrame& frame) {
  DepthCorrectionParameters parameters;
  parameters.shared = true;
  DepthCorrectionEstimation estimation;
  estimation.setParameters(parameters);
  estimation.addFrame(frame);
  return estimation.estimate();
}

void real() {
  const std::string folder = std::string(FUSE_FLOW_SHARED_DATA) + "/seven_scenes";
  if (!std::filesystem::exists(folder)) {
    std::printf("no recording at %s\n", folder.c_str());
    return;
  }
  const auto read = [&](const std::string& views) {
    io::RecordingOptions options;
    options.views = views;
    auto loaded = std::make_unique<io::LoadedFrame>();
    io::openRecording({folder}, options)->read(0, *loaded);
    return loaded;
  };
  const DepthCorrection of_others = correct(read("5:200:10")->rig).cameras[0].depth_correction;
  std::printf(
      "| views | poses | surfaces disagree, rms mm | E_MC (2+) mm | violations | coverage "
      "|\n|---|---|---|---|---|---|\n");
  for (const char* views : {"0,60,120,180", "0:160:20"}) {
    const auto loaded = read(views);
    const std::vector<Camera> given = loaded->rig.cameras;
    const ExtrinsicResult result = refine(loaded->rig);
    const std::vector<Camera> refined = loaded->rig.cameras;
    loaded->rig.cameras = given;
    printQuality(views, "as recorded", result.residual_before, loaded->rig);
    loaded->rig.cameras = refined;
    printQuality(views, "refined", result.residual, loaded->rig);
    loaded->rig.cameras = given;
    for (Camera& camera : loaded->rig.cameras) camera.depth_correction = of_others;
    const double residual = refine(loaded->rig).residual;
    printQuality(views, "refined, depth corrected by what twenty other frames tell", residual, loaded->rig);
    loaded->rig.cameras = given;
    const std::vector<Camera> corrected = correct(loaded->rig).cameras;
    loaded->rig.cameras = corrected;
    const double alone = refine(loaded->rig).residual_before;  // measured as in the rows above
    loaded->rig.cameras = corrected;
    printQuality(views, "refined together with the correction", alone, loaded->rig);
  }
}

/** \brief Frame time of the fusion alone, and with an estimation running, interleaved frame by frame, so that both run under the same
 *  load. */
void beside() {
  std::printf(
      "| cameras | fusion alone, ms | with estimation, ms | rate kept | estimate, ms | estimate with two threads and "
      "nothing beside it, ms |\n|---|---|---|---|---|---|\n");
  for (const int cameras : {1, 2, 4, 6, 8}) {
    simulation::Simulator simulator(rigOf("room", "ring-" + std::to_string(cameras), "structured_light", 30));
    io::LoadedFrame loaded;
    simulator.measure(0, loaded);
    Tracking tracking(loaded.rig.cameras, 0.002);
    FuseFlow<PointFused> fusion;
    pcl::PointCloud<PointFused> cloud;
    std::vector<double> alone, with, estimate, quiet;
    for (int round = 0; round < 6; ++round) {
      tracking.finish();
      for (int k = 0; k < 12; ++k) {
        const auto start = Clock::now();
        fusion.fuse(loaded.rig, cloud);
        alone.push_back(since(start));
      }
      for (int k = 0; k < 12; ++k) {
        const auto start = Clock::now();
        tracking.push(loaded.rig);
        tracking.apply(loaded.rig);
        fusion.fuse(loaded.rig, cloud);
        with.push_back(since(start));
        estimate.push_back(tracking.poses()->milliseconds);
      }
    }
    tracking.setNumberOfThreads(2);
    for (int k = 0; k < 8; ++k) {
      tracking.push(loaded.rig);
      tracking.finish();
      quiet.push_back(tracking.poses()->milliseconds);
    }
    std::printf("| %d | %.1f | %.1f | %.0f %% | %.0f | %.0f |\n", cameras, bench::median(alone), bench::median(with),
                100 * bench::median(alone) / bench::median(with), bench::median(estimate), bench::median(quiet));
    std::fflush(stdout);
  }
}

void bump() {
  std::printf(
      "| scene | rig | sensor | noticed after, frames | within 3 mm again after, frames | false alarms in 36 frames | "
      "median error at the end, mm |\n|---|---|---|---|---|---|---|\n");
  constexpr std::size_t at = 12, frames = 36;
  for (const char* scene : {"room", "person"})
    for (const char* rig : {"ring-4"})
      for (const std::string& sensor : {kSensors[1], kSensors[2]}) {
        simulation::SimulationOptions options = rigOf(scene, rig, sensor, 30);
        options.faults.bump = 0.05;
        options.faults.bump_rotation = 0.017453292519943295;
        options.faults.bump_frame = at;
        simulation::Simulator simulator(options);
        Tracking tracking(simulator.cameras(), 0.002);
        tracking.setNumberOfThreads(2);
        io::LoadedFrame loaded;
        std::size_t noticed = 0, right = 0, alarms = 0;
        double final_error = 0;
        const std::size_t last = simulator.cameras().size() - 1;
        for (std::size_t frame = 0; frame < frames; ++frame) {
          simulator.measure(frame, loaded);
          tracking.push(loaded.rig);
          tracking.finish();
          for (const CameraMotion& m : tracking.poses()->moved) {
            const bool it = m.camera == last && frame >= at && noticed == 0;
            if (it) noticed = frame - at + 1;
            alarms += it ? 0 : 1;
          }
          Poses truth;
          for (std::size_t i = 0; i <= last; ++i) truth.push_back(simulator.truePose(frame, i));
          const auto errors = bench::rigError(tracking.poses()->T_world_camera, truth);
          if (frame >= at && right == 0 && errors[last].mm < 3) right = frame - at + 1;
          std::vector<double> mm;
          for (const auto& e : errors) mm.push_back(e.mm);
          final_error = bench::median(mm);
        }
        std::printf("| %s | %s | %s | %zu | %zu | %zu | %.2f |\n", scene, rig, sensor.c_str(), noticed, right, alarms,
                    final_error);
        std::fflush(stdout);
      }
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::pair<std::string, void (*)()>> tables{{"accuracy", accuracy},
                                                               {"accuracy-tuning", accuracyTuning},
                                                               {"frames", frames},
                                                               {"multipath", multipath},
                                                               {"floor", floorTable},
                                                               {"registration", registration},
                                                               {"peers", peers},
                                                               {"scratch", scratch},
                                                               {"scratch-peers", scratchPeers},
                                                               {"scratch-tuning", scratchTuning},
                                                               {"scratch-near-tuning", scratchNear},
                                                               {"board", board},
                                                               {"distortion", distortion},
                                                               {"real", real},
                                                               {"beside", beside},
                                                               {"bump", bump}};
  const auto served_tuning = [](const std::string& name) { return name.find("-tuning") != std::string::npos; };
  std::vector<std::string> wanted;
  for (int k = 1; k < argc; ++k) {
    const std::string name = argv[k];
    (name.find('/') != std::string::npos ? wanted_rows : wanted).push_back(name);
  }
  for (const std::string& name : wanted)
    if (std::none_of(tables.begin(), tables.end(), [&](const auto& t) { return t.first == name; })) {
      std::fprintf(
          stderr,
          "fuse_flow_calibration_bench: '%s' is none of accuracy, accuracy-tuning, frames, multipath, floor, "
          "registration, "
          "peers, scratch, scratch-peers, scratch-tuning, scratch-near-tuning, board, distortion, real, beside, "
          "bump\n",
          name.c_str());
      return 2;
    }
  for (const auto& [name, table] : tables)
    if ((wanted.empty() && !served_tuning(name)) || std::find(wanted.begin(), wanted.end(), name) != wanted.end()) {
      std::printf("\n%s\n\n", name.c_str());
      table();
    }
}
