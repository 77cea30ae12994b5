#pragma once

#include "calibration/board_detector.h"
#include "calibration/grey.h"

#include <opencv2/core.hpp>

namespace fuse_flow::io {

/** \brief An image as OpenCV takes it. */
struct GreyImage {
  explicit GreyImage(const ColorImage& image)
      : bytes(toGrey(image)), view(image.height, image.width, CV_8UC1, bytes.data()) {}
  std::vector<std::uint8_t> bytes;
  cv::Mat view;  ///< of bytes
};

///@{
/** \brief For a board of this kind. */
std::unique_ptr<BoardDetector> makeChessboardDetector(const BoardKind& board);
std::unique_ptr<BoardDetector> makeArucoDetector(const BoardKind& board);
std::unique_ptr<BoardDetector> makeCharucoDetector(const BoardKind& board);
///@}

}  // namespace fuse_flow::io
