#include "stereo/stereo_geometry.h"

#include <fuse_flow/impl/stereo/stereo_rig.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <sstream>

namespace fuse_flow::io {
namespace {

constexpr float kSmallAngle = 2, kLargeAngle = 30;  // degrees
constexpr const char* kRightAngle = "5 to 12 degrees";

std::string rounded(float value) {
  std::ostringstream text;
  text.precision(3);
  if (value < 1000) {
    text << value;
  } else {
    text << std::lround(value);
  }
  return text.str();
}

/** \brief How its sources look another way than a view does. */
struct Turn {
  float angle;   ///< of the one that does the least, degrees
  bool outward;  ///< all look away from the view: only at the sides of their images they see the same
};

/** \brief If the axes of two views meet, the angle is that between their rays there. StereoGeometry tells the
 *  angle at the distance that it assumes, which is never small against the baseline. */
Turn leastTurned(const std::vector<Camera>& cameras, std::size_t view, const std::vector<std::size_t>& sources) {
  const Camera own = stereoCamera(cameras[view]);
  double cosine = -1;
  bool outward = true;
  for (const std::size_t k : sources) {
    const Camera source = stereoCamera(cameras[k]);
    const Eigen::Vector3d own_axis = own.T_world_camera.linear().col(2), axis = source.T_world_camera.linear().col(2);
    cosine = std::max(cosine, own_axis.dot(axis));
    outward =
        outward && (own_axis - axis).dot(own.T_world_camera.translation() - source.T_world_camera.translation()) > 0;
  }
  return {static_cast<float>(std::acos(std::min(cosine, 1.0)) * 180 / 3.14159265358979323846), outward};
}

/** \brief Some of the cameras whose depth is estimated, for one line of warning. */
class Group {
 public:
  void add(const std::string& name) {
    if (++count_ <= kNamed) names_ += (names_.empty() ? "" : ", ") + name;
  }
  std::size_t count() const { return count_; }
  /** \brief "2 of 16 views (left, right) have"  \param verbs of one and of several */
  std::string of(std::size_t all, const char* one = " has", const char* several = " have") const {
    const std::string others = count_ > kNamed ? ", …" : "";
    return std::to_string(count_) + " of " + std::to_string(all) + " views (" + names_ + others + ")" +
           (count_ == 1 ? one : several);
  }

 private:
  static constexpr std::size_t kNamed = 3;
  std::size_t count_{0};
  std::string names_;
};

}  // namespace

StereoSetup stereoSetup(const std::vector<Camera>& cameras, const std::vector<bool>& has_color,
                        const StereoParameters& parameters) {
  std::vector<Camera> of_color;
  std::transform(cameras.begin(), cameras.end(), std::back_inserter(of_color), stereoCamera);
  detail::StereoRig rig;
  rig.assign(of_color, has_color, parameters);
  StereoSetup setup;
  for (std::size_t k = 0; k < cameras.size(); ++k) setup.geometry.push_back(rig.geometry(k));
  setup.cameras = rig.resultCameras();
  return setup;
}

std::vector<std::string> stereoWarnings(const std::vector<Camera>& cameras, const std::vector<bool>& of,
                                        const std::vector<StereoGeometry>& geometry,
                                        const StereoParameters& parameters) {
  Group alone, parallel, close, far, outward;
  float smallest = std::numeric_limits<float>::max(), largest = 0;
  float least_angle = kSmallAngle, most_angle = kLargeAngle, most_outward = kLargeAngle;
  std::size_t all = 0;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    if (!of[k]) continue;
    ++all;
    const StereoGeometry& g = geometry[k];
    const std::string& name = cameras[k].name;
    if (g.sources.empty()) {
      alone.add(name);
      continue;
    }
    smallest = std::min(smallest, g.min_depth);
    largest = std::max(largest, g.max_depth);
    if (g.parallel_baselines) parallel.add(name);
    if (g.min_angle < kSmallAngle) close.add(name);
    least_angle = std::min(least_angle, g.min_angle);
    const Turn turn = leastTurned(cameras, k, g.sources);
    if (!(turn.angle > kLargeAngle)) continue;
    (turn.outward ? outward : far).add(name);
    float& most = turn.outward ? most_outward : most_angle;
    most = std::max(most, turn.angle);
  }
  std::vector<std::string> lines;
  const std::string right = std::string("; ") + kRightAngle + " to two or more neighbours are right";
  if (alone.count() > 0)
    lines.push_back(alone.of(all, " overlaps", " overlap") +
                    " no other and gets no depth; what a camera sees must be seen by others, " + kRightAngle +
                    " beside it; are the poses right (--pose-convention)?");
  if (parallel.count() > 0)
    lines.push_back(parallel.of(all) +
                    " neighbours in one direction only, and edges along it match anywhere; cameras at two heights, in "
                    "turn, are right");
  if (close.count() > 0)
    lines.push_back(close.of(all) + " a neighbour less than " + rounded(kSmallAngle) + " degrees away (" +
                    rounded(least_angle) + "), which tells little of depth" + right);
  if (far.count() > 0)
    lines.push_back(far.of(all) + " no neighbour less than " + rounded(kLargeAngle) + " degrees away (" +
                    rounded(most_angle) + "), and images differ too much to be matched" + right);
  if (outward.count() > 0)
    lines.push_back(outward.of(all, " looks", " look") + " away from its neighbours, from the nearest by up to " +
                    rounded(most_outward) +
                    " degrees: depth is found where two overlap, and --min-agreeing-views 1 keeps what no third sees; "
                    "elsewhere only depth of another source helps");
  const bool assumed = parameters.min_depth == 0 || parameters.max_depth == 0;
  if (assumed && largest > 0)
    lines.push_back("depth is looked for from " + rounded(smallest) + " to " + rounded(largest) +
                    " m, as follows from the poses; --stereo-min-depth and --stereo-max-depth say what is known");
  return lines;
}

std::string epipolarWarning(const std::vector<Camera>& cameras, const std::vector<EpipolarError>& errors) {
  constexpr std::size_t enough = 30;  // matches of a pair
  constexpr float off = 2;            // pixels; of exact calibrations single pairs have up to 1.6, cameras less
  std::vector<std::vector<float>> of_camera(cameras.size());
  for (const EpipolarError& error : errors) {
    if (error.matches < enough) continue;
    of_camera[error.view].push_back(error.median);
    of_camera[error.source].push_back(error.median);
  }
  Group wrong;
  std::size_t known = 0;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    std::vector<float>& medians = of_camera[k];
    if (medians.size() < 2) continue;
    ++known;
    const auto middle = medians.begin() + static_cast<std::ptrdiff_t>(medians.size() / 2);
    std::nth_element(medians.begin(), middle, medians.end());
    if (*middle > off) wrong.add(cameras[k].name + ": " + rounded(*middle));
  }
  if (wrong.count() == 0) return "";
  return wrong.of(known) + " matches more than " + rounded(off) +
         " pixels beside the lines on which the calibration places them; intrinsics, lens distortion or poses are off, "
         "or "
         "the images are of other instants, and depth suffers; a pixel or less is right";
}

}  // namespace fuse_flow::io
