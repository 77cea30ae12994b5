#pragma once

#include <fuse_flow/impl/fusion/cell_confirmations.hpp>
#include <fuse_flow/impl/fusion/cell_normals.hpp>
#include <fuse_flow/impl/fusion/cell_opinions.hpp>
#include <fuse_flow/impl/fusion/cell_points.hpp>
#include <fuse_flow/impl/fusion/child_bits.hpp>
#include <fuse_flow/math/representatives.h>

#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief A child of a coarse cell while its points are collected. */
struct Child {
  RepresentativeSelection chosen;
  std::uint32_t position;

  explicit Child(std::uint32_t where) : position(where) {}
};

/** \brief A fused point that stays only where nothing better does. */
struct WeakPoint {
  float weight;
  std::uint32_t position;  ///< of its child
  std::uint32_t number;
};

/** \brief Per-thread memory of fuseCell(); kept from frame to frame. */
struct CellScratch {
  CellPoints points;
  std::vector<std::uint32_t> slot;  // child position → 1 + number of the child
  std::vector<Child> children;
  std::vector<Vec3> judged;  // where V is measured, child after child
  std::vector<std::uint32_t> judged_camera;
  CellNormals normals;  // of each of these
  CellOpinions opinions;
  CellConfirmations confirmations;
  std::vector<float> V;
  std::vector<FusedPoint> fused;
  std::vector<float> omega;  // of each fused point, before one V of the child's has multiplied it
  std::vector<std::uint8_t> kept;
  std::vector<WeakPoint> weak;
  ChildBits occupied;  // by points that stay
  std::vector<FusedPoint> output;
  std::vector<std::uint64_t> output_cameras;  // PointCameras::mask() of each
};

}  // namespace host
}  // namespace fuse_flow
