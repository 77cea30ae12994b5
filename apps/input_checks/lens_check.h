#pragma once

#include <fuse_flow/rig_frame.h>

#include <cstddef>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Finds cameras whose lens model has no ray for pixels that measure something, or for pixels of their own colour camera: it folds over
 *  before it reaches them. Most often its coefficients are of another lens, or of another model. */
class LensCheck {
 public:
  /** \brief Looks at each camera's first image. */
  void look(const RigFrame& frame);

  /** \brief A line for each such camera. */
  std::vector<std::string> complaints() const;

 private:
  struct Seen {
    std::string name;
    bool done{false}, color_done{false};
    std::size_t measured{0};      ///< pixels
    std::size_t without_ray{0};   ///< of those
    double color_without_ray{0};  ///< share of the pixels of the colour camera
  };
  std::vector<Seen> cameras_;
};

}  // namespace fuse_flow::io
