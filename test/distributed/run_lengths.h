#pragma once

#include <fuse_flow/distributed/codec.h>

#include <algorithm>

namespace ranks {

/** \brief A codec of a page, for builds without Zstandard, and to see that any serves: a number n < 128 and n + 1 bytes that differ, or a
 *  number n >= 128 and one byte that stands n − 125 times. */
class RunLengths : public fuse_flow::distributed::Codec {
 public:
  std::uint32_t format() const override { return 1; }

  void compress(const char* data, std::size_t n, fuse_flow::distributed::Message& coded) const override {
    std::size_t first = 0;  // of what differs
    const auto put_others = [&](std::size_t end) {
      while (first < end) {
        const std::size_t count = std::min<std::size_t>(end - first, 128);
        coded.push_back(static_cast<char>(count - 1));
        coded.insert(coded.end(), data + first, data + first + count);
        first += count;
      }
    };
    for (std::size_t k = 0; k < n;) {
      std::size_t run = 1;
      while (run < 130 && k + run < n && data[k + run] == data[k]) ++run;
      if (run >= 3) {
        put_others(k);
        coded.push_back(static_cast<char>(run + 125));
        coded.push_back(data[k]);
        first = k + run;
      }
      k += run;
    }
    put_others(n);
  }

  bool decompress(const char* coded, std::size_t size, char* to, std::size_t n) const override {
    std::size_t written = 0;
    for (std::size_t k = 0; k < size;) {
      const std::size_t number = static_cast<unsigned char>(coded[k++]);
      const bool run = number >= 128;
      const std::size_t count = run ? number - 125 : number + 1, takes = run ? 1 : count;
      if (takes > size - k || count > n - written) return false;
      for (std::size_t b = 0; b < count; ++b) to[written++] = coded[run ? k : k + b];
      k += takes;
    }
    return written == n;
  }
};

}  // namespace ranks
