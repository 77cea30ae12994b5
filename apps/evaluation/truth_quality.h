#pragma once

#include "evaluation/truth_sight.h"
#include "simulation/surfaces/ray_scene.h"

#include <fuse_flow/camera.h>

#include <pcl/PCLPointCloud2.h>

#include <cstdint>
#include <limits>
#include <vector>

namespace fuse_flow::simulation {

/** \brief A cloud of any origin; normals and colors (channels 0 … 255) are empty where it has none. Points that are not finite
 *  are left out. */
struct PlainCloud {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;
  std::vector<Eigen::Vector3f> colors;
};

PlainCloud plainCloud(const pcl::PCLPointCloud2& cloud);

/** \brief Samples of the true surface, evenly by area, that at least one camera sees unoccluded. present: which cameras
 *  measured in this frame. The same for any number of threads. */
std::vector<SurfacePoint> visibleSurface(const RayScene& scene, const std::vector<Camera>& cameras,
                                         const std::vector<bool>& present, const Visibility& visibility, int threads);

/** \brief A cloud against the exact surface. Distances in millimetres, shares from 0 to 1; NaN: cannot be said. */
struct TruthQuality {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::size_t points{0};
  std::size_t surface_samples{0};
  /** \brief Distance of the points to the true surface. */
  double accuracy_mean{kUnknown};
  double accuracy_median{kUnknown};
  double accuracy_p95{kUnknown};
  /** \brief Share of the points within 5 and 10 mm of the true surface. */
  double precision_5{kUnknown};
  double precision_10{kUnknown};
  /** \brief Recall: share of the visible true surface with a point within 5 and 10 mm. */
  double completeness_5{kUnknown};
  double completeness_10{kUnknown};
  /** \brief Harmonic means of precision and recall. */
  double f_score_5{kUnknown};
  double f_score_10{kUnknown};
  /** \brief Share of the points over 30 mm from any true surface. */
  double ghosting{kUnknown};
  /** \brief Mean angle between a point's normal and the true one, degrees, over points within 30 mm. */
  double normal_error{kUnknown};
  /** \brief Mean absolute difference to the true colour, per channel of 255, over points within 30 mm. */
  double color_error{kUnknown};
};

/** \brief What is found on the way, for figures of parts. */
struct TruthMatches {
  /** \brief What of the true surface is nearest to each point. */
  std::vector<NearestHit> surface;
  /** \brief From each sample to the nearest point, metres; infinite over 10 mm. */
  std::vector<float> gaps;
};

/** \brief \param matches filled in where given */
TruthQuality compareWithTruth(const PlainCloud& cloud, const RayScene& scene, const std::vector<SurfacePoint>& visible,
                              int threads, TruthMatches* matches = nullptr);

/** \brief How much a cloud jumps from one frame to the next where nothing moved, millimetres: the mean, over the points within
 *  30 mm of a fixed surface, of the difference between a point's height over that surface and that of the other frame's point
 *  beside it, both ways; 30 mm where the other frame has no point as near as that. How dense the clouds are does not matter. */
double flicker(const PlainCloud& before, const PlainCloud& after, const RayScene& scene, int threads);

}  // namespace fuse_flow::simulation
