#pragma once

#include "evaluation/truth_parts.h"
#include "evaluation/truth_quality.h"
#include "methods/instances.h"
#include "methods/method.h"
#include "simulation/simulator.h"

#include <functional>
#include <string>
#include <vector>

namespace fuse_flow::tables {

/** \brief A simulated rig in a scene, calibrated to 2 mm and 0.1 degrees. */
struct Setup {
  std::string scene;
  std::string rig;
  std::string sensor;
  std::size_t frames{1};
  /** \brief Of the images' sides. */
  double scale{1};

  std::string name() const { return scene + ", " + rig + ", " + sensor; }
};

/** \brief How a contender comes to a given number of points. */
enum class Thinning {
  /** \brief Not at all. */
  None,
  /** \brief By the leaf of its method. */
  Leaf,
  /** \brief By the leaf of a pcl::VoxelGrid over its cloud, for methods that have no leaf. */
  VoxelGrid,
  /** \brief By the leaf of a pcl::UniformSampling over its cloud, which leaves one of the points in each as it is. */
  UniformSampling,
  /** \brief By chance, see thinAtRandom(). */
  Random
};

/** \brief What is compared: a name for the tables, and how a cloud is made. */
struct Contender {
  std::string name;
  /** \brief Of io::makeMethod(). */
  std::string method;
  FuseFlowParameters parameters;
  /** \brief How its cloud is brought to as many points as the first contender has. */
  Thinning thinning{Thinning::None};

  bool equalPoints() const { return thinning != Thinning::None; }
};

/** \brief Means over the frames. */
struct Result {
  simulation::TruthQuality truth;
  double flicker{simulation::TruthQuality::kUnknown};  ///< mm
  double multi_camera_error{0};                        ///< eq. 12 over all points, mm
  double violations{0};                                ///< share of the points, at the exact pixel
  double coverage{0};                                  ///< share of the measurements, within one radius
  /** \brief What can be said without the truth; of all frames. */
  SurfaceQuality surface;
  double milliseconds{0};  ///< median over the frames, and three times the first
  /** \brief By part of the true surface, of all frames. */
  std::vector<simulation::PartQuality> parts;
};

/** \brief All contenders on the same frames, in one run. \param on_first if given: called with each contender's number, its
 *  first cloud and its points' distances to the true surface, metres */
using OnFirst = std::function<void(std::size_t, const simulation::PlainCloud&, const std::vector<float>&)>;
std::vector<Result> compare(const Setup& setup, const std::vector<Contender>& contenders, int threads,
                            const OnFirst& on_first = {});

/** \brief Median milliseconds of a frame of each contender. */
std::vector<double> frameTimes(const Setup& setup, const std::vector<Contender>& contenders, int threads,
                               int repetitions);

/** \brief Ours; its peers at the same number of points, pcl::VoxelGrid the first of them; and last all measurements. */
std::vector<Contender> peers();

/** \brief Ours, and ours without one stage at a time. */
std::vector<Contender> ablation();

}  // namespace fuse_flow::tables
