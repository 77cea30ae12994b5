#include "board_picture.h"

#ifdef FUSE_FLOW_WITH_OPENCV
#include <opencv2/core.hpp>
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
#define BOARD_TEST_NEW_ARUCO 1
#include <opencv2/objdetect/aruco_board.hpp>
#include <opencv2/objdetect/aruco_detector.hpp>
#else
#define BOARD_TEST_NEW_ARUCO 0
#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#endif
#endif

#include <algorithm>
#include <cmath>

namespace board_test {
namespace {

constexpr int kSquare = 80;  // pixels of a print, a multiple of what markers of 4, 5 and 6 bits are drawn with
constexpr int kFine = 4;     // places across a pixel of a photograph

using Matrix = std::array<double, 9>;

Matrix times(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) c[3 * i + j] += a[3 * i + k] * b[3 * k + j];
  return c;
}

std::array<double, 2> bent(const Eye& eye, double x, double y) {
  const double r2 = x * x + y * y, s = 1 + r2 * (eye.k1 + r2 * eye.k2);
  return {x * s + 2 * eye.p1 * x * y + eye.p2 * (r2 + 2 * x * x),
          y * s + eye.p1 * (r2 + 2 * y * y) + 2 * eye.p2 * x * y};
}

/** \brief A lens spreads each pixel over its neighbours, 1 : 2 : 1 in a row and in a column. */
std::vector<std::uint8_t> throughLens(const std::vector<double>& sharp, int width, int height) {
  std::vector<std::uint8_t> grey;
  grey.reserve(sharp.size());
  const auto at = [&](int u, int v) {
    u = std::min(std::max(u, 0), width - 1);
    v = std::min(std::max(v, 0), height - 1);
    return sharp[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
  };
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      double sum = 0;
      for (int k = -1; k <= 1; ++k)
        sum += (k == 0 ? 2 : 1) * (at(u - 1, v + k) + 2 * at(u, v + k) + at(u + 1, v + k)) / 16;
      grey.push_back(static_cast<std::uint8_t>(std::lround(sum)));
    }
  return grey;
}

}  // namespace

