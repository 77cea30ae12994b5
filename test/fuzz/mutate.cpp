#include "mutate.h"

#include <algorithm>
#include <array>

namespace fuse_flow_fuzz {
namespace {

constexpr std::size_t kLongest = 1 << 16;  // bytes

const std::vector<std::string>& words() {
  static const std::vector<std::string> all{
      "0",   "-1",  "1e308", "1e-308", "nan",    "inf",        "2147483647",           "-2147483648",
      "255", "256", "65536", "1e9",    "0x7fff", "4294967296", "18446744073709551615", "\n",
      " ",   "\"",  "[",     "}",      ",",      "%"};
  return all;
}

const std::array<std::uint64_t, 12>& numbers() {
  static const std::array<std::uint64_t, 12> all{
      0, 1, 0x7f, 0x80, 0xff, 0x7fff, 0x8000, 0xffff, 0x7fffffff, 0x80000000, 0xffffffff, 0x7fffffffffffffff};
  return all;
}

}  // namespace

std::string Mutator::mutant(const std::vector<std::string>& seeds) {
  std::string input = seeds.empty() ? std::string() : seeds[below(seeds.size())];
  for (std::size_t changes = 1 + below(8); changes > 0; --changes) change(input, seeds);
  if (input.size() > kLongest) input.resize(kLongest);
  return input;
}

void Mutator::change(std::string& input, const std::vector<std::string>& seeds) {
  const std::size_t at = below(input.size() + 1), left = input.size() - at;
  switch (below(8)) {
    case 0:  // a bit
      if (left > 0) input[at] = static_cast<char>(input[at] ^ (1 << below(8)));
      break;
    case 1:  // a byte
      if (left > 0) input[at] = static_cast<char>(engine_());
      break;
    case 2: {  // a number of 1, 2, 4 or 8 bytes, in either order
      std::uint64_t number = numbers()[below(numbers().size())];
      std::string bytes;
      for (std::size_t k = std::size_t{1} << below(4); k > 0; --k, number >>= 8) bytes += static_cast<char>(number);
      if (below(2) == 0) std::reverse(bytes.begin(), bytes.end());
      input.replace(at, std::min(left, bytes.size()), bytes);
      break;
    }
    case 3: {  // a word in the place of one
      const auto is_number = [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-'; };
      std::size_t end = at;
      while (end < input.size() && is_number(input[end])) ++end;
      input.replace(at, end - at, words()[below(words().size())]);
      break;
    }
    case 4:
      input.insert(at, 1 + below(16), static_cast<char>(engine_()));
      break;
    case 5:
      input.erase(at, 1 + below(std::min<std::size_t>(64, left + 1)));
      break;
    case 6: {  // a piece of another
      if (seeds.empty()) break;
      const std::string& other = seeds[below(seeds.size())];
      const std::size_t from = below(other.size() + 1);
      const std::string piece = other.substr(from, below(std::min<std::size_t>(256, other.size() - from) + 1));
      if (below(2) == 0)
        input.insert(at, piece);
      else
        input.replace(at, std::min(left, piece.size()), piece);
      break;
    }
    default:  // cut short, seldom, as then most of an input is gone
      if (below(4) == 0) input.resize(at);
  }
}

}  // namespace fuse_flow_fuzz
