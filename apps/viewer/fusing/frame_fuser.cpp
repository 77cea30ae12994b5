#include "viewer/fusing/frame_fuser.h"

#include "command_line/message_of.h"
#include "methods/why_empty.h"
#include "recordings/readers/view_files.h"
#include "viewer/fusing/thumbnail.h"
#include "viewer/world/point_data.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <chrono>

namespace fuse_flow::viewing {
namespace {

constexpr int kThumbnailHeight = 240;          // pixels: of the largest strip; drawn smaller where the window is small
constexpr int kCoverageStep = 4;               // every fourth pixel each way tells coverage well enough to look at
constexpr std::size_t kSurfaceSamples = 4000;  // points that tell noise and double surfaces so

CameraMotion motionBetween(std::size_t number, const Camera& old, const Camera& now) {
  CameraMotion motion;
  motion.camera = number;
  motion.T_new_old = now.T_world_camera * old.T_world_camera.inverse();
  motion.translation = (now.T_world_camera.translation() - old.T_world_camera.translation()).norm();
  motion.rotation = Eigen::AngleAxisd(motion.T_new_old.linear()).angle();
  return motion;
}

void keepLatest(std::vector<CameraMotion>& motions, const CameraMotion& latest) {
  const auto same = [&](const CameraMotion& motion) { return motion.camera == latest.camera; };
  motions.erase(std::remove_if(motions.begin(), motions.end(), same), motions.end());
  motions.push_back(latest);
}

/** \brief The points in a box. */
std::shared_ptr<const Cloud> cropped(const std::shared_ptr<const Cloud>& cloud,
                                     const std::optional<Eigen::AlignedBox3f>& box) {
  if (!box) return cloud;
  const auto inside = std::make_shared<Cloud>();
  for (const auto& point : *cloud)
    if (box->contains(point.getVector3fMap())) inside->push_back(point);
  return inside;
}

int threadsOf(const FusionSetting& setting) { return host::resolveThreads(static_cast<int>(setting.options.threads)); }

}  // namespace

std::string frameName(std::size_t frame) {
  return "frame " + std::to_string(frame + 1) + " (" + io::frameStem(frame) + ")";
}

std::string frameName(std::size_t frame, std::size_t frames) {
  return "frame " + std::to_string(frame + 1) + " of " + std::to_string(frames) + " (" + io::frameStem(frame) + ")";
}

void FrameFuser::readFrame(std::size_t frame) {
  if (loaded_frame_ == frame) return;
  for (Pane& pane : panes_) {
    pane.before.reset();
    if (loaded_frame_ && pane.frame == loaded_frame_) pane.before.emplace(Earlier{pane.setting, pane.fused.cloud});
  }
  before_frame_ = loaded_frame_;
  std::swap(loaded_, before_);
  loaded_frame_.reset();
  const auto start = std::chrono::steady_clock::now();
  source_->read(frame, loaded_);
  read_ms_ = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  thumbnails_.clear();
  for (std::size_t i = 0; i < loaded_.rig.views.size() && !source_->isFinished(); ++i)
    thumbnails_.push_back(thumbnailOf(loaded_.rig.cameras[i], loaded_.rig.views[i], kThumbnailHeight));
  given_ = loaded_.rig.cameras;
  placed_ = false;
  truth_error_.clear();
  loaded_frame_ = frame;
}

const simulation::RayScene* FrameFuser::truth() {
  if (!source_->knowsTruth() || !truth_error_.empty()) return nullptr;
  try {
    return &source_->truth(*loaded_frame_);
  } catch (const io::InputError& error) {
    truth_error_ = error.what();
    return nullptr;
  }
}

/** \brief Switched off, what was learned is forgotten: the next time begins with the given poses again. */
void FrameFuser::placeCameras(const FusionRequest& request) {
  const bool refine = request.refine_extrinsics;
  if (placed_ && refine == refined_.has_value()) return;
  std::vector<CameraMotion> moved;
  if (refined_) moved = std::move(refined_->moved);
  if (refine != refined_.has_value())
    for (Pane& pane : panes_) pane.before.reset();  // surfaces would jump with the poses
  refined_.reset();
  loaded_.rig.cameras = given_;
  for (Pane& pane : panes_) pane.frame.reset();  // its cloud was fused with other poses
  if (!refine) {
    extrinsics_.reset();
  } else {
    if (!extrinsics_)
      extrinsics_ =
          std::make_unique<io::LiveExtrinsics>(request.settings[0]->options.device, request.settings[0]->options.warn);
    extrinsics_->place(loaded_.rig);
    refined_.emplace();
    for (std::size_t i = 0; i < given_.size(); ++i)
      refined_->corrections.push_back(motionBetween(i, given_[i], loaded_.rig.cameras[i]));
    refined_->moved = std::move(moved);
    for (const CameraMotion& motion : extrinsics_->moved()) keepLatest(refined_->moved, motion);
  }
  placed_ = true;
}

void FrameFuser::fuseCloud(const FusionRequest& request, Pane& pane, const FusionSettingPtr& setting) {
  if (pane.setting == setting && pane.frame == request.frame) return;
  if (const FinishedCloud finished = source_->finished(); finished.cloud) {
    pane.fused = {};
    pane.fused.setting = setting;
    pane.fused.cloud = cropped(finished.cloud, setting->options.parameters.crop_box);
    pane.fused.attributes.confidence_known = finished.has_confidence;
    pane.fused.attributes.views_known = finished.counts_views;
    if (pane.fused.cloud->empty()) pane.fused.why_empty = finished.cloud->empty() ? "has no points" : "none in the box";
    pane.setting = setting;
    pane.colored_by.reset();
    pane.frame = request.frame;
    return;
  }
  if (pane.setting != setting) {
    pane.setting.reset();
    pane.method = io::makeMethod(setting->method, setting->options);
    pane.setting = setting;
  }
  pane.frame.reset();
  const auto cloud = std::make_shared<Cloud>();
  pane.method->fuse(loaded_.rig, *cloud);
  pane.fused = {};
  pane.fused.setting = setting;
  pane.fused.cloud = cloud;
  pane.fused.statistics = pane.method->statistics();
  pane.fused.attributes.confidence_known = io::knowsConfidence(setting->method);
  pane.fused.attributes.views_known = io::countsViews(setting->method);
  if (cloud->empty())
    pane.fused.why_empty = io::whyEmpty(setting->method, setting->options, loaded_.rig, io::SettingNames::Sliders);
  pane.colored_by.reset();
  pane.frame = request.frame;
}

/** \brief Whether cameras that run have delivered nothing new. */
bool sameImages(const RigFrame& a, const RigFrame& b) {
  for (std::size_t i = 0; i < a.views.size() && i < b.views.size(); ++i)
    if (a.views[i].depth16.data != b.views[i].depth16.data || a.views[i].depth32.data != b.views[i].depth32.data)
      return false;
  return true;
}

/** \brief Whether the pane's last cloud is of the frame before, of the same cameras, and made in the same way. */
bool FrameFuser::canFlicker(const Pane& pane) const {
  return pane.before && pane.before->setting == pane.setting && before_frame_ && *before_frame_ + 1 == *loaded_frame_ &&
         !source_->isFinished() && before_.rig.cameras.size() == loaded_.rig.cameras.size() &&
         !sameImages(before_.rig, loaded_.rig);
}

void FrameFuser::measure(const FusionRequest& request, Pane& pane) {
  if (!request.measure_quality || pane.fused.quality) return;
  const io::MethodOptions& options = pane.setting->options;
  ReprojectionQualityParameters parameters;
  parameters.min_range = options.parameters.preprocessing.min_range;
  parameters.max_range = options.parameters.preprocessing.max_range;
  parameters.coverage_step = kCoverageStep;
  pane.fused.quality = reprojectionQuality(*pane.fused.cloud, loaded_.rig, parameters, options.threads);
  SurfaceQualityParameters surface;
  surface.min_range = parameters.min_range;
  surface.max_range = parameters.max_range;
  surface.coverage_step = kCoverageStep;
  surface.samples = kSurfaceSamples;
  pane.fused.surface = surfaceQuality(*pane.fused.cloud, loaded_.rig, surface, options.threads);
  if (canFlicker(pane))
    pane.fused.surface->flicker =
        temporalFlicker(*pane.before->cloud, before_.rig, *pane.fused.cloud, loaded_.rig, surface, options.threads);
  if (const simulation::RayScene* scene = truth())
    pane.fused.truth_distance = meanTruthDistance(*pane.fused.cloud, *scene, threadsOf(*pane.setting));
  pane.published.reset();
}

void FrameFuser::color(const FusionRequest& request, Pane& pane) {
  FusedCloud& fused = pane.fused;
  if (pane.colored_by == request.color_by) return;
  const int threads = threadsOf(*pane.setting);
  const bool by_normal = request.color_by == ColorBy::Normal;
  if ((by_normal || request.color_by == ColorBy::Camera) && fused.attributes.origins.empty())
    fused.attributes.origins = originsOf(*fused.cloud, loaded_.rig, threads);
  if (by_normal && fused.attributes.normals.empty())
    fused.attributes.normals = normalsOf(fused.attributes.origins, loaded_.rig, threads);
  if (request.color_by == ColorBy::TruthDistance && fused.attributes.truth_distances.empty())
    if (const simulation::RayScene* scene = truth())
      fused.attributes.truth_distances = truthDistances(*fused.cloud, *scene, threads);
  fused.slices = slicesOf(*fused.cloud, colorsOf(*fused.cloud, request.color_by, fused.attributes));
  pane.colored_by = request.color_by;
  pane.published.reset();
}

std::shared_ptr<const FusedFrame> FrameFuser::fuse(const FusionRequest& request, const std::atomic<bool>& stop) {
  const auto answer = std::make_shared<FusedFrame>();
  answer->number = request.number;
  answer->frame = request.frame;
  const auto failed = [&](const std::string& message) {
    answer->error = frameName(request.frame) + ": " + message;
    answer->clouds = {};
    return answer;
  };
  try {
    readFrame(request.frame);
  } catch (const std::exception& error) {
    return failed(error.what());
  }
  answer->thumbnails = thumbnails_;
  answer->read_ms = read_ms_;
  answer->color_by = request.color_by;
  answer->source_status = source_->status();
  for (const io::DamagedView& view : loaded_.damaged)
    answer->damaged.push_back("camera '" + loaded_.rig.cameras[view.view].name + "' is missing: " + view.message);
  for (const io::DamagedView& view : loaded_.ended) answer->ended.push_back(view.message);
  try {
    placeCameras(request);
    answer->cameras = loaded_.rig.cameras;
    answer->refined = refined_;
    for (std::size_t k = 0; k < kPanes; ++k) {
      Pane& pane = panes_[k];
      if (!request.settings[k]) continue;
      if (stop) return nullptr;
      fuseCloud(request, pane, request.settings[k]);
      if (stop) return nullptr;
      measure(request, pane);
      if (stop) return nullptr;
      color(request, pane);
      if (!pane.published) pane.published = std::make_shared<FusedCloud>(pane.fused);
      answer->clouds[k] = pane.published;
    }
    if (!truth_error_.empty()) answer->damaged.push_back("the truth is not known: " + truth_error_);
  } catch (const pcl::PCLException& error) {
    return failed(io::messageOf(error));
  } catch (const std::exception& error) {
    return failed(error.what());
  }
  return answer;
}

}  // namespace fuse_flow::viewing
