#include "evaluation/tables/comparison.h"

#include "evaluation/tables/open3d_methods.h"
#include "evaluation/tables/random_thinning.h"
#include "evaluation/truth_report.h"

#include <pcl/filters/impl/filter_indices.hpp>  // what it is from PCL 1.15 on
#include <pcl/filters/impl/uniform_sampling.hpp>
#include <pcl/filters/impl/voxel_grid.hpp>
#include <pcl/filters/uniform_sampling.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/impl/pcl_base.hpp>  // PCL has none for our point type

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

namespace fuse_flow::tables {
namespace {

using Cloud = io::Method::Cloud;
using simulation::PlainCloud;
using simulation::Simulator;

constexpr double kDegree = 3.14159265358979323846 / 180;

Simulator makeSimulator(const Setup& setup, int threads) {
  simulation::SimulationOptions options;
  options.scene = setup.scene;
  options.rig = setup.rig;
  options.sensor = setup.sensor;
  options.scale = setup.scale;
  options.threads = threads;
  options.seed = 11;
  options.faults.position_error = 0.002;
  options.faults.rotation_error = 0.1 * kDegree;
  return Simulator(options);
}

PlainCloud plain(const Cloud& cloud) {
  PlainCloud result;
  for (const PointFused& p : cloud) {
    result.positions.emplace_back(p.x, p.y, p.z);
    result.colors.emplace_back(p.r, p.g, p.b);
  }
  return result;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/** \brief A contender at work, with the leaf that was found for it. */
class Entrant {
 public:
  Entrant(Contender contender, int threads) : contender_(std::move(contender)) {
    options_.parameters = contender_.parameters;
    options_.threads = static_cast<unsigned int>(threads);
    options_.device = "cpu";  // as the peers
    make();
  }

  const Contender& contender() const { return contender_; }

  /** \brief Returns the milliseconds. */
  double fuse(const RigFrame& frame, Cloud& cloud) {
    method_->fuse(frame, cloud);
    const auto start = std::chrono::steady_clock::now();
    if (contender_.thinning == Thinning::Random) thinAtRandom(cloud, points_, 1);
    if (contender_.thinning == Thinning::VoxelGrid) {
      pcl::VoxelGrid<PointFused> grid;
      grid.setInputCloud(cloud.makeShared());
      grid.setLeafSize(options_.leaf_size, options_.leaf_size, options_.leaf_size);
      grid.filter(cloud);
    }
    if (contender_.thinning == Thinning::UniformSampling) {
      pcl::UniformSampling<PointFused> sampling;
      sampling.setInputCloud(cloud.makeShared());
      sampling.setRadiusSearch(options_.leaf_size);  // the side of its leaves
      sampling.filter(cloud);
    }
    return method_->statistics().total_ms +
           std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }

  /** \brief Looks for the leaf that leaves so many points. The points that a surface keeps go with 1 / leaf².
   *  \param leaf in: where to begin; out: what was found, from which others are not far */
  void matchPoints(const RigFrame& frame, std::size_t points, float& leaf) {
    points_ = points;
    if (contender_.thinning == Thinning::Random) return;
    options_.leaf_size = leaf;
    make();
    searchLeaf(frame, slow() ? 3 : 6);
    leaf = options_.leaf_size;
  }

  /** \brief Seconds a frame. */
  bool slow() const { return contender_.method == "outlier_removal" || contender_.method == "open3d_tsdf"; }

 private:
  void make() {
    method_ = makeOpen3dMethod(contender_.method, options_);
    if (!method_) method_ = io::makeMethod(contender_.method, options_);
  }

  void searchLeaf(const RigFrame& frame, int steps) {
    Cloud cloud;
    for (int step = 0; step < steps; ++step) {
      fuse(frame, cloud);
      const double ratio = static_cast<double>(cloud.size()) / static_cast<double>(points_);
      if (cloud.empty() || std::fabs(ratio - 1) < 0.01) return;
      options_.leaf_size = std::clamp(options_.leaf_size * static_cast<float>(std::sqrt(ratio)), 0.004f, 0.1f);
      make();
    }
  }

  Contender contender_;
  io::MethodOptions options_;
  std::unique_ptr<io::Method> method_;
  std::size_t points_{0};  ///< that thinning leaves
};

std::vector<Entrant> enter(const std::vector<Contender>& contenders, int threads) {
  std::vector<Entrant> entrants;
  for (const Contender& contender : contenders) entrants.emplace_back(contender, threads);
  return entrants;
}

void matchPoints(std::vector<Entrant>& entrants, const RigFrame& frame) {
  Cloud first;
  entrants[0].fuse(frame, first);
  float leaf = io::MethodOptions().leaf_size;
  for (Entrant& entrant : entrants)
    if (entrant.contender().equalPoints()) entrant.matchPoints(frame, first.size(), leaf);
}

simulation::Visibility visibilityOf(const Simulator& simulator) {
  simulation::Visibility visibility;
  visibility.min_range = simulator.sensor().minRange();
  visibility.max_range = simulator.sensor().maxRange();
  return visibility;
}

std::vector<bool> presentIn(const RigFrame& frame) {
  std::vector<bool> present;
  for (const DepthView& view : frame.views) present.push_back(!view.missing());
  return present;
}

/** \brief The frames' figures of one contender. */
struct Tally {
  std::vector<simulation::TruthQuality> truth;
  std::vector<double> flicker, error, violations, coverage, milliseconds;
  SurfaceQuality surface;
  std::vector<simulation::PartQuality> parts;
  std::optional<PlainCloud> previous;
  Cloud previous_cloud;
};

double meanOf(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? simulation::TruthQuality::kUnknown : sum / static_cast<double>(values.size());
}

}  // namespace

std::vector<Result> compare(const Setup& setup, const std::vector<Contender>& contenders, int threads,
                            const OnFirst& on_first) {
  Simulator simulator = makeSimulator(setup, threads);
  std::vector<Entrant> entrants = enter(contenders, threads);
  std::vector<Tally> tallies(entrants.size());
  io::LoadedFrame loaded, before;
  for (std::size_t frame = 0; frame < setup.frames; ++frame) {
    std::swap(loaded, before);
    simulator.measure(frame, loaded);
    const simulation::Visibility visibility = visibilityOf(simulator);
    const std::vector<bool> present = presentIn(loaded.rig);
    const simulation::RayScene& truth = simulator.truth(frame);
    const auto visible = visibleSurface(truth, simulator.trueCameras(), present, visibility, threads);
    const simulation::TrueCameras cameras(simulator.trueCameras(), present, visibility);
    const simulation::PartComparison parts(truth, cameras, visible, threads);
    if (frame == 0) matchPoints(entrants, loaded.rig);
    for (std::size_t k = 0; k < entrants.size(); ++k) {
      Tally& tally = tallies[k];
      Cloud cloud;
      const int repetitions = frame == 0 && !entrants[k].slow() ? 3 : 1;
      for (int r = 0; r < repetitions; ++r) tally.milliseconds.push_back(entrants[k].fuse(loaded.rig, cloud));
      simulation::TruthMatches matches;
      PlainCloud points = plain(cloud);
      tally.truth.push_back(compareWithTruth(points, truth, visible, threads, &matches));
      addParts(tally.parts, parts.compare(matches));
      const auto count = static_cast<unsigned int>(threads);
      const ReprojectionQuality consistency = reprojectionQuality(cloud, loaded.rig, {}, count);
      tally.error.push_back(1e3 * consistency.error);
      tally.violations.push_back(consistency.violationShare());
      tally.coverage.push_back(consistency.coverage());
      SurfaceQuality surface = surfaceQuality(cloud, loaded.rig, {}, count);
      if (frame > 0) surface.flicker = temporalFlicker(tally.previous_cloud, before.rig, cloud, loaded.rig, {}, count);
      tally.surface += surface;
      if (on_first && frame == 0) {
        std::vector<float> distances;
        for (const simulation::NearestHit& hit : matches.surface) distances.push_back(hit.t);
        on_first(k, points, distances);
      }
      if (tally.previous) tally.flicker.push_back(flicker(*tally.previous, points, truth, threads));
      tally.previous = std::move(points);
      tally.previous_cloud = std::move(cloud);
    }
  }
  std::vector<Result> results;
  for (const Tally& tally : tallies)
    results.push_back({simulation::meanOf(tally.truth), meanOf(tally.flicker), meanOf(tally.error),
                       meanOf(tally.violations), meanOf(tally.coverage), tally.surface, median(tally.milliseconds),
                       tally.parts});
  return results;
}

std::vector<double> frameTimes(const Setup& setup, const std::vector<Contender>& contenders, int threads,
                               int repetitions) {
  Simulator simulator = makeSimulator(setup, threads);
  std::vector<Entrant> entrants = enter(contenders, threads);
  io::LoadedFrame loaded;
  simulator.measure(0, loaded);
  matchPoints(entrants, loaded.rig);
  std::vector<std::vector<double>> times(entrants.size());
  Cloud cloud;
  for (int r = 0; r < repetitions; ++r)
    for (std::size_t k = 0; k < entrants.size(); ++k) times[k].push_back(entrants[k].fuse(loaded.rig, cloud));
  std::vector<double> medians;
  for (const std::vector<double>& values : times) medians.push_back(median(values));
  return medians;
}

std::vector<Contender> peers() {
  std::vector<Contender> peers = {{"FUSE-Flow", "fuse_flow", {}},
                                  {"VoxelGrid", "voxel_grid", {}, Thinning::Leaf},
                                  {"ApproximateVoxelGrid", "approximate_voxel_grid", {}, Thinning::Leaf},
                                  {"outlier removal, VoxelGrid", "outlier_removal", {}, Thinning::Leaf}};
  for (const Open3dPeer& peer : open3dPeers()) peers.push_back({peer.name, peer.method, {}, Thinning::Leaf});
  peers.push_back({"concatenated, thinned at random", "concatenate", {}, Thinning::Random});
  peers.push_back({"concatenated, all points", "concatenate", {}});
  return peers;
}

std::vector<Contender> ablation() {
  FuseFlowParameters no_confidence, no_consistency, no_hash, measured;
  no_confidence.use_measurement_confidence = false;
  no_consistency.use_distance_consistency = false;
  no_hash.use_spatial_hash = false;
  measured.smoothing.passes = 0;
  return {{"all stages", "fuse_flow", {}},
          {"no measurement confidence", "fuse_flow", no_confidence},
          {"no distance consistency", "fuse_flow", no_consistency},
          {"no spatial hash: a point a pixel", "fuse_flow", no_hash},
          {"the same, then VoxelGrid", "fuse_flow", no_hash, Thinning::VoxelGrid},
          {"the same, then UniformSampling", "fuse_flow", no_hash, Thinning::UniformSampling},
          {"the same, thinned at random", "fuse_flow", no_hash, Thinning::Random},
          {"depth as measured", "fuse_flow", measured},
          {"the published forms", "fuse_flow", FuseFlowParameters::published()}};
}

}  // namespace fuse_flow::tables
