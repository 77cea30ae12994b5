// In place of the folder opencv where OpenCV is not there.

#include "calibration/board_detector.h"

#include <fuse_flow/recordings/error.h>

namespace fuse_flow::io {

std::unique_ptr<BoardDetector> makeOpenCvDetector(const BoardKind& board) {
  const std::string what = board.kind == "markers" ? "--board-family " + board.family : "--board-kind " + board.kind;
  throw OptionError("--board with " + what +
                    ": this build cannot find it; install OpenCV, libopencv-contrib-dev, and build again");
}

bool openCvAvailable() { return false; }

}  // namespace fuse_flow::io
