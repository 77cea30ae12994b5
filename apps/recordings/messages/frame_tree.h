#pragma once

#include "recordings/messages/ros_messages.h"

#include <map>
#include <optional>
#include <string>

namespace fuse_flow::io {

/** \brief The coordinate frames that tf connects. */
class FrameTree {
 public:
  /** \brief A frame that has a parent already keeps it. \returns whether it moves: it was placed otherwise by more than 1 mm or 0.001 before */
  bool add(const TransformMessage& transform);

  /** \brief The frame at the top of a frame's tree; the frame itself, if it has no parent. */
  std::string root(const std::string& frame) const;
  /** \brief From the frame to the top of its tree. */
  Eigen::Isometry3d toRoot(const std::string& frame) const;
  /** \brief Absent: they are in different trees. */
  std::optional<Eigen::Isometry3d> between(const std::string& to, const std::string& from) const;
  /** \brief Empty: it has none. */
  std::string parent(const std::string& frame) const { return has(frame) ? parents_.at(frame).name : ""; }
  bool has(const std::string& frame) const { return parents_.count(frame) > 0; }

 private:
  struct Parent {
    std::string name;
    Eigen::Isometry3d T_parent_child;
  };
  std::map<std::string, Parent> parents_;
};

}  // namespace fuse_flow::io
