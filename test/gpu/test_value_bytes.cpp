#include <fuse_flow/gpu/runtime/value_bytes.h>

#include <gtest/gtest.h>

#include <cstring>
#include <new>

namespace {

struct Step {
  const float* from;
  unsigned int count;  // four bytes of nothing after it
};
static_assert(sizeof(Step) > sizeof(float*) + sizeof(unsigned int));

std::vector<char> bytesOf(const Step& value, int between) {
  alignas(Step) unsigned char memory[sizeof(Step)];
  std::memset(memory, between, sizeof memory);
  Step* step = new (memory) Step;
  step->from = value.from;
  step->count = value.count;
  std::vector<char> bytes;
  fuse_flow::gpu::appendBytes(*step, bytes);
  return bytes;
}

TEST(ValueBytes, AreEqualForEqualValuesWhateverLiesBetweenTheirMembers) {
#if defined(__clang__)
  GTEST_SKIP() << "clang cannot tell what lies between members";
#endif
  const float number = 0;
  EXPECT_EQ(bytesOf({&number, 7}, 0), bytesOf({&number, 7}, 0xff));
}

TEST(ValueBytes, DifferForDifferentValues) {
  const float numbers[2] = {};
  EXPECT_NE(bytesOf({numbers, 7}, 0), bytesOf({numbers, 8}, 0));
  EXPECT_NE(bytesOf({numbers, 7}, 0), bytesOf({numbers + 1, 7}, 0));
}

TEST(ValueBytes, FollowEachOther) {
  std::vector<char> bytes;
  for (const unsigned char value : {1, 2, 3}) fuse_flow::gpu::appendBytes(value, bytes);
  EXPECT_EQ(bytes, (std::vector<char>{1, 2, 3}));
}

}  // namespace
