#include "calibration/opencv/detectors.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace fuse_flow::io {
namespace {

/** \brief Least difference of bright and dark squares, of 255. */
constexpr double kLeastDifference = 8;

class ChessboardDetector : public BoardDetector {
 public:
  explicit ChessboardDetector(const BoardKind& board) : columns_(board.columns), rows_(board.rows), side_(board.side) {}

  std::vector<DetectedBoard> detect(const ColorImage& image) override {
    if (image.empty()) return {};
    const GreyImage grey(image);
    std::vector<cv::Point2f> corners;
    // Not exhaustive: of an image without a chessboard that would take minutes.
    constexpr int flags = cv::CALIB_CB_NORMALIZE_IMAGE;
    if (!cv::findChessboardCornersSB(grey.view, {columns_, rows_}, corners, flags)) return {};
    if (static_cast<int>(corners.size()) != columns_ * rows_ || !bringIntoOrder(grey.view, corners)) return {};
    // Three times as exact as what the first search says.
    const int half = std::clamp(static_cast<int>(0.35 * leastDistance(corners)), 2, 10);
    cv::cornerSubPix(grey.view, corners, {half, half}, {-1, -1},
                     {cv::TermCriteria::EPS + cv::TermCriteria::MAX_ITER, 50, 1e-3});
    std::vector<std::optional<Pixel>> pixels;
    for (const cv::Point2f& p : corners) pixels.emplace_back(Pixel{p.x, p.y});
    return {*cornerBoard(columns_, rows_, side_, pixels)};
  }

  std::string advice() const override {
    return "a chessboard must be seen whole by two cameras at once, and --board-size counts its inner corners, one "
           "less each way than squares; a ChArUco board (--board-kind charuco) may be hidden in part";
  }

 private:
  /** \brief Of neighbours in a row or a column, pixels. */
  double leastDistance(const std::vector<cv::Point2f>& corners) const {
    double least = 1e9;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const auto columns = static_cast<std::size_t>(columns_);
      if (k % columns > 0) least = std::min(least, cv::norm(corners[k] - corners[k - 1]));
      if (k >= columns) least = std::min(least, cv::norm(corners[k] - corners[k - columns]));
    }
    return least;
  }

  /** \brief Row by row, seen from the front, the square right of and below the first corner a dark one: so that all cameras call the
   *  same corner the first one, however the board is turned. False if the squares tell no order. */
  bool bringIntoOrder(const cv::Mat& grey, std::vector<cv::Point2f>& corners) const {
    const auto at = [&](int column, int row) { return corners[static_cast<std::size_t>(row * columns_ + column)]; };
    const cv::Point2f right = at(columns_ - 1, 0) - at(0, 0), down = at(0, rows_ - 1) - at(0, 0);
    if (right.x * down.y - right.y * down.x < 0)  // seen from behind
      for (int row = 0; row < rows_; ++row)
        std::reverse(corners.begin() + row * columns_, corners.begin() + (row + 1) * columns_);
    double sum[2] = {0, 0};
    int count[2] = {0, 0};
    for (int row = 0; row + 1 < rows_; ++row)
      for (int column = 0; column + 1 < columns_; ++column) {
        const cv::Point2f middle =
            0.25f * (at(column, row) + at(column + 1, row) + at(column, row + 1) + at(column + 1, row + 1));
        const int u = static_cast<int>(std::lround(middle.x)), v = static_cast<int>(std::lround(middle.y));
        if (u < 0 || v < 0 || u >= grey.cols || v >= grey.rows) continue;
        sum[(column + row) % 2] += grey.at<unsigned char>(v, u);
        ++count[(column + row) % 2];
      }
    if (count[0] == 0 || count[1] == 0) return false;
    const double brighter = sum[0] / count[0] - sum[1] / count[1];
    if (std::fabs(brighter) < kLeastDifference) return false;
    if (brighter > 0) std::reverse(corners.begin(), corners.end());  // half a turn
    return true;
  }

  int columns_, rows_;
  double side_;
};

}  // namespace

std::unique_ptr<BoardDetector> makeChessboardDetector(const BoardKind& board) {
  return std::make_unique<ChessboardDetector>(board);
}

}  // namespace fuse_flow::io
