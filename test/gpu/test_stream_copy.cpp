#include <fuse_flow/gpu/runtime/stream_copy.h>

#include <gtest/gtest.h>

#include <vector>

namespace {

TEST(StreamCopy, CopiesAllBytesAndNoOthersFromAnyPlaceToAnyPlace) {
  constexpr std::size_t size = 600;
  std::vector<unsigned char> from(size);
  for (std::size_t k = 0; k < size; ++k) from[k] = static_cast<unsigned char>(1 + k % 251);
  for (std::size_t begin = 0; begin < 66; ++begin)
    for (const std::size_t source : {std::size_t{0}, std::size_t{1}, std::size_t{24}})
      for (const std::size_t count : {0, 1, 15, 63, 64, 65, 127, 128, 200, 448}) {
        std::vector<unsigned char> to(size, 0);
        fuse_flow::gpu::streamCopy(to.data() + begin, from.data() + source, count);
        for (std::size_t k = 0; k < size; ++k) {
          const bool copied = k >= begin && k < begin + count;
          ASSERT_EQ(to[k], copied ? from[source + k - begin] : 0) << "byte " << k << " of " << count << " to " << begin;
        }
      }
}

}  // namespace
