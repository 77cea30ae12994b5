#include "calibration/board_kind.h"

#include "../recordings/io_fixture.h"

namespace {

using namespace io_test;
using io::BoardKind;

BoardKind charucoOf(int columns, int rows) {
  BoardKind board;
  board.kind = "charuco";
  board.side = 0.04;
  board.marker = 0.03;
  board.family = "DICT_4X4_50";
  board.columns = columns;
  board.rows = rows;
  return board;
}

BoardKind chessboardOf(int columns, int rows) {
  BoardKind board;
  board.kind = "chessboard";
  board.side = 0.03;
  board.columns = columns;
  board.rows = rows;
  return board;
}

bool refusesBoard(const BoardKind& board, const std::vector<std::string>& words) {
  const auto result = refuses<io::OptionError>([&] { io::checkBoard(board); }, words);
  if (!result) ADD_FAILURE() << result.message();
  return result;
}

TEST(BoardKind, ASizeIsTwoWholeNumbers) {
  EXPECT_EQ(io::parseBoardSize("9x6"), std::make_pair(9, 6));
  EXPECT_EQ(io::parseBoardSize("12X100"), std::make_pair(12, 100));
  for (const char* wrong : {"", "9", "x", "9x", "x6", "9x6x2", "0x6", "9x101", "-9x6", "9 x 6", "9.5x6", "9,6", "+9x6"})
    EXPECT_FALSE(io::parseBoardSize(wrong)) << wrong;
}

TEST(BoardKind, WhatIsCompleteIsTaken) {
  EXPECT_NO_THROW(io::checkBoard(charucoOf(5, 7)));
  EXPECT_NO_THROW(io::checkBoard(charucoOf(10, 10))) << "50 markers";
  EXPECT_NO_THROW(io::checkBoard(chessboardOf(9, 6)));
  EXPECT_NO_THROW(io::checkBoard(chessboardOf(6, 9)));
  BoardKind markers;
  markers.side = 0.4;
  EXPECT_NO_THROW(io::checkBoard(markers));
  markers.family = "DICT_5X5_100";
  EXPECT_NO_THROW(io::checkBoard(markers));
}

TEST(BoardKind, AChessboardThatLooksTheSameAfterHalfATurnIsRefused) {
  EXPECT_TRUE(refusesBoard(chessboardOf(8, 6), {"--board-size 8x6", "half a turn", "9x6", "charuco"}));
  EXPECT_TRUE(refusesBoard(chessboardOf(7, 5), {"--board-size 7x5", "half a turn"}));
  EXPECT_TRUE(refusesBoard(chessboardOf(7, 7), {"half a turn"}));
}

TEST(BoardKind, ABoardOfNoSizeIsRefused) {
  EXPECT_TRUE(refusesBoard(chessboardOf(1, 1), {"--board-size 1x1", "3x3"}));
  EXPECT_TRUE(refusesBoard(charucoOf(1, 1), {"--board-size 1x1", "3x3"}));
  EXPECT_TRUE(refusesBoard(chessboardOf(0, 0), {"chessboard needs --board-size"}));
}

TEST(BoardKind, WhatABoardLacksIsNamed) {
  BoardKind board = charucoOf(5, 7);
  board.marker = 0;
  EXPECT_TRUE(refusesBoard(board, {"--board-marker"}));
  board.marker = 0.04;
  EXPECT_TRUE(refusesBoard(board, {"--board-marker 0.04", "less than", "0.04 (--board)"}));
  board = charucoOf(5, 7);
  board.family.clear();
  EXPECT_TRUE(refusesBoard(board, {"needs --board-family", "DICT_4X4_50"}));
  board.family = "tag36h11";
  EXPECT_TRUE(refusesBoard(board, {"--board-family tag36h11", "ArUco", "DICT_4X4_50"}));
  EXPECT_TRUE(refusesBoard(charucoOf(11, 10), {"55 markers", "only 50"}));
  board = charucoOf(4, 3);
  board.kind = "aruco-grid";
  board.marker = 0;
  EXPECT_TRUE(refusesBoard(board, {"--board-gap"}));
}

TEST(BoardKind, WhatOtherBoardsHaveIsNotLeftOutSilently) {
  BoardKind board;
  board.side = 0.4;
  board.columns = 9;
  board.rows = 6;
  EXPECT_TRUE(refusesBoard(board, {"--board-size 9x6", "markers has none"}));
  board = chessboardOf(9, 6);
  board.family = "tag36h11";
  EXPECT_TRUE(refusesBoard(board, {"--board-family tag36h11", "chessboard has none"}));
  board = chessboardOf(9, 6);
  board.marker = 0.02;
  EXPECT_TRUE(refusesBoard(board, {"--board-marker 0.02"}));
  board = chessboardOf(9, 6);
  board.legacy = true;
  EXPECT_TRUE(refusesBoard(board, {"--board-legacy"}));
  board = charucoOf(5, 7);
  board.gap = 0.01;
  EXPECT_TRUE(refusesBoard(board, {"--board-gap 0.01"}));
}

TEST(BoardKind, ThePatternThatIsTakenForGrantedIsSaidWhereThereAreTwo) {
  EXPECT_EQ(io::assumptionAbout(charucoOf(5, 7)), "");
  BoardKind board = charucoOf(5, 8);
  EXPECT_NE(io::assumptionAbout(board).find("black"), std::string::npos);
  board.legacy = true;
  EXPECT_NE(io::assumptionAbout(board).find("white"), std::string::npos);
}

}  // namespace
