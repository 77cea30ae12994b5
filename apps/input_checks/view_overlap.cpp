#include "input_checks/view_overlap.h"

#include "recordings/calibrations/posed_recording.h"

#include <fuse_flow/impl/sensors/preprocessing.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

namespace fuse_flow::io {
namespace {

/** \brief What a camera measured, for others to look up. */
struct MeasuredView {
  host::ViewGeometry geometry;
  host::DepthMap depth;
};

std::vector<MeasuredView> measuredViews(const RigFrame& frame, const PreprocessingParameters& range) {
  std::vector<MeasuredView> views(frame.cameras.size());
  PreprocessingParameters plain;  // as measured
  plain.min_range = range.min_range;
  plain.max_range = range.max_range;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (frame.views[i].missing()) continue;
    views[i].geometry.assign(frame.cameras[i]);
    host::makeDepthMap(plain, views[i].geometry, frame.views[i], views[i].depth);
  }
  return views;
}

void place(const std::vector<Camera>& cameras, std::vector<MeasuredView>& views) {
  for (std::size_t i = 0; i < views.size(); ++i)
    if (!views[i].depth.empty()) views[i].geometry.assign(cameras[i]);
}

enum class Verdict { Unseen, Contradicts, Agrees };

Verdict ask(const MeasuredView& view, const Vec3& p_W) {
  int u = 0, v = 0;
  float z = 0;
  if (view.depth.empty() || !view.geometry.locate(p_W, u, v, z)) return Verdict::Unseen;
  const float measured = view.depth.row(v)[u], tolerance = 0.05f + 0.02f * z;
  if (!(measured > 0) || measured < z - tolerance) return Verdict::Unseen;  // nothing there, or something before it
  return measured <= z + tolerance ? Verdict::Agrees : Verdict::Contradicts;
}

std::vector<CameraOverlap> overlapOf(const std::vector<MeasuredView>& views) {
  std::vector<CameraOverlap> result(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const host::DepthMap& depth = views[i].depth;
    if (depth.empty()) continue;
    const int step = std::max(1, std::max(depth.width(), depth.height()) / 48);
    for (int v = step / 2; v < depth.height(); v += step)
      for (int u = step / 2; u < depth.width(); u += step) {
        const float z = depth.row(v)[u];
        if (!(z > 0)) continue;
        ++result[i].points;
        const Vec3 p = views[i].geometry.T_world_camera * pointOnRay(views[i].geometry.ray(u, v), z);
        Verdict best = Verdict::Unseen;
        for (std::size_t j = 0; j < views.size() && best != Verdict::Agrees; ++j)
          if (j != i) best = std::max(best, ask(views[j], p));
        result[i].seen += best != Verdict::Unseen ? 1 : 0;
        result[i].agreed += best == Verdict::Agrees ? 1 : 0;
      }
  }
  return result;
}

std::string percent(std::size_t part, std::size_t of) {
  std::ostringstream text;
  text << std::lround(of > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(of) : 0.0) << " %";
  return text.str();
}

CameraOverlap total(const std::vector<CameraOverlap>& cameras) {
  CameraOverlap sum;
  for (const CameraOverlap& camera : cameras) {
    sum.points += camera.points;
    sum.seen += camera.seen;
    sum.agreed += camera.agreed;
  }
  return sum;
}

constexpr double kLittle = 0.02;  // of a camera's points: what others see of them tells nothing
constexpr double kAgreement =
    0.3;  // of those that others see; rigs that are calibrated to centimetres have 0.6 and more

bool little(const CameraOverlap& camera) {
  return static_cast<double>(camera.seen) < kLittle * static_cast<double>(camera.points);
}
bool contradicts(const CameraOverlap& camera) {
  return !little(camera) && static_cast<double>(camera.agreed) < kAgreement * static_cast<double>(camera.seen);
}

double contradictedShare(const CameraOverlap& camera) {
  return camera.seen > 0 ? 1 - static_cast<double>(camera.agreed) / static_cast<double>(camera.seen) : 1;
}

/** \brief Whether poses may have another meaning: of what others see more than a tenth does not agree, or hardly anything is seen. */
bool doubtful(const CameraOverlap& all) {
  return static_cast<double>(all.seen) < 0.2 * static_cast<double>(all.points) || contradictedShare(all) > 0.1;
}

/** \brief Whether poses of another meaning are right by far: twice as many points agree; or as many, and the share that is
 *  contradicted is less than a third of that. */
bool isBetter(const CameraOverlap& then, const CameraOverlap& now) {
  if (contradicts(then) || little(then)) return false;
  return then.agreed > 2 * now.agreed ||
         (then.agreed >= now.agreed && 3 * contradictedShare(then) < contradictedShare(now));
}

/** \brief What is mirrored along an axis of the world, and of the camera: poses of a left-handed frame. */
Eigen::Isometry3d mirrored(const Eigen::Isometry3d& T, int axis) {
  Eigen::Matrix4d mirror = Eigen::Matrix4d::Identity();
  mirror(axis, axis) = -1;
  return Eigen::Isometry3d(Eigen::Matrix4d(mirror * T.matrix() * mirror));
}

/** \brief Which other meaning of the poses would make the views agree; empty: none would by far. */
std::string betterConvention(const RigFrame& frame, std::vector<MeasuredView>& views, const CameraOverlap& now) {
  struct Meaning {
    std::string text;  ///< before what it would give
    std::function<Eigen::Isometry3d(const Eigen::Isometry3d&)> of;
  };
  const auto convention = [](PoseConvention meant, const char* name) {
    return Meaning{std::string("with --pose-convention ") + name + " ",
                   [meant](const Eigen::Isometry3d& T) { return converted(T, meant); }};
  };
  const auto mirror = [](int axis, const char* name) {
    return Meaning{
        std::string("the poses seem to be of a left-handed frame, and must be of a right-handed one: with the ") +
            name + " axis of world and cameras negated ",
        [axis](const Eigen::Isometry3d& T) { return mirrored(T, axis); }};
  };
  std::string best;
  CameraOverlap before = now;
  for (const Meaning& meaning : {convention(PoseConvention::WorldToCamera, "world_to_camera"),
                                 convention(PoseConvention::OpenGl, "opengl"), mirror(0, "x"), mirror(1, "y")}) {
    std::vector<Camera> cameras = frame.cameras;
    for (Camera& camera : cameras) camera.T_world_camera = meaning.of(camera.T_world_camera);
    place(cameras, views);
    const CameraOverlap then = total(overlapOf(views));
    if (!isBetter(then, before)) continue;
    before = then;
    best = meaning.text + percent(then.agreed, then.seen) + " of the " + percent(then.seen, then.points) +
           " that others see would agree, instead of " + percent(now.agreed, now.seen) + " of " +
           percent(now.seen, now.points);
  }
  return best;
}

}  // namespace

