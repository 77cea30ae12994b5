#pragma once

#include <fuse_flow/recordings/recording.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Tells a camera that missed a frame from a recording that has been deleted, moved or unmounted while it is read: then all
 *  that is left to read is missing, too. */
class StillThere {
 public:
  explicit StillThere(const Recording& recording);

  /** \brief Throws InputError if a view is missing and a folder that was there at first is not. */
  void check(const LoadedFrame& frame) const;

 private:
  std::vector<std::string> folders_;
};

}  // namespace fuse_flow::io
