#include "recordings/image_folders/timestamps_file.h"

#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"
#include "recordings/image_folders/name_number.h"
#include "recordings/image_folders/stamp_unit.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

struct Line {
  std::size_t number;
  std::vector<std::string> words;
};

constexpr const char* kForm = "must be a time, or a time and the name of an image";

std::vector<Line> readLines(const std::string& path) {
  std::string text = readText(path);
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream lines(text);
  std::vector<Line> result;
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream words(line);
    Line entry{number, {}};
    for (std::string word; words >> word;) entry.words.push_back(word);
    if (entry.words.empty() || entry.words[0][0] == '#') continue;
    if (entry.words.size() > 2 || (!result.empty() && entry.words.size() != result[0].words.size()))
      throw InputError(path + ": line " + std::to_string(number) + " is '" + cutShort(line) + "', " + kForm +
                       ", as in the other lines");
    result.push_back(std::move(entry));
  }
  if (result.empty()) throw InputError(path + ": has no time; its lines " + kForm);
  return result;
}

/** \brief Finds an image by what a list may call it. */
class ImagesByName {
 public:
  explicit ImagesByName(const NamedImages& images) {
    for (std::size_t k = 0; k < images.images.size(); ++k) {
      const NamedImage& image = images.images[k];
      places_.emplace(image.name, k);
      places_.emplace(fs::path(image.name).stem().string(), k);
      if (image.number) numbers_.emplace(*image.number, k);
    }
  }
  std::optional<std::size_t> find(const std::string& word) const {
    const std::string name = fs::path(word).filename().string();
    if (const auto found = places_.find(name); found != places_.end()) return found->second;
    const std::optional<std::size_t> number = wholeNumber(name);
    const auto found = number ? numbers_.find(*number) : numbers_.end();
    return found == numbers_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::map<std::string, std::size_t> places_;
  std::map<std::size_t, std::size_t> numbers_;
};

/** \brief The word of a line that is the time: the one that names fewer images. */
std::size_t columnOfTimes(const std::vector<Line>& lines, const ImagesByName& images) {
  if (lines[0].words.size() == 1) return 0;
  std::size_t named[2] = {0, 0};
  for (const Line& line : lines)
    for (const std::size_t column : {0, 1}) named[column] += images.find(line.words[column]) ? 1 : 0;
  return named[0] >= named[1] ? 1 : 0;
}

std::vector<long double> numbersOf(const std::string& path, const std::vector<Line>& lines, std::size_t column) {
  std::vector<long double> numbers;
  for (const Line& line : lines) {
    const char* const word = line.words[column].c_str();
    char* end = nullptr;
    numbers.push_back(std::strtold(word, &end));
    if (end == word || *end != '\0' || !(numbers.back() >= 0 && numbers.back() < 9.2e18L))
      throw InputError(path + ": line " + std::to_string(line.number) + " has '" + cutShort(word) +
                       "' where others have their time; a line " + kForm);
  }
  return numbers;
}

}  // namespace

void readTimestamps(const std::string& path, NamedImages& images, std::vector<std::string>& warnings) {
  const std::vector<Line> lines = readLines(path);
  const ImagesByName by_name(images);
  const std::size_t column = columnOfTimes(lines, by_name);
  const std::vector<long double> numbers = numbersOf(path, lines, column);
  const StampUnit unit = stampUnit(*std::max_element(numbers.begin(), numbers.end()));
  const bool named = lines[0].words.size() == 2;
  if (!named && lines.size() != images.images.size())
    throw InputError(path + ": has " + std::to_string(lines.size()) + " times, must have one for each of the " +
                     std::to_string(images.images.size()) + " images of " + images.folder + ", or their names, too");
  std::vector<bool> has_time(images.images.size(), false);
  std::size_t gone = 0;
  std::string first_gone;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const std::optional<Nanoseconds> stamp = inNanoseconds(numbers[k], unit);
    if (!stamp) throw InputError(path + ": line " + std::to_string(lines[k].number) + " is no time in " + unit.name);
    const std::optional<std::size_t> place = named ? by_name.find(lines[k].words[1 - column]) : std::optional(k);
    if (!place) {
      if (gone++ == 0) first_gone = lines[k].words[1 - column];
      continue;
    }
    if (has_time[*place])
      throw InputError(path + ": line " + std::to_string(lines[k].number) + " names " + images.images[*place].name +
                       " a second time");
    has_time[*place] = true;
    images.images[*place].stamp = stamp;
  }
  if (gone == lines.size())
    throw InputError(path + ": names no image of " + images.folder + ", but such as " + cutShort(first_gone));
  if (gone > 0)
    warnings.push_back(path + ": " + std::to_string(gone) + " of " + std::to_string(lines.size()) +
                       " lines name images that are not in " + images.folder + ", such as " + cutShort(first_gone));
  const auto without = std::find(has_time.begin(), has_time.end(), false);
  if (without != has_time.end())
    warnings.push_back(path + ": " + std::to_string(std::count(without, has_time.end(), false)) + " of " +
                       std::to_string(has_time.size()) + " images of " + images.folder +
                       " have no line, and are left out, such as " +
                       images.images[static_cast<std::size_t>(without - has_time.begin())].name);
  std::vector<NamedImage> timed;
  for (std::size_t k = 0; k < has_time.size(); ++k)
    if (has_time[k]) timed.push_back(std::move(images.images[k]));
  images.images = std::move(timed);
  if (!images.numbered())
    std::stable_sort(images.images.begin(), images.images.end(),
                     [](const NamedImage& a, const NamedImage& b) { return *a.stamp < *b.stamp; });
  images.times_from = path + ", in " + unit.name;
}

}  // namespace fuse_flow::io
