#include "calibration/marker_detector.h"

#include "../recordings/io_fixture.h"

#include <cmath>

namespace {

using namespace io_test;
using io::ColorImage;
using io::DetectedMarker;
using io::MarkerDetector;

struct Point {
  double x, y;
};

/** \brief A camera that looks at the marker from the side, rolled a little: marker's plane, in cells from its middle, x to the
 *  right and y down, to pixels. */
Point seen(const Point& cell) {
  const double a = 0.6, b = 0.15, size = 0.05;
  const double x = size * cell.x, y = size * cell.y;
  const double u = std::cos(a) * x, z = 1.8 + std::sin(a) * x;
  const double right = std::cos(b) * u - std::sin(b) * y, down = std::sin(b) * u + std::cos(b) * y;
  return {210.3 + 500 * (right + 0.02) / z, 148.6 + 500 * (down - 0.01) / z};
}

/** \brief The inverse of seen(), by Newton's method. */
Point cellAt(const Point& pixel) {
  Point cell{0, 0};
  for (int k = 0; k < 6; ++k) {
    const double h = 1e-4;
    const Point p = seen(cell), px = seen({cell.x + h, cell.y}), py = seen({cell.x, cell.y + h});
    const double a = (px.x - p.x) / h, b = (py.x - p.x) / h, c = (px.y - p.y) / h, d = (py.y - p.y) / h;
    const double ex = pixel.x - p.x, ey = pixel.y - p.y, determinant = a * d - b * c;
    cell.x += (d * ex - b * ey) / determinant;
    cell.y += (a * ey - c * ex) / determinant;
  }
  return cell;
}

/** \brief Number 0 of tag36h11, in grey surroundings; every pixel the mean over its area, its centre at integers. */
ColorImage markerImage() {
  static constexpr const char* rows[] = {"          ", " ######## ", " #  # # # ", " ##   # # ", " ##  #### ",
                                         " # # #### ", " ## #  ## ", " #### ### ", " ######## ", "          "};
  ColorImage image;
  image.resize(420, 300);
  constexpr int fine = 3;
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      double sum = 0;
      for (int k = 0; k < fine * fine; ++k) {
        const Point cell = cellAt({u + (k % fine + 0.5) / fine - 0.5, v + (k / fine + 0.5) / fine - 0.5});
        const int column = static_cast<int>(std::floor(cell.x + 5)), row = static_cast<int>(std::floor(cell.y + 5));
        const bool inside = column >= 0 && column < 10 && row >= 0 && row < 10;
        sum += !inside ? 120 : rows[row][column] == '#' ? 30 : 220;
      }
      const auto grey = static_cast<std::uint8_t>(sum / (fine * fine));
      image.at(u, v) = {grey, grey, grey};
    }
  return image;
}

TEST(MarkerDetector, FindsTheCornersToAFifthOfAPixel) {
  if (!MarkerDetector::available()) GTEST_SKIP() << "built without libapriltag";
  const std::vector<DetectedMarker> found = MarkerDetector("tag36h11").detect(markerImage());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].id, 0);
  const Point corners[] = {{-4, 4}, {4, 4}, {4, -4}, {-4, -4}};
  for (std::size_t k = 0; k < 4; ++k) {
    const Point expected = seen(corners[k]);
    EXPECT_NEAR(found[0].corners[k].u, expected.x, 0.2) << k;
    EXPECT_NEAR(found[0].corners[k].v, expected.y, 0.2) << k;
  }
}

TEST(MarkerDetector, OfTwoWithOneNumberNeitherIsTaken) {
  if (!MarkerDetector::available()) GTEST_SKIP() << "built without libapriltag";
  const ColorImage one = markerImage();
  ColorImage two;
  two.resize(2 * one.width, one.height);
  for (int v = 0; v < two.height; ++v)
    for (int u = 0; u < two.width; ++u) two.at(u, v) = one.at(u % one.width, v);
  EXPECT_TRUE(MarkerDetector("tag36h11").detect(two).empty());
}

TEST(MarkerDetector, AnImageWithoutAMarkerHasNone) {
  if (!MarkerDetector::available()) GTEST_SKIP() << "built without libapriltag";
  ColorImage grey;
  grey.resize(64, 48);
  MarkerDetector detector("tag25h9");
  EXPECT_TRUE(detector.detect(grey).empty());
  EXPECT_TRUE(detector.detect(ColorImage()).empty());
  EXPECT_TRUE(detector.detect(markerImage()).empty()) << "another family's";
}

TEST(MarkerDetector, RefusesWhatItCannotFind) {
  if (MarkerDetector::available())
    EXPECT_TRUE(refuses([] { MarkerDetector("qr"); }, {"'qr'"}));
  else
    EXPECT_TRUE(refuses<io::OptionError>([] { MarkerDetector("tag36h11"); }, {"--board", "libapriltag-dev"}));
}

}  // namespace
