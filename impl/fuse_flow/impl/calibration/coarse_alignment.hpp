#pragma once

#include <fuse_flow/calibration/coarse_alignment.h>
#include <fuse_flow/impl/calibration/alignment_system.hpp>
#include <fuse_flow/impl/calibration/coarse/pose_hypotheses.hpp>
#include <fuse_flow/impl/calibration/coarse/rig_placement.hpp>
#include <fuse_flow/impl/calibration/coarse/surface_directions.hpp>
#include <fuse_flow/impl/parameters.hpp>

#include <pcl/exceptions.h>

#include <algorithm>

namespace fuse_flow {

FUSE_FLOW_INLINE void checkParameters(const CoarseAlignmentParameters& p) {
  constexpr const char* owner = "fuse_flow::CoarseAlignment";
  checkParameters(p.preprocessing);
  detail::checkNoise(owner, p.noise);
  detail::checkRange(owner, "samples", p.samples, 100, 1 << 20);
  detail::checkRange(owner, "cell_size", p.cell_size, 0.01f, 10.0f);
  detail::checkLength(owner, "tolerance", p.tolerance);
  detail::checkRange(owner, "max_roll", p.max_roll, 0.0f, 1e3f);
  detail::checkRange(owner, "hypotheses", p.hypotheses, 2, 1 << 10);
  detail::checkRange(owner, "min_score", p.min_score, 1e-3f, 99.99f);
  detail::checkRange(owner, "max_ambiguity", p.max_ambiguity, 1e-4f, 0.9999f);
}

FUSE_FLOW_INLINE bool CoarseAlignmentResult::complete() const {
  return std::all_of(groups.begin(), groups.end(), [](std::size_t group) { return group == 0; });
}

FUSE_FLOW_INLINE CoarseAlignment::CoarseAlignment() : system_(std::make_unique<host::AlignmentSystem>()) {}
FUSE_FLOW_INLINE CoarseAlignment::~CoarseAlignment() = default;

FUSE_FLOW_INLINE void CoarseAlignment::setParameters(const CoarseAlignmentParameters& parameters) {
  checkParameters(parameters);
  parameters_ = parameters;
}

FUSE_FLOW_INLINE const CoarseAlignmentParameters& CoarseAlignment::getParameters() const { return parameters_; }

FUSE_FLOW_INLINE void CoarseAlignment::setNumberOfThreads(unsigned int threads) {
  threads_ = static_cast<int>(threads);
}

FUSE_FLOW_INLINE void CoarseAlignment::clear() {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::CoarseAlignment");
  cameras_ = 0;
  system_->clear();
}

FUSE_FLOW_INLINE void CoarseAlignment::addFrame(const RigFrame& frame) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::CoarseAlignment");
  checkRigFrame(frame);
  if (system_->instants() > 0 && cameras_ != frame.cameras.size())
    detail::throwBadArgument("fuse_flow::CoarseAlignment: a frame of ", frame.cameras.size(), " cameras after one of ",
                             cameras_);
  cameras_ = frame.cameras.size();
  constexpr int wide_enough = 160;  // blocks in a row
  int width = wide_enough;
  for (const Camera& camera : frame.cameras) width = std::max(width, camera.intrinsics.width);
  ExtrinsicParameters p;
  p.preprocessing = parameters_.preprocessing;
  p.noise = parameters_.noise;
  p.reduction = std::min(width / wide_enough, 16);
  p.coarse_above = 1e6f;     // never: coarse as it is
  p.max_speckle = 0;         // what sticks out of blocks so wide is a hand, or a chair's leg
  p.residual_multipath = 0;  // centimetres make no difference yet
  p.use_color = parameters_.use_color;
  system_->setThreads(host::resolveThreads(threads_));
  system_->add(frame, p);
}

