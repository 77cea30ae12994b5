#pragma once

#include <fuse_flow/distributed/message.h>

#include <Eigen/Geometry>

namespace fuse_flow {
namespace distributed {

/** \brief A pose as a message carries it: the upper three rows, every number as it is in memory. */
struct PoseMessage {
  static void put(MessageWriter& out, const Eigen::Isometry3d& T) {
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) out.put(T.matrix()(row, column));
  }
  static Eigen::Isometry3d get(MessageReader& in) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) T.matrix()(row, column) = in.get<double>();
    return T;
  }
};

}  // namespace distributed
}  // namespace fuse_flow
