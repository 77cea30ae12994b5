#include "calibration/opencv/aruco_markers.h"
#include "calibration/opencv/detectors.h"

namespace fuse_flow::io {
namespace {

/** \brief ArUco markers, each by itself. */
class ArucoDetector : public BoardDetector {
 public:
  explicit ArucoDetector(const BoardKind& board) : markers_(board.family), side_(board.side) {}
  std::vector<DetectedBoard> detect(const ColorImage& image) override {
    std::vector<DetectedBoard> found;
    if (image.empty()) return found;
    for (const DetectedMarker& marker : markers_.detectWithEdges(GreyImage(image).view))
      found.push_back(squareBoard(marker, side_));
    return found;
  }

 private:
  ArucoMarkers markers_;
  double side_;
};

/** \brief ArUco markers in rows and columns, their numbers row by row from the upper left. */
class GridDetector : public BoardDetector {
 public:
  explicit GridDetector(const BoardKind& board) : markers_(board.family), board_(board) {}
  std::vector<DetectedBoard> detect(const ColorImage& image) override {
    if (image.empty()) return {};
    DetectedBoard found;
    for (const DetectedMarker& marker : markers_.detectWithEdges(GreyImage(image).view)) {
      if (marker.id >= board_.columns * board_.rows) continue;  // not of this board
      const double pitch = board_.side + board_.gap;
      const int column = marker.id % board_.columns, row = marker.id / board_.columns;
      const Eigen::Vector2d at(pitch * (column - 0.5 * (board_.columns - 1)), pitch * (row - 0.5 * (board_.rows - 1)));
      if (found.points.empty()) found.middle = {at, crossingOfDiagonals(marker.corners)};
      for (MarkerPoint point : squarePoints(board_.side, marker.corners)) {
        point.place += at;
        found.points.push_back(point);
      }
    }
    if (found.points.empty()) return {};
    return {found};
  }

 private:
  ArucoMarkers markers_;
  BoardKind board_;
};

}  // namespace

std::unique_ptr<BoardDetector> makeArucoDetector(const BoardKind& board) {
  if (board.kind == "aruco-grid") return std::make_unique<GridDetector>(board);
  return std::make_unique<ArucoDetector>(board);
}

}  // namespace fuse_flow::io
