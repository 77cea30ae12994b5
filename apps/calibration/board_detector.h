#pragma once

#include "calibration/board_kind.h"
#include "calibration/marker_detector.h"
#include "calibration/marker_rig.h"

#include <fuse_flow/recordings/image.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief What one image shows of a marker or a board. */
struct DetectedBoard {
  int id{0};                        ///< of a marker; 0 for a board
  std::vector<MarkerPoint> points;  ///< that are seen
  MarkerPoint middle;               ///< of what is seen, apart from edges: where depth can be looked up
};

/** \brief Finds one kind of board in images. */
class BoardDetector {
 public:
  virtual ~BoardDetector() = default;
  virtual std::vector<DetectedBoard> detect(const ColorImage& image) = 0;
  /** \brief What the images so far suggest about why the board was not found in more of them; one line, mostly empty. */
  virtual std::string advice() const { return ""; }
};

/** \brief For a board that checkBoard() accepts. Throws OptionError, beginning with --board, if this build has no library for it. */
std::unique_ptr<BoardDetector> makeBoardDetector(const BoardKind& board);

///@{
/** \brief Of those that OpenCV finds; for makeBoardDetector(). */
std::unique_ptr<BoardDetector> makeOpenCvDetector(const BoardKind& board);
bool openCvAvailable();
///@}

/** \brief One whole square marker of a side, metres. */
DetectedBoard squareBoard(const DetectedMarker& marker, double side);

/** \brief The inner corners of a chessboard that are seen, row by row, as a board whose origin is its middle. Nothing unless it shows
 *  the four corners of one square at least, as fewer may be on one line. */
std::optional<DetectedBoard> cornerBoard(int columns, int rows, double side,
                                         const std::vector<std::optional<Pixel>>& corners);

/** \brief Where the diagonals cross: the middle of the square, seen from anywhere. */
Pixel crossingOfDiagonals(const std::array<Pixel, 4>& corners);

}  // namespace fuse_flow::io
