#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

// Boards as they are printed, drawn by OpenCV where it can, and photographs of them. Without any of the library's code.

namespace board_test {

/** \brief A print, whose middle is the origin of the board: x to the right, y down. */
struct Print {
  int width{0}, height{0};
  std::vector<std::uint8_t> grey;
  double pixels_per_metre{0};
  /** \brief Brightness at a place on it, metres; 120 beside it. */
  double at(double x, double y) const;
};

/** \brief Squares with a white border as wide as one. The one upper left of the first inner corner is black. */
Print chessboardPrint(int columns, int rows, double side);
#ifdef FUSE_FLOW_WITH_OPENCV
/** \brief OpenCV's drawing; of an even number of rows its upper left square is black from 4.6 on. \param dictionary OpenCV's number
 *  of it */
Print charucoPrint(int columns, int rows, double side, double marker, int dictionary);
Print markerPrint(double side, int id, int dictionary);
Print gridPrint(int columns, int rows, double side, double gap, int dictionary);
/** \brief The number of DICT_4X4_50, DICT_5X5_100 and DICT_6X6_250. */
extern const int kDict4x4, kDict5x5, kDict6x6;
#endif

/** \brief A camera whose pixel centres are at integers, and where the board is: x_camera = R x_board + t. */
struct Eye {
  int width{640}, height{480};
  double fx{520}, fy{518}, cx{318.3}, cy{241.6};
  double k1{0}, k2{0}, p1{0}, p2{0};
  std::array<double, 9> R{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major
  std::array<double, 3> t{0, 0, 1};
  /** \brief Turned about the camera's x, then y, then z, radians. */
  void turn(double x, double y, double z);
  /** \brief The pixel of a place on the board. */
  std::array<double, 2> pixelOf(double x, double y) const;
};

/** \brief Brightness row by row, each pixel the mean over its area. \param hidden whether something is before a place on the board */
std::vector<std::uint8_t> photograph(const Print& print, const Eye& eye,
                                     const std::function<bool(double, double)>& hidden = nullptr);

}  // namespace board_test