double Print::at(double x, double y) const {
  const double u = std::floor(0.5 * width + x * pixels_per_metre), v = std::floor(0.5 * height + y * pixels_per_metre);
  if (!(u >= 0 && v >= 0 && u < width && v < height)) return 120;
  return grey[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
}

Print chessboardPrint(int columns, int rows, double side) {
  Print print;
  print.width = (columns + 3) * kSquare;
  print.height = (rows + 3) * kSquare;
  print.pixels_per_metre = kSquare / side;
  for (int v = 0; v < print.height; ++v)
    for (int u = 0; u < print.width; ++u) {
      const int column = u / kSquare, row = v / kSquare;
      const bool inside = column >= 1 && row >= 1 && column <= columns + 1 && row <= rows + 1;
      print.grey.push_back(inside && (column + row) % 2 == 0 ? 30 : 220);
    }
  return print;
}

#ifdef FUSE_FLOW_WITH_OPENCV

namespace {

#if BOARD_TEST_NEW_ARUCO
cv::aruco::Dictionary dictionaryOf(int number) { return cv::aruco::getPredefinedDictionary(number); }
#else
cv::Ptr<cv::aruco::Dictionary> dictionaryOf(int number) { return cv::aruco::getPredefinedDictionary(number); }
#endif

/** \brief With a white border, and neither quite black nor quite white. */
Print printOf(const cv::Mat& drawn, double pixels_per_metre) {
  Print print;
  print.width = drawn.cols + 2 * kSquare;
  print.height = drawn.rows + 2 * kSquare;
  print.pixels_per_metre = pixels_per_metre;
  for (int v = -kSquare; v < drawn.rows + kSquare; ++v)
    for (int u = -kSquare; u < drawn.cols + kSquare; ++u) {
      const bool inside = u >= 0 && v >= 0 && u < drawn.cols && v < drawn.rows;
      print.grey.push_back(inside && drawn.at<unsigned char>(v, u) < 128 ? 30 : 220);
    }
  return print;
}

}  // namespace

const int kDict4x4 = cv::aruco::DICT_4X4_50, kDict5x5 = cv::aruco::DICT_5X5_100, kDict6x6 = cv::aruco::DICT_6X6_250;

Print charucoPrint(int columns, int rows, double side, double marker, int dictionary) {
  cv::Mat drawn;
  const cv::Size size(columns * kSquare, rows * kSquare);
#if BOARD_TEST_NEW_ARUCO
  cv::aruco::CharucoBoard({columns, rows}, static_cast<float>(side), static_cast<float>(marker),
                          dictionaryOf(dictionary))
      .generateImage(size, drawn);
#else
  cv::aruco::CharucoBoard::create(columns, rows, static_cast<float>(side), static_cast<float>(marker),
                                  dictionaryOf(dictionary))
      ->draw(size, drawn);
#endif
  return printOf(drawn, kSquare / side);
}

Print markerPrint(double side, int id, int dictionary) {
  cv::Mat drawn;
  constexpr int size = 3 * kSquare;
#if BOARD_TEST_NEW_ARUCO
  cv::aruco::generateImageMarker(dictionaryOf(dictionary), id, size, drawn);
#else
  cv::aruco::drawMarker(dictionaryOf(dictionary), id, size, drawn);
#endif
  return printOf(drawn, size / side);
}

Print gridPrint(int columns, int rows, double side, double gap, int dictionary) {
  cv::Mat drawn;
  const double scale = kSquare / side;
  const cv::Size size(static_cast<int>(std::lround(scale * (columns * side + (columns - 1) * gap))),
                      static_cast<int>(std::lround(scale * (rows * side + (rows - 1) * gap))));
#if BOARD_TEST_NEW_ARUCO
  cv::aruco::GridBoard({columns, rows}, static_cast<float>(side), static_cast<float>(gap), dictionaryOf(dictionary))
      .generateImage(size, drawn);
#else
  cv::aruco::GridBoard::create(columns, rows, static_cast<float>(side), static_cast<float>(gap),
                               dictionaryOf(dictionary))
      ->draw(size, drawn);
#endif
  return printOf(drawn, scale);
}

#endif

void Eye::turn(double x, double y, double z) {
  const Matrix X{1, 0, 0, 0, std::cos(x), -std::sin(x), 0, std::sin(x), std::cos(x)};
  const Matrix Y{std::cos(y), 0, std::sin(y), 0, 1, 0, -std::sin(y), 0, std::cos(y)};
  const Matrix Z{std::cos(z), -std::sin(z), 0, std::sin(z), std::cos(z), 0, 0, 0, 1};
  R = times(Z, times(Y, times(X, R)));
}

std::array<double, 2> Eye::pixelOf(double x, double y) const {
  const double z = R[6] * x + R[7] * y + t[2];
  const std::array<double, 2> ray = bent(*this, (R[0] * x + R[1] * y + t[0]) / z, (R[3] * x + R[4] * y + t[1]) / z);
  return {cx + fx * ray[0], cy + fy * ray[1]};
}

std::vector<std::uint8_t> photograph(const Print& print, const Eye& eye,
                                     const std::function<bool(double, double)>& hidden) {
  std::vector<double> sharp;
  const Matrix& R = eye.R;
  const double away = R[2] * eye.t[0] + R[5] * eye.t[1] + R[8] * eye.t[2];  // of the board's plane, along its normal
  for (int v = 0; v < eye.height; ++v)
    for (int u = 0; u < eye.width; ++u) {
      double sum = 0;
      for (int k = 0; k < kFine * kFine; ++k) {
        const double xd = (u + (k % kFine + 0.5) / kFine - 0.5 - eye.cx) / eye.fx;
        const double yd = (v + (k / kFine + 0.5) / kFine - 0.5 - eye.cy) / eye.fy;
        double x = xd, y = yd;
        for (int i = 0; i < 8 && (eye.k1 != 0 || eye.k2 != 0 || eye.p1 != 0 || eye.p2 != 0); ++i) {
          const std::array<double, 2> there = bent(eye, x, y);
          x += xd - there[0];
          y += yd - there[1];
        }
        const double z = away / (R[2] * x + R[5] * y + R[8]);
        const double px = z * x - eye.t[0], py = z * y - eye.t[1], pz = z - eye.t[2];
        const double bx = R[0] * px + R[3] * py + R[6] * pz, by = R[1] * px + R[4] * py + R[7] * pz;
        sum += !(z > 0) || (hidden && hidden(bx, by)) ? 120 : print.at(bx, by);
      }
      sharp.push_back(sum / (kFine * kFine));
    }
  return throughLens(sharp, eye.width, eye.height);
}

}  // namespace board_test
