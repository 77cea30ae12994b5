#include "stream/network/text.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace fuse_flow::stream::network {

namespace {

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

constexpr std::size_t kMostLines = 100;

}  // namespace

std::string printable(std::string_view text, std::size_t most) {
  std::string line(text.substr(0, most));
  for (char& c : line)
    if (c < ' ' || c > '~') c = '?';
  if (text.size() > most) line += "…";
  return line;
}

std::optional<std::string> percentDecoded(std::string_view text) {
  std::string decoded;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (text[k] != '%') {
      decoded += text[k];
      continue;
    }
    if (text.size() - k < 3) return std::nullopt;
    const int high = hexDigit(text[k + 1]), low = hexDigit(text[k + 2]);
    if (high < 0 || low < 0) return std::nullopt;
    decoded += static_cast<char>(16 * high + low);
    k += 2;
  }
  return decoded;
}

std::optional<std::string> queryValue(std::string_view query, std::string_view name) {
  while (!query.empty()) {
    const std::size_t end = std::min(query.find('&'), query.size());
    const std::string_view pair = query.substr(0, end);
    if (pair.size() > name.size() && pair[name.size()] == '=' && pair.substr(0, name.size()) == name)
      return percentDecoded(pair.substr(name.size() + 1));
    query.remove_prefix(std::min(end + 1, query.size()));
  }
  return std::nullopt;
}

bool sameWithoutCase(std::string_view a, std::string_view b) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [](char x, char y) { return lower(x) == lower(y); });
}

bool isToken(std::string_view token) {
  return token.size() >= 16 && token.size() <= 256 && std::all_of(token.begin(), token.end(), [](char c) {
           const char l = lower(c);
           return (l >= 'a' && l <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '_' || c == '~';
         });
}

std::int64_t nanosecondsSince1970() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

void Notices::add(std::string line) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (lines_.size() < kMostLines)
    lines_.push_back(std::move(line));
  else
    ++more_;
}

std::vector<std::string> Notices::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::string> lines = std::exchange(lines_, {});
  if (const std::size_t more = std::exchange(more_, 0); more > 0)
    lines.push_back("and " + std::to_string(more) + " notices more");
  return lines;
}

}  // namespace fuse_flow::stream::network
