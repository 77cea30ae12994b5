#pragma once

#include "evaluation/truth_quality.h"
#include "evaluation/truth_sight.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::simulation {

/** \brief The points and the visible samples of one part of the true surface, of one frame or of several. Distances in
 *  millimetres, shares from 0 to 1; NaN: cannot be said. */
class PartQuality {
 public:
  explicit PartQuality(std::string name) : name_(std::move(name)) {}

  /** \param signed_distance of a point to the true surface, metres; positive outside */
  void addPoint(float signed_distance);
  /** \param gap from a sample of the surface to the nearest point, metres */
  void addSample(float gap);
  PartQuality& operator+=(const PartQuality& other);

  const std::string& name() const { return name_; }
  std::size_t points() const { return points_; }
  std::size_t surfaceSamples() const { return samples_; }
  /** \brief Mean distance of the points to the true surface. */
  double accuracyMean() const;
  /** \brief Mean signed distance of the points within 30 mm, positive outside: negative where a body comes out thin. */
  double signedMean() const;
  /** \brief Share of the points over 30 mm from the surface. */
  double ghosting() const;
  double precision5() const;
  double completeness5() const;
  double completeness10() const;
  double fScore5() const;

 private:
  std::string name_;
  std::size_t points_{0}, points_within_5_{0}, points_within_30_{0};
  std::size_t samples_{0}, covered_5_{0}, covered_10_{0};
  double distances_{0}, signed_distances_{0};  // sums, metres; the second of the points within 30 mm
};

/** \brief A frame's visible true surface, ordered by what it is and by how it is seen. */
class PartComparison {
 public:
  /** \brief Scene and cameras must outlive it. \param visible what the cameras see of the scene, see visibleSurface() */
  PartComparison(const RayScene& scene, const TrueCameras& cameras, const std::vector<SurfacePoint>& visible,
                 int threads);

  /** \brief Each part, those of a person first; then groups: a person, what of it is under 40 mm above the floor; and, of what
   *  moves or, in a scene where nothing does, of everything, by speed, by the best incidence among the cameras that see it, and by
   *  their number. A point belongs to where the surface is nearest to it. */
  std::vector<PartQuality> compare(const TruthMatches& matches) const;

 private:
  std::vector<std::size_t> groupsOf(const SurfacePoint& point) const;

  const RayScene& scene_;
  const TrueCameras& cameras_;
  int threads_;
  bool anything_moves_{false};
  std::vector<std::string> names_;
  std::vector<std::size_t> part_of_;  // of each object, a number into names_
  std::size_t first_group_{0};        // behind the parts
  std::vector<std::vector<std::size_t>> groups_of_visible_;
};

/** \brief Adds those of a frame to those of the frames before it, by name. */
void addParts(std::vector<PartQuality>& sum, const std::vector<PartQuality>& frame);

}  // namespace fuse_flow::simulation
