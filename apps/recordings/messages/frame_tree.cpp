#include "recordings/messages/frame_tree.h"

namespace fuse_flow::io {

bool FrameTree::add(const TransformMessage& transform) {
  const auto [known, added] =
      parents_.emplace(transform.child, Parent{transform.header.frame, transform.T_parent_child});
  if (added && root(transform.child) == transform.child) {  // a loop has no top
    parents_.erase(known);
    return false;
  }
  constexpr double still = 1e-3;
  return !added &&
         (known->second.T_parent_child.matrix() - transform.T_parent_child.matrix()).cwiseAbs().maxCoeff() > still;
}

std::string FrameTree::root(const std::string& frame) const {
  std::string top = frame;
  for (std::size_t steps = 0; steps <= parents_.size(); ++steps) {
    const auto parent = parents_.find(top);
    if (parent == parents_.end()) return top;
    top = parent->second.name;
  }
  return frame;
}

Eigen::Isometry3d FrameTree::toRoot(const std::string& frame) const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (auto parent = parents_.find(frame); parent != parents_.end(); parent = parents_.find(parent->second.name))
    T = parent->second.T_parent_child * T;
  return T;
}

std::optional<Eigen::Isometry3d> FrameTree::between(const std::string& to, const std::string& from) const {
  if (root(to) != root(from)) return std::nullopt;
  return toRoot(to).inverse() * toRoot(from);
}

}  // namespace fuse_flow::io
