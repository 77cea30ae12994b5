#include "command_line/arguments/option_checks.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cfloat>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>

namespace fuse_flow::command_line {
namespace {

/** \brief Nothing, too, for a number that in single precision, as most parameters are, would be infinite or 0. */
std::optional<double> finiteValue(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  if (std::fabs(value) > FLT_MAX || (value != 0 && std::fabs(value) < FLT_MIN)) return std::nullopt;
  return value;
}

CLI::Validator oneOfWords(const std::string& expected, const std::vector<std::string>& words) {
  return makeCheck(expected,
                   [=](const std::string& text) { return std::find(words.begin(), words.end(), text) != words.end(); });
}

}  // namespace

CLI::Validator makeCheck(const std::string& expected, const std::function<bool(const std::string&)>& accepts) {
  return CLI::Validator(
      [=](std::string& text) {
        return accepts(text) ? std::string() : "'" + text + "' was given, must be " + expected;
      },
      "", "");
}

CLI::Validator finiteNumber() {
  return makeCheck("a number", [](const std::string& text) { return finiteValue(text).has_value(); });
}

CLI::Validator positiveNumber() {
  return makeCheck("a positive number", [](const std::string& text) { return finiteValue(text).value_or(0) > 0; });
}

CLI::Validator nonNegativeNumber() {
  return makeCheck("a number from 0 up", [](const std::string& text) { return finiteValue(text).value_or(-1) >= 0; });
}

CLI::Validator wholeNumber(int low, int high) {
  return makeCheck("a whole number from " + std::to_string(low) + " to " + std::to_string(high),
                   [=](const std::string& text) {
                     char* end = nullptr;
                     errno = 0;
                     const long value = std::strtol(text.c_str(), &end, 10);
                     return !text.empty() && *end == '\0' && errno == 0 && value >= low && value <= high;
                   });
}

CLI::Validator positiveNumberUpTo(double high) {
  std::ostringstream expected;
  expected << "a positive number up to " << high;
  return makeCheck(expected.str(), [=](const std::string& text) {
    const double value = finiteValue(text).value_or(0);
    return value > 0 && value <= high;
  });
}

CLI::Validator lengthUpTo(double metres) {
  std::ostringstream expected;
  expected << "a positive number of metres, " << metres << " or less";
  return makeCheck(expected.str(), [=](const std::string& text) {
    const double value = finiteValue(text).value_or(0);
    return value > 0 && value <= metres;
  });
}

CLI::Validator numberFromTo(double low, double high) {
  std::ostringstream expected;
  expected << "a number from " << low << " to " << high;
  return makeCheck(expected.str(), [=](const std::string& text) {
    const std::optional<double> value = finiteValue(text);
    return value && *value >= low && *value <= high;
  });
}

CLI::Validator oneOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return oneOfWords("one of " + list, names);
}

CLI::Validator trueOrFalse() { return oneOfWords("true or false, 1 or 0", {"true", "false", "1", "0"}); }

CLI::Validator path() {
  return makeCheck("a file or a folder, one whose name begins with a dash as in ./-name",
                   [](const std::string& text) { return !text.empty() && text[0] != '-'; });
}

CLI::Validator threadCount() { return wholeNumber(0, 1024); }

std::string withOptionNames(const std::string& message, const std::map<std::string, std::string>& option_of) {
  const std::size_t owner = message.find("fuse_flow::");
  const std::size_t begin = owner == std::string::npos ? 0 : message.find(": ", owner) + 2;
  std::string result, word;
  const std::string text = message.substr(begin) + "  ";
  for (std::size_t k = 0; k + 1 < text.size(); ++k) {
    const char c = text[k];
    const bool member = c == '.' && !word.empty() && std::isalpha(static_cast<unsigned char>(text[k + 1]));
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '_' || member) {
      word += c;
      continue;
    }
    std::string parameter = word;  // noise.floor is --noise-floor
    std::replace(parameter.begin(), parameter.end(), '.', '_');
    const auto option = option_of.find(parameter);
    result += (option == option_of.end() ? word : option->second) + c;
    word.clear();
  }
  result.pop_back();
  return result;
}

std::vector<std::string> givenBut(const CLI::App& app, const std::set<std::string>& with_effect) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    if (option->count() > 0 && with_effect.count(option->get_name()) == 0) names.push_back(option->get_name());
  return names;
}

std::string joinedList(std::string list) {
  std::replace(list.begin(), list.end(), '\n', ',');
  return list;
}

}  // namespace fuse_flow::command_line