std::vector<CameraOverlap> viewOverlap(const RigFrame& frame, const PreprocessingParameters& range) {
  return overlapOf(measuredViews(frame, range));
}

void OverlapCheck::look(const RigFrame& frame) {
  const auto there = [](const DepthView& view) { return !view.missing(); };
  if (done_ || std::count_if(frame.views.begin(), frame.views.end(), there) < 2) return;
  done_ = true;
  std::vector<MeasuredView> views = measuredViews(frame, range_);
  const std::vector<CameraOverlap> cameras = overlapOf(views);
  // Where only one measures anything in range, that is what is wrong, and it is said elsewhere.
  if (std::count_if(cameras.begin(), cameras.end(), [](const CameraOverlap& c) { return c.points > 0; }) < 2) return;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CameraOverlap& camera = cameras[i];
    if (camera.points == 0 || !(little(camera) || contradicts(camera))) continue;
    std::string line = "camera '" + frame.cameras[i].name + "': another camera could see " +
                       percent(camera.seen, camera.points) + " of its points";
    if (contradicts(camera))
      line += ", and of those " + percent(camera.agreed, camera.seen) +
              " agree in depth: its pose may be wrong, or inverted, or of other axes";
    else
      line += ": nothing of it can be checked or averaged; its pose may be in another frame, or inverted";
    complaints_.push_back(line);
  }
  if (complaints_.empty() && !doubtful(total(cameras))) return;
  const std::string better = betterConvention(frame, views, total(cameras));
  if (!better.empty()) complaints_.push_back(better);
}

}  // namespace fuse_flow::io
