#pragma once

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace fuse_flow::io {

// CLI11's own checks let NaN pass, and print the largest double where they mean "no limit".

namespace detail {

inline std::optional<double> finiteValue(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

/** \brief A check whose message says what was given and what must be; empty if accepts(text). */
template <typename Accepts>
CLI::Validator makeCheck(const std::string& expected, Accepts accepts) {
  return CLI::Validator(
      [=](std::string& text) {
        return accepts(text) ? std::string() : "'" + text + "' was given, must be " + expected;
      },
      "", "");
}

}  // namespace detail

inline CLI::Validator finiteNumber() {
  return detail::makeCheck("a number", [](const std::string& text) { return detail::finiteValue(text).has_value(); });
}

inline CLI::Validator positiveNumber() {
  return detail::makeCheck("a positive number",
                           [](const std::string& text) { return detail::finiteValue(text).value_or(0) > 0; });
}

inline CLI::Validator nonNegativeNumber() {
  return detail::makeCheck("a number from 0 up",
                           [](const std::string& text) { return detail::finiteValue(text).value_or(-1) >= 0; });
}

inline CLI::Validator wholeNumber(int low, int high) {
  return detail::makeCheck("a whole number from " + std::to_string(low) + " to " + std::to_string(high),
                           [=](const std::string& text) {
                             char* end = nullptr;
                             errno = 0;
                             const long value = std::strtol(text.c_str(), &end, 10);
                             return !text.empty() && *end == '\0' && errno == 0 && value >= low && value <= high;
                           });
}

inline CLI::Validator positiveNumberUpTo(double high) {
  std::ostringstream expected;
  expected << "a positive number up to " << high;
  return detail::makeCheck(expected.str(), [=](const std::string& text) {
    const double value = detail::finiteValue(text).value_or(0);
    return value > 0 && value <= high;
  });
}

inline CLI::Validator oneOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return detail::makeCheck("one of " + list, [=](const std::string& text) {
    return std::find(names.begin(), names.end(), text) != names.end();
  });
}

inline CLI::Validator trueOrFalse() {
  return detail::makeCheck("true or false", [](const std::string& text) { return text == "true" || text == "false"; });
}

/** \brief More than any machine has cores; far more than OpenMP can start threads would end the program. */
inline CLI::Validator threadCount() { return wholeNumber(0, 1024); }

/** \brief A list that CLI11 joined line by line, as a config file's is split at its commas: with commas again. */
inline std::string joinedList(std::string list) {
  std::replace(list.begin(), list.end(), '\n', ',');
  return list;
}

}  // namespace fuse_flow::io
