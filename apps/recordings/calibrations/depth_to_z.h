#pragma once

#include <fuse_flow/recordings/recording.h>

#include <memory>
#include <mutex>
#include <vector>

namespace fuse_flow::io {

/** \brief Makes z of a camera's depth images, whatever they mean. Many threads may use one object. */
class DepthToZ {
 public:
  DepthToZ(const Camera& camera, const DepthMeaning& meaning);

  /** \brief Depth becomes z in metres, in depth32; nothing changes if it is z, or missing. \param view of these images, which must be of the
   *  camera's size */
  void convert(LoadedView& images, DepthView& view) const;

 private:
  /** \brief A table for each pixel. Not before there is an image: a file may name a size of which none follows. */
  struct Table {
    std::once_flag made;
    std::vector<float> z_per_distance;
  };
  const std::vector<float>& table() const;

  DepthMeaning meaning_;
  float depth_scale_;
  Intrinsics intrinsics_;
  std::unique_ptr<Table> table_{std::make_unique<Table>()};
};

}  // namespace fuse_flow::io
