#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::io {

/** \brief What someone shows to the cameras, as it is printed. */
struct BoardKind {
  /** \brief "markers": square markers, each by itself; "chessboard"; "charuco": a chessboard with a marker in each white square;
   *  "aruco-grid": markers in rows and columns. */
  std::string kind{"markers"};
  /** \brief Of a marker's black square; of a chessboard's and a ChArUco board's squares; metres. */
  double side{0};
  std::string family;  ///< of the markers; empty: tag36h11, where they are AprilTags
  ///@{
  /** \brief Of a chessboard: inner corners; of a ChArUco board: squares; of a grid: markers. 0: not given. */
  int columns{0}, rows{0};
  ///@}
  double marker{0};    ///< side of a ChArUco board's markers, metres; 0: not given
  double gap{0};       ///< between the markers of a grid, metres; 0: not given
  bool legacy{false};  ///< a ChArUco board whose lower left square is black, as OpenCV drew them before 4.6

  static std::vector<std::string> kinds() { return {"markers", "chessboard", "charuco", "aruco-grid"}; }
  /** \brief Of ArUco markers, which OpenCV finds, by OpenCV's names. */
  static std::vector<std::string> dictionaries();
  /** \brief These, and MarkerDetector's. */
  static std::vector<std::string> families();
};

/** \brief Of "9x6": columns, then rows. Nothing if the text is no such size. */
std::optional<std::pair<int, int>> parseBoardSize(const std::string& text);

/** \brief Throws OptionError, which names the option, unless the kind has all that it needs, and nothing that it does not. */
void checkBoard(const BoardKind& board);

/** \brief Whether OpenCV finds it, and not libapriltag. */
bool needsOpenCv(const BoardKind& board);

/** \brief What is taken for granted about the board though a print may be otherwise; one line, empty if nothing is. */
std::string assumptionAbout(const BoardKind& board);

}  // namespace fuse_flow::io
