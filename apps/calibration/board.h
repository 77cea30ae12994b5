#pragma once

#include "calibration/marker_detector.h"
#include "calibration/marker_rig.h"

#include <fuse_flow/recordings/recording.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A marker, or a board of several, that someone shows to the cameras of a rig: where its calibration begins. At every
 *  instant it may be held elsewhere. */
class Board {
 public:
  /** \param side of the black square of each marker, metres  \param family of MarkerDetector. Throws what that throws. */
  Board(double side, const std::string& family) : detector_(family), side_(side) {}

  /** \brief One instant more; its colour images must have been read. */
  void addFrame(const LoadedFrame& frame);

  /** \brief The rig in the world in which its first camera stands where it is said to. Throws InputError, naming the cameras,
   *  unless markers connect all of them, and if they contradict each other or depth. */
  MarkerRig place(const std::vector<Camera>& cameras) const;

 private:
  MarkerDetector detector_;
  double side_;
  std::size_t frames_{0};
  bool color_{false};
  std::vector<MarkerSighting> sightings_;
};

}  // namespace fuse_flow::io
