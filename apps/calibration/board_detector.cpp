#include "calibration/board_detector.h"

#include <limits>

namespace fuse_flow::io {
namespace {

/** \brief AprilTags, each by itself. */
class TagDetector : public BoardDetector {
 public:
  TagDetector(const std::string& family, double side) : detector_(family), side_(side) {}
  std::vector<DetectedBoard> detect(const ColorImage& image) override {
    std::vector<DetectedBoard> found;
    for (const DetectedMarker& marker : detector_.detect(image)) found.push_back(squareBoard(marker, side_));
    return found;
  }

 private:
  MarkerDetector detector_;
  double side_;
};

}  // namespace

Pixel crossingOfDiagonals(const std::array<Pixel, 4>& c) {
  const float ax = c[2].u - c[0].u, ay = c[2].v - c[0].v, bx = c[3].u - c[1].u, by = c[3].v - c[1].v;
  const float determinant = ax * by - ay * bx;
  const float t = ((c[1].u - c[0].u) * by - (c[1].v - c[0].v) * bx) / determinant;
  return {c[0].u + t * ax, c[0].v + t * ay};
}

DetectedBoard squareBoard(const DetectedMarker& marker, double side) {
  return {marker.id, squarePoints(side, marker.corners), {{0, 0}, crossingOfDiagonals(marker.corners)}};
}

std::optional<DetectedBoard> cornerBoard(int columns, int rows, double side,
                                         const std::vector<std::optional<Pixel>>& corners) {
  const auto corner = [&](int column, int row) -> const std::optional<Pixel>& {
    return corners[static_cast<std::size_t>(row * columns + column)];
  };
  const auto place = [&](double column, double row) {
    return Eigen::Vector2d(side * (column - 0.5 * (columns - 1)), side * (row - 0.5 * (rows - 1)));
  };
  DetectedBoard board;
  Eigen::Vector2d sum(0, 0);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      if (corner(column, row)) {
        board.points.push_back({place(column, row), *corner(column, row)});
        sum += board.points.back().place;
      }
  if (board.points.empty()) return std::nullopt;
  const Eigen::Vector2d mean = sum / static_cast<double>(board.points.size());
  double nearest = std::numeric_limits<double>::infinity();
  for (int row = 0; row + 1 < rows; ++row)
    for (int column = 0; column + 1 < columns; ++column) {
      const std::optional<Pixel>&a = corner(column, row + 1), &b = corner(column + 1, row + 1),
            &c = corner(column + 1, row), &d = corner(column, row);
      const Eigen::Vector2d middle = place(column + 0.5, row + 0.5);
      if (!a || !b || !c || !d || !((middle - mean).norm() < nearest)) continue;
      nearest = (middle - mean).norm();
      board.middle = {middle, crossingOfDiagonals({*a, *b, *c, *d})};
    }
  if (!(nearest < std::numeric_limits<double>::infinity())) return std::nullopt;
  return board;
}

std::unique_ptr<BoardDetector> makeBoardDetector(const BoardKind& board) {
  if (needsOpenCv(board)) return makeOpenCvDetector(board);
  return std::make_unique<TagDetector>(board.family.empty() ? "tag36h11" : board.family, board.side);
}

}  // namespace fuse_flow::io
