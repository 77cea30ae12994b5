#include <fuse_flow/impl/fusion/child_bits.hpp>

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <vector>

namespace {

using fuse_flow::host::ChildBits;

TEST(ChildBits, KnowWhatLiesAroundEveryChildAndNothingBeyondTheCell) {
  std::mt19937 random(5);
  ChildBits bits;
  for (const int level : {0, 3, 1, 5, 2, 4}) {  // larger and smaller ones: nothing of the last one stays
    const int side = 1 << level;
    const auto position = [&](int x, int y, int z) {
      return static_cast<std::uint32_t>(x | y << level | z << 2 * level);
    };
    bits.clear(level);
    struct Child {
      int x, y, z;
    };
    std::vector<Child> occupied;
    for (int round = 0; round < 4; ++round) {
      for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
          for (int z = 0; z < side; ++z) {
            bool expected = false;
            for (const Child& c : occupied)
              expected |= std::abs(c.x - x) <= 1 && std::abs(c.y - y) <= 1 && std::abs(c.z - z) <= 1;
            ASSERT_EQ(bits.anyAround(position(x, y, z)), expected) << level << ": " << x << ' ' << y << ' ' << z;
          }
      const auto any = [&] { return static_cast<int>(random() % static_cast<unsigned int>(side)); };
      const Child next = round == 0 ? Child{side - 1, 0, side - 1} : Child{any(), any(), any()};
      occupied.push_back(next);
      bits.set(position(next.x, next.y, next.z));
    }
  }
}

}  // namespace