FUSE_FLOW_INLINE CoarseAlignmentResult CoarseAlignment::estimate() {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::CoarseAlignment");
  if (system_->instants() == 0) throw pcl::PCLException("fuse_flow::CoarseAlignment: no frame was added");
  const int threads = host::resolveThreads(threads_);
  system_->setThreads(threads);
  system_->sample(std::vector<Eigen::Isometry3d>(cameras_, Eigen::Isometry3d::Identity()), parameters_.samples);

  std::vector<std::vector<Eigen::Vector3d>> directions(cameras_);
  host::parallelFor(threads, cameras_, [&](std::size_t i, int) {
    if (!system_->view(0, i).missing()) directions[i] = host::SurfaceDirections(system_->view(0, i)).directions();
  });
  host::HypothesisTable table(cameras_);
  const host::PoseHypotheses hypotheses(*system_, parameters_);
  host::parallelFor(threads, cameras_ * cameras_, [&](std::size_t k, int) {
    const std::size_t i = k / cameras_, j = k % cameras_;
    if (i < j) table(i, j) = hypotheses.find(i, j, directions[i], directions[j]);
  });

  CoarseAlignmentResult result;
  result.T_world_camera.assign(cameras_, Eigen::Isometry3d::Identity());
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < cameras_; ++i) {
    result.placements.push_back(system_->samples(0, i).empty() ? Placement::Missing : Placement::Alone);
    result.groups.push_back(i);
    if (result.placements[i] == Placement::Alone) left.push_back(i);
  }
  const host::RigPlacement placement(*system_, parameters_, table);
  while (left.size() > 1) {
    host::PlacedGroup group = placement.place(left, threads);
    if (group.members.empty()) break;
    dropAmbiguous(placement, group, threads, result);
    if (group.members.size() < 2) {
      for (const std::size_t camera : group.members) result.placements[camera] = Placement::Ambiguous;
      break;
    }
    placement.polish(group);
    accept(placement, group, result);
    left.erase(std::remove_if(left.begin(), left.end(),
                              [&](std::size_t i) { return result.placements[i] == Placement::Placed; }),
               left.end());
  }
  return result;
}

FUSE_FLOW_INLINE void CoarseAlignment::dropAmbiguous(const host::RigPlacement& placement, host::PlacedGroup& group,
                                                     int threads, CoarseAlignmentResult& result) const {
  for (const std::size_t camera : group.contested) {
    result.placements[camera] = Placement::Ambiguous;
    group.members.erase(std::remove(group.members.begin(), group.members.end(), camera), group.members.end());
  }
  while (group.members.size() > 1) {
    std::vector<double> ambiguities(group.members.size());
    host::parallelFor(threads, group.members.size(),
                      [&](std::size_t k, int) { ambiguities[k] = placement.ambiguity(group, group.members[k]); });
    // Of two cameras that are ambiguous beside each other the later one goes.
    const auto worst = std::max_element(ambiguities.rbegin(), ambiguities.rend());
    if (*worst <= static_cast<double>(parameters_.max_ambiguity)) return;
    const auto member = group.members.begin() + (ambiguities.rend() - worst - 1);
    result.placements[*member] = Placement::Ambiguous;
    group.members.erase(member);
  }
}

FUSE_FLOW_INLINE void CoarseAlignment::accept(const host::RigPlacement& placement, const host::PlacedGroup& group,
                                              CoarseAlignmentResult& result) const {
  std::vector<std::size_t> members = group.members;
  std::sort(members.begin(), members.end());
  const std::size_t first = members.front();
  for (const std::size_t i : members) {
    result.T_world_camera[i] = group.poses[first].inverse() * group.poses[i];
    result.placements[i] = Placement::Placed;
    result.groups[i] = first;
    for (const std::size_t j : members) {
      if (j <= i) continue;
      const ViewAgreement agreement = placement.agreement(i, j, group.poses);
      if (agreement.score() > 0) result.overlaps.push_back({i, j, agreement});
    }
  }
}

}  // namespace fuse_flow
