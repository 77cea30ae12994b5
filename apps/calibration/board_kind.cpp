#include "calibration/board_kind.h"

#include "calibration/marker_detector.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace fuse_flow::io {
namespace {

struct DictionarySize {
  const char* name;
  int markers;
};

constexpr DictionarySize kDictionaries[] = {
    {"DICT_4X4_50", 50},          {"DICT_4X4_100", 100}, {"DICT_4X4_250", 250}, {"DICT_4X4_1000", 1000},
    {"DICT_5X5_50", 50},          {"DICT_5X5_100", 100}, {"DICT_5X5_250", 250}, {"DICT_5X5_1000", 1000},
    {"DICT_6X6_50", 50},          {"DICT_6X6_100", 100}, {"DICT_6X6_250", 250}, {"DICT_6X6_1000", 1000},
    {"DICT_7X7_50", 50},          {"DICT_7X7_100", 100}, {"DICT_7X7_250", 250}, {"DICT_7X7_1000", 1000},
    {"DICT_ARUCO_ORIGINAL", 1024}};

constexpr int kMostColumns = 100;

bool isDictionary(const std::string& family) { return family.rfind("DICT_", 0) == 0; }

std::string metresText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string sizeOf(const BoardKind& board) {
  return "--board-size " + std::to_string(board.columns) + "x" + std::to_string(board.rows);
}

std::string listOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

void refuseOthersOptions(const BoardKind& board) {
  const std::string kind = ": --board-kind " + board.kind + " has none, ";
  if (board.kind == "markers" && board.columns > 0)
    throw OptionError(sizeOf(board) + kind + "must be chessboard, charuco or aruco-grid");
  if (board.kind == "chessboard" && !board.family.empty())
    throw OptionError("--board-family " + board.family + kind + "must be markers, charuco or aruco-grid");
  if (board.kind != "charuco" && board.marker > 0)
    throw OptionError("--board-marker " + metresText(board.marker) + kind +
                      "must be charuco; elsewhere --board says all");
  if (board.kind != "charuco" && board.legacy) throw OptionError("--board-legacy" + kind + "must be charuco");
  if (board.kind != "aruco-grid" && board.gap > 0)
    throw OptionError("--board-gap " + metresText(board.gap) + kind + "must be aruco-grid");
}

void checkChessboard(const BoardKind& board) {
  if (board.columns < 3 || board.rows < 3)
    throw OptionError(sizeOf(board) + ": must be 3x3 or more inner corners, where four squares meet");
  if ((board.columns + board.rows) % 2 == 0)
    throw OptionError(sizeOf(board) +
                      ": this chessboard looks the same after half a turn, so that two cameras may take different "
                      "corners for the same one; one of the two numbers of inner corners must be even and the other "
                      "odd, such as 9x6; else use --board-kind charuco");
}

/** \brief That a board of markers has as many as it needs. */
void checkMarkers(const BoardKind& board, int markers) {
  if (!isDictionary(board.family))
    throw OptionError((board.family.empty() ? "--board-kind " + board.kind + " needs --board-family"
                                            : "--board-family " + board.family + ": the board has ArUco markers") +
                      ", must be one of " + listOf(BoardKind::dictionaries()));
  for (const DictionarySize& dictionary : kDictionaries)
    if (dictionary.name == board.family && markers > dictionary.markers)
      throw OptionError(sizeOf(board) + ": the board would have " + std::to_string(markers) + " markers, of which " +
                        board.family + " has only " + std::to_string(dictionary.markers));
}

}  // namespace

std::vector<std::string> BoardKind::dictionaries() {
  std::vector<std::string> names;
  for (const DictionarySize& dictionary : kDictionaries) names.emplace_back(dictionary.name);
  return names;
}

std::vector<std::string> BoardKind::families() {
  std::vector<std::string> names = MarkerDetector::families();
  for (const std::string& name : dictionaries()) names.push_back(name);
  return names;
}

std::optional<std::pair<int, int>> parseBoardSize(const std::string& text) {
  const std::size_t x = text.find_first_of("xX");
  if (x == std::string::npos) return std::nullopt;
  const std::string columns = text.substr(0, x), rows = text.substr(x + 1);
  const auto isCount = [](const std::string& digits) {
    return !digits.empty() && digits.size() <= 3 && digits.find_first_not_of("0123456789") == std::string::npos &&
           std::atoi(digits.c_str()) >= 1 && std::atoi(digits.c_str()) <= kMostColumns;
  };
  if (!isCount(columns) || !isCount(rows)) return std::nullopt;
  return std::make_pair(std::atoi(columns.c_str()), std::atoi(rows.c_str()));
}

void checkBoard(const BoardKind& board) {
  refuseOthersOptions(board);
  if (board.kind == "markers") return;
  if (board.columns == 0) throw OptionError("--board-kind " + board.kind + " needs --board-size, such as 9x6");
  if (board.kind == "chessboard") checkChessboard(board);
  if (board.kind == "charuco") {
    if (board.columns < 3 || board.rows < 3) throw OptionError(sizeOf(board) + ": must be 3x3 or more squares");
    checkMarkers(board, board.columns * board.rows / 2);
    if (!(board.marker > 0)) throw OptionError("--board-kind charuco needs --board-marker, the side of its markers, m");
    if (!(board.marker < board.side))
      throw OptionError("--board-marker " + metresText(board.marker) + ": must be less than the side of the squares, " +
                        metresText(board.side) + " (--board)");
  }
  if (board.kind == "aruco-grid") {
    if (board.columns * board.rows < 2) throw OptionError(sizeOf(board) + ": must be two or more markers");
    checkMarkers(board, board.columns * board.rows);
    if (!(board.gap > 0))
      throw OptionError("--board-kind aruco-grid needs --board-gap, the distance of its markers, m");
  }
}

bool needsOpenCv(const BoardKind& board) { return board.kind != "markers" || isDictionary(board.family); }

std::string assumptionAbout(const BoardKind& board) {
  if (board.kind != "charuco" || board.rows % 2 != 0) return "";  // both patterns are the same where rows are odd
  return board.legacy ? "The upper left square of the ChArUco board is taken for white, as OpenCV drew it before 4.6 "
                        "(--board-legacy)."
                      : "The upper left square of the ChArUco board is taken for black, as OpenCV draws it since 4.6; "
                        "--board-legacy takes it for white.";
}

}  // namespace fuse_flow::io
