#include <fuse_flow/math/color_depth.h>

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

// A z-buffer over the image of a colour camera.

namespace {

using namespace fuse_flow;

Intrinsics image(int width, int height, float f) {
  return {width, height, f, f, static_cast<float>(width - 1) / 2, static_cast<float>(height - 1) / 2, {}};
}

/** \brief Cells of four pixels of colour: six columns and four rows. */
ColorDepth sixByFour() { return ColorDepth::of(image(20, 12, 400), image(10, 6, 100)); }

/** \brief The cells of a measurement, with its depth in each. */
std::map<std::size_t, float> cellsOf(const ColorDepth& cells, const Pixel& pixel, float z = 1.5f) {
  std::map<std::size_t, float> put;
  cells.add(pixel, z, [&](std::size_t cell, std::uint32_t bits) { put[cell] = ColorDepth::fromBits(bits); });
  return put;
}

std::vector<std::size_t> numbersOf(const std::map<std::size_t, float>& cells) {
  std::vector<std::size_t> numbers;
  for (const auto& cell : cells) numbers.push_back(cell.first);
  return numbers;
}
using Numbers = std::vector<std::size_t>;

TEST(ColorDepth, ItsCellsAreAsLargeAsAPixelOfDepthAndCoverTheImage) {
  const ColorDepth cells = sixByFour();
  EXPECT_EQ(cells.cells_per_pixel, 0.25f);
  EXPECT_EQ(cells.columns, 6);
  EXPECT_EQ(cells.rows, 4);
  EXPECT_EQ(cells.size(), 24u);
  EXPECT_FLOAT_EQ(cells.margin, 0.01f + 6.0f / 100);
}

TEST(ColorDepth, ACellIsNeverSmallerThanAPixelOfColour) {
  for (const float f : {100.0f, 50.0f}) {
    const ColorDepth cells = ColorDepth::of(image(20, 12, f), image(10, 6, 100));
    EXPECT_EQ(cells.cells_per_pixel, 1.0f);
    EXPECT_EQ(cells.columns, 21);
    EXPECT_EQ(cells.rows, 13);
  }
}

TEST(ColorDepth, AMeasurementCountsInTheFourCellsNearestToIt) {
  // The centre of pixel (7.5, 7.5) is the corner (8, 8), of the cells 1 and 2 in both directions.
  EXPECT_EQ(numbersOf(cellsOf(sixByFour(), {7.5f, 7.5f})), (Numbers{7, 8, 13, 14}));
  // A little left and above; a little right and below: still nearest to those.
  EXPECT_EQ(numbersOf(cellsOf(sixByFour(), {6, 6})), (Numbers{7, 8, 13, 14}));
  EXPECT_EQ(numbersOf(cellsOf(sixByFour(), {9, 9})), (Numbers{7, 8, 13, 14}));
  // Beyond the middle of a cell, which is pixel 5.5 or 9.5.
  EXPECT_EQ(numbersOf(cellsOf(sixByFour(), {5, 7.5f})), (Numbers{6, 7, 12, 13}));
  EXPECT_EQ(numbersOf(cellsOf(sixByFour(), {7.5f, 5})), (Numbers{1, 2, 7, 8}));
  for (const auto& cell : cellsOf(sixByFour(), {7.5f, 7.5f}, 2.25f)) EXPECT_EQ(cell.second, 2.25f);
}

TEST(ColorDepth, AtTheBordersThereAreFewerCells) {
  const ColorDepth cells = sixByFour();
  EXPECT_EQ(numbersOf(cellsOf(cells, {0, 0})), (Numbers{0}));
  EXPECT_EQ(numbersOf(cellsOf(cells, {-2, 0})), (Numbers{0})) << "beside the image, nearest to its first cell";
  EXPECT_EQ(numbersOf(cellsOf(cells, {0, 7.5f})), (Numbers{6, 12}));
  EXPECT_EQ(numbersOf(cellsOf(cells, {7.5f, 0})), (Numbers{1, 2}));
  EXPECT_EQ(numbersOf(cellsOf(cells, {22.5f, 14.5f})), (Numbers{23})) << "the last cell";
  // −1 and columns, rows: no cell is near.
  for (const Pixel& outside : {Pixel{-2.5f, 5}, Pixel{5, -2.5f}, Pixel{25.5f, 5}, Pixel{5, 17.5f}, Pixel{1e30f, 5},
                               Pixel{-1e30f, 5}, Pixel{NAN, 5}, Pixel{5, NAN}})
    EXPECT_TRUE(cellsOf(cells, outside).empty()) << outside.u << ", " << outside.v;
}

TEST(ColorDepth, HidesWhatIsFartherByMoreThanTheMargin) {
  ColorDepth cells = sixByFour();
  cells.margin = 0.25f;
  std::vector<std::uint32_t> nearest(cells.size(), ColorDepth::kNothing);
  nearest[2 * 6 + 1] = ColorDepth::bitsOf(1.5f);
  cells.nearest = nearest.data();
  // Of the cell in column 1 and row 2: pixels 3.5 to 7.5, 7.5 to 11.5.
  EXPECT_FALSE(cells.hides({5, 9}, 2)) << "nearer by just the margin";
  EXPECT_TRUE(cells.hides({5, 9}, 2.01f));
  EXPECT_FALSE(cells.hides({5, 9}, 1.0f));
  EXPECT_TRUE(cells.hides({3.5f, 7.5f}, 4)) << "its corner";
  EXPECT_TRUE(cells.hides({7.4f, 11.4f}, 4));
  EXPECT_FALSE(cells.hides({3.4f, 9}, 4)) << "left of it";
  EXPECT_FALSE(cells.hides({7.5f, 9}, 4)) << "right of it";
  EXPECT_FALSE(cells.hides({5, 7.4f}, 4)) << "above";
  EXPECT_FALSE(cells.hides({5, 11.5f}, 4)) << "below";
}

TEST(ColorDepth, BeyondItsCellsNothingIsHidden) {
  ColorDepth cells = sixByFour();
  // Rows of cells around it, so that a cell that is not asked for is no accident of the memory.
  std::vector<std::uint32_t> memory(3 * cells.size(), ColorDepth::bitsOf(0.1f));
  cells.nearest = memory.data() + cells.size();
  EXPECT_TRUE(cells.hides({-0.5f, -0.5f}, 4)) << "the corner of the first";
  EXPECT_TRUE(cells.hides({23.4f, 15.4f}, 4)) << "the last";
  for (const Pixel& outside :
       {Pixel{-0.6f, 5}, Pixel{5, -0.6f}, Pixel{23.5f, 5}, Pixel{5, 15.5f}, Pixel{NAN, 5}, Pixel{5, NAN}})
    EXPECT_FALSE(cells.hides(outside, 4)) << outside.u << ", " << outside.v;
  cells.nearest = nullptr;
  EXPECT_FALSE(cells.hides({5, 5}, 4));
}

}  // namespace
