#include "calibration/opencv/aruco_markers.h"
#include "calibration/opencv/detectors.h"

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <map>

namespace fuse_flow::io {
namespace {

/** \brief A plane's points to those of another one, by four of them. */
Eigen::Matrix3d homographyOf(const std::vector<MarkerPoint>& points) {
  Eigen::Matrix<double, 8, 8> A;
  Eigen::Matrix<double, 8, 1> b;
  for (int k = 0; k < 4; ++k) {
    const MarkerPoint& p = points[static_cast<std::size_t>(k)];
    const double x = p.place.x(), y = p.place.y();
    const double u = static_cast<double>(p.pixel.u), v = static_cast<double>(p.pixel.v);
    A.row(2 * k) << x, y, 1, 0, 0, 0, -u * x, -u * y;
    A.row(2 * k + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y;
    b.segment<2>(2 * k) << u, v;
  }
  const Eigen::Matrix<double, 8, 1> h = A.partialPivLu().solve(b);
  Eigen::Matrix3d H;
  H << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
  return H;
}

/** \brief A marker of the board as an image shows it. In squares, from the middle of the one that it fills. */
struct Cell {
  Eigen::Matrix3d H;  ///< to pixels
  Eigen::Vector2d at(double x, double y) const { return (H * Eigen::Vector3d(x, y, 1)).hnormalized(); }
};

/** \brief Which white square each marker is in, row by row from the upper left. */
std::map<std::pair<int, int>, int> markersOf(const BoardKind& board, bool legacy) {
  std::map<std::pair<int, int>, int> ids;
  int id = 0;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) {
      // Before 4.6 OpenCV counted rows from below when it chose which squares are black.
      const int counted = legacy ? board.rows - 1 - row : row;
      if ((counted + column) % 2 != 0) ids[{column, row}] = id++;
    }
  return ids;
}

class CharucoDetector : public BoardDetector {
 public:
  explicit CharucoDetector(const BoardKind& board)
      : markers_(board.family),
        board_(board),
        ids_(markersOf(board, board.legacy)),
        other_ids_(markersOf(board, !board.legacy)) {}

  std::vector<DetectedBoard> detect(const ColorImage& image) override {
    if (image.empty()) return {};
    const GreyImage grey(image);
    std::map<int, Cell> cells;
    for (const DetectedMarker& marker : markers_.detect(grey.view))
      cells[marker.id] = {homographyOf(squarePoints(board_.marker / board_.side, marker.corners))};
    std::vector<std::optional<Pixel>> corners;
    std::size_t agree = 0, agree_by_other = 0;
    for (int row = 1; row < board_.rows; ++row)
      for (int column = 1; column < board_.columns; ++column) {
        corners.push_back(cornerAt(grey.view, cells, ids_, column, row));
        agree += predict(cells, ids_, column, row) ? 1 : 0;
        agree_by_other += predict(cells, other_ids_, column, row) ? 1 : 0;
      }
    // Of the wrong pattern most markers contradict each other, or, where columns are odd, those of one column.
    if (agree_by_other > agree) {
      ++other_pattern_;
      return {};
    }
    std::optional<DetectedBoard> found = cornerBoard(board_.columns - 1, board_.rows - 1, board_.side, corners);
    if (!found) return {};
    return {*found};
  }

  std::string advice() const override {
    if (other_pattern_ == 0) return "";
    return std::to_string(other_pattern_) + " images show a board whose upper left square is " +
           (board_.legacy ? "black: leave out --board-legacy"
                          : "white, as OpenCV drew them before 4.6: add --board-legacy");
  }

 private:
  /** \brief Where an inner corner should be, by the markers of the two white squares that meet there. */
  struct Prediction {
    Eigen::Vector2d pixel;
    double gap;                 ///< from the corner to the nearer marker along a side of the square, pixels
    Eigen::Vector2d beside[4];  ///< half of that away, in the two white squares and then in the two black ones
  };

