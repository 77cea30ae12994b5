#pragma once

#include <fuse_flow/calibration/extrinsic_tracking.h>
#include <fuse_flow/distributed/pose_message.h>

#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Poses, and what a search for them found, as a message carries them: every number as it is in memory. Every part is taken apart by
 *  name, so that one that is added later does not compile until it is here. */
class PoseMessages {
 public:
  static void put(MessageWriter& out, const std::vector<Eigen::Isometry3d>& poses) {
    for (const Eigen::Isometry3d& T : poses) PoseMessage::put(out, T);
  }
  /** \throws RankError for what is no pose, or of a place that no camera is at: sums of that would not be numbers */
  static std::vector<Eigen::Isometry3d> getPoses(MessageReader& in, std::size_t cameras) {
    constexpr double farthest = 1e15;  // metres: coordinates of maps are some 10⁷
    std::vector<Eigen::Isometry3d> poses(cameras);
    for (Eigen::Isometry3d& T : poses) {
      T = PoseMessage::get(in);
      const Eigen::Matrix3d R = T.linear();
      const bool turns = ((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().array() <= 1e-3).all();
      if (!turns || !(T.translation().cwiseAbs().array() <= farthest).all()) in.fail("a pose that cannot be");
    }
    return poses;
  }

  static void put(MessageWriter& out, const ExtrinsicResult& result) {
    const auto& [poses, corrections, overlaps, center, radius, before, after, iterations, converged] = result;
    put(out, poses);
    for (const CameraCorrection& correction : corrections) put(out, correction);
    putCount(out, overlaps.size());
    for (const CameraOverlap& overlap : overlaps) {
      const auto& [first, second, correspondences, residual_before, residual] = overlap;
      putCount(out, first);
      putCount(out, second);
      putCount(out, correspondences);
      out.put(residual_before);
      out.put(residual);
    }
    for (int k = 0; k < 3; ++k) out.put(center[k]);
    for (const double value : {radius, before, after}) out.put(value);
    out.put(static_cast<std::int32_t>(iterations));
    out.put(static_cast<std::uint8_t>(converged));
  }
  /** \param cameras how many the rig has  \throws RankError for what cannot be */
  static ExtrinsicResult getResult(MessageReader& in, std::size_t cameras) {
    ExtrinsicResult result;
    auto& [poses, corrections, overlaps, center, radius, before, after, iterations, converged] = result;
    poses = getPoses(in, cameras);
    for (std::size_t i = 0; i < cameras; ++i) corrections.push_back(getCorrection(in));
    const std::uint64_t count = in.get<std::uint64_t>();
    if (count > cameras * cameras) in.fail("more overlaps than the rig has pairs of cameras");
    for (std::uint64_t k = 0; k < count; ++k) {
      CameraOverlap overlap;
      auto& [first, second, correspondences, residual_before, residual] = overlap;
      first = getCount(in);
      second = getCount(in);
      correspondences = getCount(in);
      residual_before = in.get<double>();
      residual = in.get<double>();
      if (first >= cameras || second >= cameras) in.fail("an overlap of a camera that the rig does not have");
      overlaps.push_back(overlap);
    }
    for (int k = 0; k < 3; ++k) center[k] = in.get<double>();
    for (double* value : {&radius, &before, &after}) *value = in.get<double>();
    iterations = in.get<std::int32_t>();
    converged = in.get<std::uint8_t>() != 0;
    return result;
  }

  static void put(MessageWriter& out, const TrackedPoses& tracked) {
    const auto& [poses, stamp, updates, moved, milliseconds] = tracked;
    put(out, poses);
    out.put(stamp);
    putCount(out, updates);
    putCount(out, moved.size());
    for (const CameraMotion& motion : moved) {
      const auto& [camera, T, translation, rotation] = motion;
      putCount(out, camera);
      PoseMessage::put(out, T);
      out.put(translation);
      out.put(rotation);
    }
    out.put(milliseconds);
  }
  /** \param cameras how many the rig has  \throws RankError for what cannot be */
  static TrackedPoses getTracked(MessageReader& in, std::size_t cameras) {
    TrackedPoses tracked;
    auto& [poses, stamp, updates, moved, milliseconds] = tracked;
    poses = getPoses(in, cameras);
    stamp = in.get<std::uint64_t>();
    updates = getCount(in);
    const std::uint64_t count = in.get<std::uint64_t>();
    if (count > cameras) in.fail("more moved cameras than the rig has");
    for (std::uint64_t k = 0; k < count; ++k) {
      CameraMotion motion;
      auto& [camera, T, translation, rotation] = motion;
      camera = getCount(in);
      T = PoseMessage::get(in);
      translation = in.get<double>();
      rotation = in.get<double>();
      if (camera >= cameras) in.fail("a motion of a camera that the rig does not have");
      moved.push_back(motion);
    }
    milliseconds = in.get<double>();
    return tracked;
  }

 private:
  static void putCount(MessageWriter& out, std::size_t count) { out.put(static_cast<std::uint64_t>(count)); }
  static std::size_t getCount(MessageReader& in) { return static_cast<std::size_t>(in.get<std::uint64_t>()); }

  static void put(MessageWriter& out, const CameraCorrection& correction) {
    const auto& [T, translation, rotation, translation_deviation, rotation_deviation, covariance, neighbours,
                 constrained, free_directions] = correction;
    PoseMessage::put(out, T);
    for (const double value : {translation, rotation, translation_deviation, rotation_deviation}) out.put(value);
    out.put(covariance.data(), 36);
    putCount(out, neighbours);
    out.put(static_cast<std::uint8_t>(constrained));
    out.put(static_cast<std::uint8_t>(free_directions.size()));
    for (const auto& direction : free_directions) out.put(direction.data(), 6);
  }
  static CameraCorrection getCorrection(MessageReader& in) {
    CameraCorrection correction;
    auto& [T, translation, rotation, translation_deviation, rotation_deviation, covariance, neighbours, constrained,
           free_directions] = correction;
    T = PoseMessage::get(in);
    for (double* value : {&translation, &rotation, &translation_deviation, &rotation_deviation})
      *value = in.get<double>();
    in.get(covariance.data(), 36);
    neighbours = getCount(in);
    constrained = in.get<std::uint8_t>() != 0;
    free_directions.resize(in.get<std::uint8_t>());
    for (auto& direction : free_directions) in.get(direction.data(), 6);
    return correction;
  }
};

}  // namespace distributed
}  // namespace fuse_flow
