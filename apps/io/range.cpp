#include "io/range.h"

#include "io/error.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace fuse_flow::io {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find(separator, begin)) != std::string::npos; begin = end + 1)
    parts.push_back(text.substr(begin, end - begin));
  parts.push_back(text.substr(begin));
  return parts;
}

std::optional<std::size_t> number(const std::string& text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::vector<std::size_t> parseRange(const std::string& spec, std::size_t count, const std::string& option) {
  const auto fail = [&](const std::string& problem) -> OptionError {
    return OptionError(option + " " + spec + ": " + problem + "; write numbers as 0,60,120 or a range as A:B:STEP");
  };
  const auto checkedNumber = [&](const std::string& text) {
    const std::optional<std::size_t> value = number(text);
    if (!value) throw fail("'" + text + "' is not a whole number from 0 up");
    return *value;
  };

  std::vector<std::size_t> numbers;
  if (spec.find(':') != std::string::npos) {
    const std::vector<std::string> parts = split(spec, ':');
    if (parts.size() > 3) throw fail("has more than three parts");
    const std::size_t begin = parts[0].empty() ? 0 : checkedNumber(parts[0]);
    const std::size_t end = parts[1].empty() ? count : checkedNumber(parts[1]);
    std::size_t step = parts.size() < 3 || parts[2].empty() ? 1 : checkedNumber(parts[2]);
    if (step == 0) throw fail("the step is 0, must be 1 or more");
    step = std::min(step, count + 1);  // no overflow below
    for (std::size_t i = begin; i < end && i < count; i += step) numbers.push_back(i);
    if (numbers.empty()) throw fail("names none of the " + std::to_string(count));
    return numbers;
  }
  for (const std::string& part : split(spec, ',')) {
    numbers.push_back(checkedNumber(part));
    if (numbers.back() >= count)
      throw fail(part + " is not there, numbers go from 0 to below " + std::to_string(count));
  }
  std::vector<std::size_t> sorted = numbers;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) throw fail(std::to_string(*twice) + " is there twice, must be there once");
  return numbers;
}

}  // namespace fuse_flow::io
