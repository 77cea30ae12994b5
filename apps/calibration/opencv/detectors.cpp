#include "calibration/opencv/detectors.h"

#include <opencv2/core/utility.hpp>

namespace fuse_flow::io {

std::unique_ptr<BoardDetector> makeOpenCvDetector(const BoardKind& board) {
  cv::setNumThreads(1);  // the same bytes for any number of them
  if (board.kind == "chessboard") return makeChessboardDetector(board);
  if (board.kind == "charuco") return makeCharucoDetector(board);
  return makeArucoDetector(board);
}

bool openCvAvailable() { return true; }

}  // namespace fuse_flow::io