  std::optional<Prediction> predict(const std::map<int, Cell>& cells, const std::map<std::pair<int, int>, int>& ids,
                                    int column, int row) const {
    // The white squares are those upper left and lower right of the corner, or the other two.
    const bool falling = ids.count({column - 1, row - 1}) == 1;
    const int left_row = falling ? row - 1 : row, right_row = falling ? row : row - 1;
    const auto left = cells.find(ids.at({column - 1, left_row})), right = cells.find(ids.at({column, right_row}));
    if (left == cells.end() || right == cells.end()) return std::nullopt;
    const double y = falling ? 0.5 : -0.5, share = 0.5 * board_.marker / board_.side, side = falling ? 1 : -1;
    const Eigen::Vector2d a = left->second.at(0.5, y), b = right->second.at(-0.5, -y);
    const Eigen::Vector2d from_a = left->second.at(share, side * share);
    const Eigen::Vector2d from_b = right->second.at(-share, -side * share);
    Prediction result;
    result.pixel = 0.5 * (a + b);
    result.gap = std::min((a - from_a).norm(), (b - from_b).norm()) / std::sqrt(2.0);
    const double half = 0.5 * (0.5 - share);
    result.beside[0] = left->second.at(0.5 - half, side * (0.5 - half));
    result.beside[1] = right->second.at(-0.5 + half, -side * (0.5 - half));
    result.beside[2] = left->second.at(0.5 - half, side * (0.5 + half));
    result.beside[3] = left->second.at(0.5 + half, side * (0.5 - half));
    // Markers of another board, or of the other pattern, disagree by squares.
    const double square = (left->second.at(0.5, 0) - left->second.at(-0.5, 0)).norm();
    if (!((a - b).norm() < 0.25 * square)) return std::nullopt;
    return result;
  }

  std::optional<Pixel> cornerAt(const cv::Mat& grey, const std::map<int, Cell>& cells,
                                const std::map<std::pair<int, int>, int>& ids, int column, int row) const {
    const std::optional<Prediction> predicted = predict(cells, ids, column, row);
    if (!predicted || predicted->gap < kLeastGap) return std::nullopt;
    const int half = std::clamp(static_cast<int>(predicted->gap), 2, 8);
    const cv::Point2f begin(static_cast<float>(predicted->pixel.x()), static_cast<float>(predicted->pixel.y()));
    const float border = static_cast<float>(half + 1);
    if (!(begin.x >= border && begin.y >= border && begin.x < static_cast<float>(grey.cols) - border &&
          begin.y < static_cast<float>(grey.rows) - border) ||
        !isCorner(grey, *predicted))
      return std::nullopt;
    std::vector<cv::Point2f> corner{begin};
    cv::cornerSubPix(grey, corner, {half, half}, {-1, -1},
                     {cv::TermCriteria::EPS + cv::TermCriteria::MAX_ITER, 50, 1e-3});
    if (!(std::hypot(corner[0].x - begin.x, corner[0].y - begin.y) < static_cast<float>(half))) return std::nullopt;
    return Pixel{corner[0].x, corner[0].y};
  }

  /** \brief Whether its two white squares are white there, and the black ones black: a hand may hide the corner, and no marker. */
  static bool isCorner(const cv::Mat& grey, const Prediction& predicted) {
    int brightness[4];
    for (int k = 0; k < 4; ++k) {
      const long u = std::lround(predicted.beside[k].x()), v = std::lround(predicted.beside[k].y());
      if (u < 0 || v < 0 || u >= grey.cols || v >= grey.rows) return false;
      brightness[k] = grey.at<unsigned char>(static_cast<int>(v), static_cast<int>(u));
    }
    return std::min(brightness[0], brightness[1]) > std::max(brightness[2], brightness[3]) + kLeastContrast;
  }

  /** \brief Pixels between a corner and a marker, below which the search for the corner takes the marker's edge in. */
  static constexpr double kLeastGap = 2;
  /** \brief Of 255. */
  static constexpr int kLeastContrast = 8;

  ArucoMarkers markers_;
  BoardKind board_;
  std::map<std::pair<int, int>, int> ids_, other_ids_;  ///< by column and row
  std::size_t other_pattern_{0};                        ///< images that show a board of the other pattern
};

}  // namespace

std::unique_ptr<BoardDetector> makeCharucoDetector(const BoardKind& board) {
  return std::make_unique<CharucoDetector>(board);
}

}  // namespace fuse_flow::io
