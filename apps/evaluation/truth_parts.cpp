#include "evaluation/truth_parts.h"

#include "simulation/pi.h"

#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace fuse_flow::simulation {
namespace {

constexpr float kNearTheFloor = 0.04f;  // metres
constexpr float kSlow = 1, kFast = 4;   // m/s
constexpr float kSteep = 45 * kPiF / 180, kGrazing = 65 * kPiF / 180;

/** \brief What is told apart beside the parts, in the order of the table. */
enum Group {
  kPerson,
  kPersonNearTheFloor,
  kUnder1,
  kFrom1To4,
  kOver4,
  kUnder45,
  kFrom45To65,
  kOver65,
  kOneCamera,
  kMoreCameras,
  kGroupCount
};

constexpr const char* kGroupNames[kGroupCount] = {"person",
                                                  "near the floor",
                                                  "under 1 m/s",
                                                  "1 to 4 m/s",
                                                  "over 4 m/s",
                                                  "incidence under 45 deg",
                                                  "incidence 45 to 65 deg",
                                                  "incidence over 65 deg",
                                                  "seen by 1 camera",
                                                  "seen by 2 or more"};

const std::string& partOf(const Object& object) { return object.part.empty() ? object.name : object.part; }

bool isOfPerson(const std::string& part) {
  return std::find(personParts().begin(), personParts().end(), part) != personParts().end();
}

double shareOf(std::size_t n, std::size_t of) {
  return of > 0 ? static_cast<double>(n) / static_cast<double>(of) : TruthQuality::kUnknown;
}

}  // namespace

void PartQuality::addPoint(float signed_distance) {
  const float distance = std::fabs(signed_distance);
  ++points_;
  distances_ += static_cast<double>(distance);
  points_within_5_ += distance <= 0.005f ? 1 : 0;
  if (!(distance <= 0.03f)) return;
  ++points_within_30_;
  signed_distances_ += static_cast<double>(signed_distance);
}

void PartQuality::addSample(float gap) {
  ++samples_;
  covered_5_ += gap <= 0.005f ? 1 : 0;
  covered_10_ += gap <= 0.010f ? 1 : 0;
}

PartQuality& PartQuality::operator+=(const PartQuality& other) {
  points_ += other.points_;
  points_within_5_ += other.points_within_5_;
  points_within_30_ += other.points_within_30_;
  samples_ += other.samples_;
  covered_5_ += other.covered_5_;
  covered_10_ += other.covered_10_;
  distances_ += other.distances_;
  signed_distances_ += other.signed_distances_;
  return *this;
}

double PartQuality::accuracyMean() const {
  return points_ > 0 ? 1e3 * distances_ / static_cast<double>(points_) : TruthQuality::kUnknown;
}
double PartQuality::signedMean() const {
  return points_within_30_ > 0 ? 1e3 * signed_distances_ / static_cast<double>(points_within_30_)
                               : TruthQuality::kUnknown;
}
double PartQuality::ghosting() const { return shareOf(points_ - points_within_30_, points_); }
double PartQuality::precision5() const { return shareOf(points_within_5_, points_); }
double PartQuality::completeness5() const { return shareOf(covered_5_, samples_); }
double PartQuality::completeness10() const { return shareOf(covered_10_, samples_); }
double PartQuality::fScore5() const {
  const double precision = precision5(), recall = completeness5();
  if (std::isnan(precision) || std::isnan(recall)) return points_ + samples_ > 0 ? 0 : TruthQuality::kUnknown;
  return precision + recall > 0 ? 2 * precision * recall / (precision + recall) : 0;
}

PartComparison::PartComparison(const RayScene& scene, const TrueCameras& cameras,
                               const std::vector<SurfacePoint>& visible, int threads)
    : scene_(scene), cameras_(cameras), threads_(threads) {
  std::vector<std::string> others;
  for (std::uint32_t k = 0; k < scene.objectCount(); ++k) {
    const std::string& part = partOf(scene.object(k));
    anything_moves_ = anything_moves_ || scene.moving(k);
    if (!isOfPerson(part) && std::find(others.begin(), others.end(), part) == others.end()) others.push_back(part);
  }
  names_ = personParts();
  names_.insert(names_.end(), others.begin(), others.end());
  for (std::uint32_t k = 0; k < scene.objectCount(); ++k) {
    const auto name = std::find(names_.begin(), names_.end(), partOf(scene.object(k)));
    part_of_.push_back(static_cast<std::size_t>(name - names_.begin()));
  }
  first_group_ = names_.size();
  names_.insert(names_.end(), std::begin(kGroupNames), std::end(kGroupNames));
  groups_of_visible_.resize(visible.size());
  host::parallelForEach(threads, visible.size(), [&](std::size_t k) { groups_of_visible_[k] = groupsOf(visible[k]); });
}

std::vector<std::size_t> PartComparison::groupsOf(const SurfacePoint& point) const {
  std::vector<std::size_t> groups{part_of_[point.object]};
  const auto in = [&](Group group) { groups.push_back(first_group_ + group); };
  if (isOfPerson(names_[groups[0]])) {
    in(kPerson);
    if (point.position.z() < kNearTheFloor) in(kPersonNearTheFloor);
  }
  const bool moves = scene_.moving(point.object);
  if (anything_moves_ && !moves) return groups;
  if (moves) {
    const float speed = point.velocity.norm();
    in(speed < kSlow ? kUnder1 : speed <= kFast ? kFrom1To4 : kOver4);
  }
  const Sight sight = cameras_.sightOf(scene_, point);
  if (sight.cameras == 0) return groups;
  in(sight.incidence < kSteep ? kUnder45 : sight.incidence <= kGrazing ? kFrom45To65 : kOver65);
  in(sight.cameras == 1 ? kOneCamera : kMoreCameras);
  return groups;
}

std::vector<PartQuality> PartComparison::compare(const TruthMatches& matches) const {
  std::vector<std::vector<std::size_t>> groups(matches.surface.size());
  host::parallelForEach(threads_, groups.size(), [&](std::size_t k) {
    if (matches.surface[k]) groups[k] = groupsOf(matches.surface[k]);
  });
  std::vector<PartQuality> parts(names_.begin(), names_.end());
  for (std::size_t k = 0; k < groups.size(); ++k)
    for (const std::size_t group : groups[k]) parts[group].addPoint(matches.surface[k].signed_distance);
  for (std::size_t k = 0; k < groups_of_visible_.size(); ++k)
    for (const std::size_t group : groups_of_visible_[k]) parts[group].addSample(matches.gaps[k]);
  return parts;
}

void addParts(std::vector<PartQuality>& sum, const std::vector<PartQuality>& frame) {
  for (const PartQuality& part : frame) {
    const auto mine =
        std::find_if(sum.begin(), sum.end(), [&](const PartQuality& other) { return other.name() == part.name(); });
    if (mine == sum.end())
      sum.push_back(part);
    else
      *mine += part;
  }
}

}  // namespace fuse_flow::simulation
