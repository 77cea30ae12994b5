#include "calibration/board_detector.h"

#include "../recordings/io_fixture.h"
#include "board_picture.h"

#include <algorithm>
#include <cmath>

namespace {

using namespace io_test;
using board_test::Eye;
using board_test::Print;
using io::BoardKind;
using io::DetectedBoard;

/** \brief Corners of a board that an image shows where it should, but for some. */
std::vector<std::optional<Pixel>> cornersOf(int columns, int rows, const std::vector<int>& missing) {
  std::vector<std::optional<Pixel>> corners;
  for (int k = 0; k < columns * rows; ++k) {
    corners.emplace_back(
        Pixel{100.0f + 10.0f * static_cast<float>(k % columns), 50.0f + 10.0f * static_cast<float>(k / columns)});
    if (std::count(missing.begin(), missing.end(), k)) corners.back().reset();
  }
  return corners;
}

TEST(CornerBoard, ItsOriginIsItsMiddleWhateverIsHidden) {
  for (const std::vector<int>& missing : {std::vector<int>{}, std::vector<int>{0, 1, 5}}) {
    const auto board = io::cornerBoard(4, 3, 0.1, cornersOf(4, 3, missing));
    ASSERT_TRUE(board);
    EXPECT_EQ(board->points.size(), 12 - missing.size());
    for (const io::MarkerPoint& point : board->points) {
      EXPECT_NEAR(point.place.x(), 0.01 * (static_cast<double>(point.pixel.u) - 115), 1e-9);
      EXPECT_NEAR(point.place.y(), 0.01 * (static_cast<double>(point.pixel.v) - 60), 1e-9);
    }
  }
}

TEST(CornerBoard, DepthIsLookedUpInTheMiddleOfASquareThatIsSeen) {
  const auto whole = io::cornerBoard(4, 4, 0.1, cornersOf(4, 4, {}));
  ASSERT_TRUE(whole);
  EXPECT_NEAR(whole->middle.place.norm(), 0, 1e-9);
  const auto half = io::cornerBoard(4, 3, 0.1, cornersOf(4, 3, {2, 3, 6, 7, 10, 11}));
  ASSERT_TRUE(half);
  EXPECT_NEAR(half->middle.pixel.u, 105, 1e-3);
  EXPECT_NEAR(half->middle.place.x(), -0.1, 1e-9);
  EXPECT_NEAR(std::fabs(half->middle.place.y()), 0.05, 1e-9);
}

TEST(CornerBoard, CornersOnOneLineAreNone) {
  EXPECT_FALSE(io::cornerBoard(4, 3, 0.1, cornersOf(4, 3, {4, 5, 6, 7, 8, 9, 10, 11})));
  EXPECT_FALSE(io::cornerBoard(2, 2, 0.1, cornersOf(2, 2, {1})));
  EXPECT_FALSE(io::cornerBoard(2, 2, 0.1, cornersOf(2, 2, {0, 1, 2, 3})));
}

BoardKind kindOf(const std::string& name, double side, int columns, int rows, const std::string& family) {
  BoardKind board;
  board.kind = name;
  board.side = side;
  board.columns = columns;
  board.rows = rows;
  board.family = family;
  if (name == "charuco") board.marker = 0.75 * side;
  if (name == "aruco-grid") board.gap = 0.5 * side;
  return board;
}

#ifndef FUSE_FLOW_WITH_OPENCV

TEST(BoardDetector, WithoutOpenCvItSaysWhatToInstall) {
  EXPECT_FALSE(io::openCvAvailable());
  EXPECT_TRUE(refuses<io::OptionError>([] { io::makeBoardDetector(kindOf("chessboard", 0.04, 9, 6, "")); },
                                       {"--board", "chessboard", "libopencv-contrib-dev", "build again"}));
  EXPECT_TRUE(refuses<io::OptionError>([] { io::makeBoardDetector(kindOf("markers", 0.04, 0, 0, "DICT_4X4_50")); },
                                       {"--board", "DICT_4X4_50", "libopencv-contrib-dev"}));
}

#else

io::ColorImage imageOf(const Print& print, const Eye& eye,
                       const std::function<bool(double, double)>& hidden = nullptr) {
  io::ColorImage image;
  image.resize(eye.width, eye.height);
  const std::vector<std::uint8_t> grey = board_test::photograph(print, eye, hidden);
  for (std::size_t k = 0; k < grey.size(); ++k) image.data[k] = {grey[k], grey[k], grey[k]};
  return image;
}

/** \brief A lens that bends lines by a pixel or two, and a board that is tilted and turned. */
Eye eyeAt(double x, double y, double z, double distance) {
  Eye eye;
  eye.k1 = 0.08;
  eye.k2 = -0.03;
  eye.p1 = 0.001;
  eye.t = {0.02, -0.01, distance};
  eye.turn(x, y, z);
  return eye;
}

const std::vector<Eye>& eyes() {
  static const std::vector<Eye> all{eyeAt(0.05, -0.07, 0.06, 0.65), eyeAt(0.3, 0.6, 0.4, 0.65),
                                    eyeAt(-0.5, -0.2, 2.6, 0.7), eyeAt(0.2, -0.4, -1.6, 0.7)};
  return all;
}

struct Errors {
  double rms{0}, mean_u{0}, mean_v{0}, largest{0};
};

Errors errorsOf(const DetectedBoard& board, const Eye& eye) {
  Errors errors;
  const double n = static_cast<double>(board.points.size());
  for (const io::MarkerPoint& point : board.points) {
    const auto truth = eye.pixelOf(point.place.x(), point.place.y());
    const double u = static_cast<double>(point.pixel.u) - truth[0], v = static_cast<double>(point.pixel.v) - truth[1];
    errors.rms += (u * u + v * v) / n;
    errors.mean_u += u / n;
    errors.mean_v += v / n;
    errors.largest = std::max(errors.largest, std::hypot(u, v));
  }
  errors.rms = std::sqrt(errors.rms);
  return errors;
}

/** \brief That a board is found in all views of its print, its corners where they are; pixel centres at integers. */
void expectFound(const BoardKind& kind, const Print& print, std::size_t least_points, double rms) {
  const auto detector = io::makeBoardDetector(kind);
  for (std::size_t k = 0; k < eyes().size(); ++k) {
    const std::vector<DetectedBoard> found = detector->detect(imageOf(print, eyes()[k]));
    ASSERT_EQ(found.size(), 1u) << kind.kind << ", view " << k;
    EXPECT_GE(found[0].points.size(), least_points) << kind.kind << ", view " << k;
    const Errors errors = errorsOf(found[0], eyes()[k]);
    EXPECT_LT(errors.rms, rms) << kind.kind << ", view " << k;
    EXPECT_LT(errors.largest, 4 * rms) << kind.kind << ", view " << k;
    EXPECT_LT(std::hypot(errors.mean_u, errors.mean_v), 0.06) << kind.kind << ", view " << k;
    const auto middle = eyes()[k].pixelOf(found[0].middle.place.x(), found[0].middle.place.y());
    EXPECT_NEAR(found[0].middle.pixel.u, middle[0], 0.5);
    EXPECT_NEAR(found[0].middle.pixel.v, middle[1], 0.5);
  }
}

TEST(BoardDetector, FindsTheCornersOfAChessboardInTheSameOrderHoweverItIsTurned) {
  expectFound(kindOf("chessboard", 0.04, 9, 6, ""), board_test::chessboardPrint(9, 6, 0.04), 54, 0.08);
  expectFound(kindOf("chessboard", 0.04, 6, 7, ""), board_test::chessboardPrint(6, 7, 0.04), 42, 0.08);
}

TEST(BoardDetector, FindsTheCornersOfACharucoBoard) {
  expectFound(kindOf("charuco", 0.05, 5, 7, "DICT_4X4_50"),
              board_test::charucoPrint(5, 7, 0.05, 0.0375, board_test::kDict4x4), 20, 0.1);
  expectFound(kindOf("charuco", 0.05, 6, 5, "DICT_6X6_250"),
              board_test::charucoPrint(6, 5, 0.05, 0.0375, board_test::kDict6x6), 14, 0.1);
}

TEST(BoardDetector, ACharucoBoardOfEvenRowsIsTakenAsOpenCvDrawsIt) {
  for (const int columns : {6, 7}) {
    BoardKind kind = kindOf("charuco", 0.05, columns, 6, "DICT_4X4_50");
    const Print print = board_test::charucoPrint(columns, 6, 0.05, 0.0375, board_test::kDict4x4);
    // Black from 4.6 on; before, OpenCV drew the other pattern.
    const bool legacy = print.at(-0.025 * columns + 0.001, -0.15 + 0.001) > 128;
    kind.legacy = legacy;
    expectFound(kind, print, 20, 0.1);
    // The other one finds nothing, and says why.
    kind.legacy = !legacy;
    const auto detector = io::makeBoardDetector(kind);
    EXPECT_TRUE(detector->detect(imageOf(print, eyes()[1])).empty());
    EXPECT_NE(detector->advice().find("--board-legacy"), std::string::npos) << detector->advice();
  }
}

TEST(BoardDetector, TheOtherPatternIsOpenCvsTurnedUpsideDownAndNumberedAgain) {
  // With the lower left square black: rows in the opposite order, each marker drawn upright, numbers again from above.
  const int columns = 5, rows = 4,
            id_at[4][5] = {{0, -1, 1, -1, 2}, {-1, 3, -1, 4, -1}, {5, -1, 6, -1, 7}, {-1, 8, -1, 9, -1}};
  const double side = 0.06;
  Print print = board_test::chessboardPrint(columns - 1, rows - 1, side);
  const int square = print.width / (columns + 2);
  std::vector<Print> markers;
  for (int id = 0; id < 10; ++id) markers.push_back(board_test::markerPrint(0.045, id, board_test::kDict4x4));
  for (int v = 0; v < print.height; ++v)
    for (int u = 0; u < print.width; ++u) {
      const int column = u / square - 1, row = v / square - 1;
      auto& pixel = print.grey[static_cast<std::size_t>(v * print.width + u)];
      pixel = 220;
      if (column < 0 || row < 0 || column >= columns || row >= rows) continue;
      const int id = id_at[row][column];
      if (id < 0) {
        pixel = 30;
        continue;
      }
      const Print& marker = markers[static_cast<std::size_t>(id)];
      const double x = (u - square * (column + 1) + 0.5) / square - 0.5,
                   y = (v - square * (row + 1) + 0.5) / square - 0.5;
      if (std::max(std::fabs(x), std::fabs(y)) < 0.375)
        pixel = static_cast<std::uint8_t>(marker.at(x * side, y * side));
    }
  BoardKind kind = kindOf("charuco", side, columns, rows, "DICT_4X4_50");
  kind.legacy = true;
  expectFound(kind, print, 8, 0.1);
}

TEST(BoardDetector, ACharucoBoardMayBeHiddenInPart) {
  const Print print = board_test::charucoPrint(5, 7, 0.05, 0.0375, board_test::kDict4x4);
  const auto detector = io::makeBoardDetector(kindOf("charuco", 0.05, 5, 7, "DICT_4X4_50"));
  const auto left_column = [](double x, double y) { return x < 0.003 * std::sin(40 * y) - 0.08; };
  const std::vector<DetectedBoard> found = detector->detect(imageOf(print, eyes()[1], left_column));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_GE(found[0].points.size(), 16u);
  EXPECT_LE(found[0].points.size(), 18u);
  EXPECT_LT(errorsOf(found[0], eyes()[1]).largest, 0.4);
  for (const io::MarkerPoint& point : found[0].points) EXPECT_GT(point.place.x(), -0.03);
  const auto most = [](double x, double y) { return x < 0.05 || y < 0; };
  EXPECT_TRUE(detector->detect(imageOf(print, eyes()[1], most)).empty());
}

TEST(BoardDetector, ACornerThatIsHiddenBetweenMarkersIsLeftOut) {
  const Print print = board_test::charucoPrint(5, 7, 0.05, 0.0375, board_test::kDict4x4);
  const auto detector = io::makeBoardDetector(kindOf("charuco", 0.05, 5, 7, "DICT_4X4_50"));
  // A finger on the corner at (25, 25) mm, which leaves all markers whole.
  const auto finger = [](double x, double y) { return std::hypot(x - 0.025, y - 0.025) < 0.008; };
  const std::vector<DetectedBoard> found = detector->detect(imageOf(print, eyes()[0], finger));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].points.size(), 23u);
  EXPECT_LT(errorsOf(found[0], eyes()[0]).largest, 0.4);
}

