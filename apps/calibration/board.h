#pragma once

#include "calibration/board_detector.h"
#include "calibration/marker_rig.h"

#include <fuse_flow/recordings/recording.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Markers, or a board, that someone shows to the cameras of a rig: where its calibration begins. At every instant it may be
 *  held elsewhere. */
class Board {
 public:
  /** \brief Throws OptionError, naming the option, unless the kind is complete and this build can find it. */
  explicit Board(const BoardKind& kind);

  /** \brief One instant more; its colour images must have been read. */
  void addFrame(const LoadedFrame& frame);

  /** \brief The rig in the world in which its first camera stands where it is said to. Throws InputError, naming the cameras,
   *  unless markers connect all of them, and if they contradict each other or depth. */
  MarkerRig place(const std::vector<Camera>& cameras) const;

  /** \brief What was found, and what was taken for granted or left out, for the user; lines. */
  std::string summary(const MarkerRig& rig) const;

 private:
  /** \brief Whether all markers are one rigid board. */
  bool isOne() const { return kind_.kind != "markers"; }

  BoardKind kind_;
  std::unique_ptr<BoardDetector> detector_;
  std::size_t frames_{0};
  bool color_{false};
  std::vector<MarkerSighting> sightings_;
};

}  // namespace fuse_flow::io
