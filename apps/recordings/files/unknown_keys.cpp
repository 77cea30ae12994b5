#include "recordings/files/unknown_keys.h"

#include <algorithm>
#include <cctype>

namespace fuse_flow::io {
namespace {

/** \brief In small letters, without what separates words: "TWorldCamera" and "t_world_camera" are one. */
std::string plain(const std::string& name) {
  std::string result;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)))
      result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

/** \brief How many letters are to be added, left out, changed, or exchanged with the next one. */
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before_last, last, row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before_last = std::move(last);
    last = row;
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j - 1] + (a[i - 1] != b[j - 1] ? 1 : 0), last[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row.back();
}

}  // namespace

std::string likelyMeant(const std::string& name, const std::vector<std::string>& known,
                        const std::vector<std::pair<std::string, std::string>>& aliases) {
  const std::string wanted = plain(name.substr(0, 80));  // no longer name is like one of ours
  for (const auto& [alias, meant] : aliases)
    if (plain(alias) == wanted) return meant;
  std::string best;
  std::size_t least = std::max<std::size_t>(1, wanted.size() / 4) + 1;
  for (const std::string& key : known)
    if (const std::size_t apart = distance(wanted, plain(key)); apart < least) {
      least = apart;
      best = key;
    }
  return best;
}

}  // namespace fuse_flow::io
