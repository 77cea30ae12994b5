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

/** \brief Levenshtein's: how many letters are to be added, left out or changed. */
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] != b[j - 1] ? 1 : 0);
      diagonal = row[j];
      row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
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
