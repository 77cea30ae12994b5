#include "recordings/range.h"

#include "io_fixture.h"

namespace {

using namespace io_test;
using Numbers = std::vector<std::size_t>;

TEST(Range, ARangeHasItsStepAndLeavesOutItsEnd) {
  EXPECT_EQ(io::parseRange("0:160:20", 1000), (Numbers{0, 20, 40, 60, 80, 100, 120, 140}));
  EXPECT_EQ(io::parseRange("0:161:20", 1000).back(), 160u);
  EXPECT_EQ(io::parseRange("3:5", 10), (Numbers{3, 4}));
  EXPECT_EQ(io::parseRange("7:8:100", 10), (Numbers{7}));
}

TEST(Range, WhatIsLeftOutIsTheBeginningTheEndAndOne) {
  EXPECT_EQ(io::parseRange(":", 3), (Numbers{0, 1, 2}));
  EXPECT_EQ(io::parseRange("::", 3), (Numbers{0, 1, 2}));
  EXPECT_EQ(io::parseRange("::2", 5), (Numbers{0, 2, 4}));
  EXPECT_EQ(io::parseRange("2:", 5), (Numbers{2, 3, 4}));
  EXPECT_EQ(io::parseRange(":2", 5), (Numbers{0, 1}));
}

TEST(Range, ARangeStopsWhereTheRecordingDoes) { EXPECT_EQ(io::parseRange("1:1000000", 3), (Numbers{1, 2})); }

TEST(Range, AListKeepsItsOrder) {
  EXPECT_EQ(io::parseRange("0,60,120", 121), (Numbers{0, 60, 120}));
  EXPECT_EQ(io::parseRange("5,1,3", 6), (Numbers{5, 1, 3}));
  EXPECT_EQ(io::parseRange("4", 5), (Numbers{4}));
}

TEST(Range, NumbersAsLargeAsTheyGetAreNoTrouble) {
  const std::string largest = "18446744073709551615";
  EXPECT_EQ(io::parseRange("0:" + largest + ":" + largest, 5), (Numbers{0}));
  EXPECT_TRUE(refuses<io::OptionError>([&] { io::parseRange(largest + ":", 5); }, {"none of the 5"}));
  EXPECT_TRUE(refuses<io::OptionError>([&] { io::parseRange(largest + "0", 5); }, {"not a whole number"}));
}

TEST(Range, WhatIsWrongIsNamedWithTheOption) {
  const std::vector<std::pair<std::string, std::string>> wrong = {{"", "'' is not a whole number"},
                                                                  {"1,,2", "'' is not a whole number"},
                                                                  {"1,", "'' is not a whole number"},
                                                                  {"-1", "'-1' is not a whole"},
                                                                  {"1.5", "'1.5' is not a whole"},
                                                                  {"0, 1", "' 1' is not a whole"},
                                                                  {"a:5", "'a' is not a whole"},
                                                                  {"0:5:x", "'x' is not a whole"},
                                                                  {"0:5:0", "the step is 0"},
                                                                  {"0:5:-1", "'-1' is not a whole"},
                                                                  {"0:1:2:3", "more than three parts"},
                                                                  {"5:5", "none of the 9"},
                                                                  {"6:2", "none of the 9"},
                                                                  {"0,9", "9 is not there"},
                                                                  {"9:", "none of the 9"},
                                                                  {"5,1,5", "5 is there twice"},
                                                                  {"0:4,7", "'4,7' is not a whole"}};
  for (const auto& [spec, problem] : wrong)
    EXPECT_TRUE(refuses<io::OptionError>([&, spec = spec] { io::parseRange(spec, 9, "--views"); },
                                         {"--views " + spec, problem, "A:B:STEP"}))
        << spec;
}

}  // namespace
