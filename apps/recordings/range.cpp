#include "recordings/range.h"

#include "recordings/image_folders/name_number.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <optional>

namespace fuse_flow::io {
namespace {

std::vector<std::string> split(const std::string& text, char mark) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find(mark, begin)) != std::string::npos; begin = end + 1)
    parts.push_back(text.substr(begin, end - begin));
  parts.push_back(text.substr(begin));
  return parts;
}

/** \brief An option's text, for messages about it. */
struct Spec {
  const std::string& option;
  const std::string& text;

  OptionError fail(const std::string& problem) const {
    return OptionError(option + " " + text + ": " + problem + "; write numbers as 0,60,120 or a range as A:B:STEP");
  }
  std::size_t number(const std::string& word) const {
    const std::optional<std::size_t> value = wholeNumber(word);
    if (!value) throw fail("'" + word + "' is not a whole number from 0 up");
    return *value;
  }
  bool isRange() const { return text.find(':') != std::string::npos; }
};

/** \brief Every step-th number from begin to below end. */
struct Slice {
  std::size_t begin, end, step;
};

Slice parseSlice(const Spec& spec, std::size_t count) {
  const std::vector<std::string> parts = split(spec.text, ':');
  if (parts.size() > 3) throw spec.fail("has more than three parts");
  const std::size_t begin = parts[0].empty() ? 0 : spec.number(parts[0]);
  const std::size_t end = parts[1].empty() ? count : spec.number(parts[1]);
  const std::size_t step = parts.size() < 3 || parts[2].empty() ? 1 : spec.number(parts[2]);
  if (step == 0) throw spec.fail("the step is 0, must be 1 or more");
  return {begin, std::min(end, count), std::min(step, count + 1)};  // no overflow where they are added up
}

std::vector<std::size_t> parseList(const Spec& spec) {
  std::vector<std::size_t> numbers;
  for (const std::string& part : split(spec.text, ',')) numbers.push_back(spec.number(part));
  std::vector<std::size_t> sorted = numbers;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) throw spec.fail(std::to_string(*twice) + " is there twice, must be there once");
  return numbers;
}

}  // namespace

std::vector<std::size_t> parseRange(const std::string& text, std::size_t count, const std::string& option) {
  const Spec spec{option, text};
  if (spec.isRange()) {
    const Slice slice = parseSlice(spec, count);
    std::vector<std::size_t> numbers;
    for (std::size_t i = slice.begin; i < slice.end; i += slice.step) numbers.push_back(i);
    if (numbers.empty()) throw spec.fail("names none of the " + std::to_string(count));
    return numbers;
  }
  const std::vector<std::size_t> numbers = parseList(spec);
  for (const std::size_t number : numbers)
    if (number >= count)
      throw spec.fail(std::to_string(number) + " is not there, numbers go from 0 to below " + std::to_string(count));
  return numbers;
}

std::vector<std::size_t> parseRangeOf(const std::string& text, const std::vector<std::size_t>& numbers,
                                      const std::string& option) {
  const Spec spec{option, text};
  if (spec.isRange()) {
    const Slice slice = parseSlice(spec, numbers.empty() ? 0 : numbers.back() + 1);
    std::vector<std::size_t> chosen;
    for (const std::size_t number : numbers)
      if (number >= slice.begin && number < slice.end && (number - slice.begin) % slice.step == 0)
        chosen.push_back(number);
    if (chosen.empty()) throw spec.fail("names none of the " + listFrames(numbers));
    return chosen;
  }
  const std::vector<std::size_t> chosen = parseList(spec);
  for (const std::size_t number : chosen)
    if (!std::binary_search(numbers.begin(), numbers.end(), number))
      throw spec.fail(std::to_string(number) + " is not there, only " + listFrames(numbers));
  return chosen;
}

std::string listFrames(const std::vector<std::size_t>& numbers) {
  std::string list = std::to_string(numbers.size()) + (numbers.size() == 1 ? " frame: " : " frames: ");
  const std::size_t first = std::min<std::size_t>(3, numbers.size());
  for (std::size_t k = 0; k < first; ++k) list += (k > 0 ? ", " : "") + std::to_string(numbers[k]);
  if (numbers.size() > first) list += (numbers.size() > first + 1 ? " ... " : ", ") + std::to_string(numbers.back());
  return list;
}

}  // namespace fuse_flow::io
