#include "recordings/image_folders/name_number.h"

#include <algorithm>
#include <charconv>

namespace fuse_flow::io {

std::optional<std::size_t> wholeNumber(const std::string& text) {
  std::size_t value = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error != std::errc() || end != last) return std::nullopt;
  return value;
}

std::vector<std::size_t> numbersIn(const std::string& stem) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::vector<std::size_t> numbers;
  for (auto at = std::find_if(stem.begin(), stem.end(), is_digit); at != stem.end();
       at = std::find_if(at, stem.end(), is_digit)) {
    const auto end = std::find_if_not(at, stem.end(), is_digit);
    if (const auto number = wholeNumber(std::string(at, end))) numbers.push_back(*number);
    at = end;
  }
  return numbers;
}

}  // namespace fuse_flow::io