TEST(BoardDetector, FindsTheCornersOfArucoMarkers) {
  expectFound(kindOf("markers", 0.2, 0, 0, "DICT_6X6_250"), board_test::markerPrint(0.2, 7, board_test::kDict6x6), 4,
              0.06);
  expectFound(kindOf("aruco-grid", 0.06, 4, 3, "DICT_5X5_100"),
              board_test::gridPrint(4, 3, 0.06, 0.03, board_test::kDict5x5), 40, 0.1);
}

TEST(BoardDetector, AMarkerKeepsItsNumber) {
  const auto detector = io::makeBoardDetector(kindOf("markers", 0.2, 0, 0, "DICT_6X6_250"));
  const auto found = detector->detect(imageOf(board_test::markerPrint(0.2, 42, board_test::kDict6x6), eyes()[1]));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].id, 42);
}

TEST(BoardDetector, AChessboardThatIsHiddenInPartIsNotFound) {
  const auto detector = io::makeBoardDetector(kindOf("chessboard", 0.04, 9, 6, ""));
  const auto corner = [](double x, double y) { return x > 0.08 && y > 0.04; };
  EXPECT_TRUE(detector->detect(imageOf(board_test::chessboardPrint(9, 6, 0.04), eyes()[0], corner)).empty());
  EXPECT_NE(detector->advice().find("whole"), std::string::npos);
}

TEST(BoardDetector, AnImageWithoutABoardHasNone) {
  io::ColorImage grey;
  grey.resize(160, 120);
  for (const BoardKind& kind :
       {kindOf("chessboard", 0.04, 9, 6, ""), kindOf("charuco", 0.05, 5, 7, "DICT_4X4_50"),
        kindOf("markers", 0.2, 0, 0, "DICT_6X6_250"), kindOf("aruco-grid", 0.06, 4, 3, "DICT_5X5_100")}) {
    const auto detector = io::makeBoardDetector(kind);
    EXPECT_TRUE(detector->detect(grey).empty()) << kind.kind;
    EXPECT_TRUE(detector->detect(io::ColorImage()).empty()) << kind.kind;
    EXPECT_TRUE(detector->detect(imageOf(board_test::markerPrint(0.2, 7, board_test::kDict4x4), eyes()[1])).empty())
        << kind.kind;
  }
}

#endif

}  // namespace
