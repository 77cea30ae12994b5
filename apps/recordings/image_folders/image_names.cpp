#include "recordings/image_folders/image_names.h"

#include "recordings/files/file_io.h"
#include "recordings/image_folders/name_number.h"
#include "recordings/image_folders/stamp_unit.h"
#include "recordings/readers/view_files.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <map>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool hasDecimals(const std::string& number) { return number.find('.') != std::string::npos; }

/** \brief In the pattern of a name the place of a number; no name of a file has it. */
constexpr char kNumberPlace[] = "/";

/** \brief A name taken apart: of "frame_0001" the pattern "frame_/" and the number "0001". */
struct SplitName {
  std::string name;
  std::string pattern;
  std::vector<std::string> numbers;
};

/** \brief Decimals belong to their number, unless a letter is before it: of "cam1.0001" 1 and 0001 are two. */
SplitName split(const std::string& name) {
  SplitName result{name, "", {}};
  const std::string stem = fs::path(name).stem().string();
  for (std::size_t at = 0; at < stem.size();) {
    if (!isDigit(stem[at])) {
      result.pattern += stem[at++];
      continue;
    }
    const auto behind = [&stem](std::size_t k) {
      while (k < stem.size() && isDigit(stem[k])) ++k;
      return k;
    };
    const bool after_letter = at > 0 && std::isalpha(static_cast<unsigned char>(stem[at - 1])) != 0;
    std::size_t end = behind(at);
    if (!after_letter && end + 1 < stem.size() && stem[end] == '.' && isDigit(stem[end + 1])) end = behind(end + 1);
    const std::string number = stem.substr(at, end - at);
    const bool readable = hasDecimals(number) || wholeNumber(number);  // 21 digits are neither
    if (readable) result.numbers.push_back(number);
    result.pattern += readable ? kNumberPlace : number;
    at = end;
  }
  return result;
}

using Group = std::vector<const SplitName*>;

/** \brief One of the numbers in the names of a group. */
struct Place {
  std::size_t index;
  bool differs;  ///< from name to name
  bool is_time;
};

std::vector<Place> placesOf(const std::string& folder, const Group& group) {
  std::vector<Place> places;
  for (std::size_t k = 0; k < group[0]->numbers.size(); ++k) {
    Place place{k, false, true};
    bool decimals = false, all_large = true, any_large = false;
    for (const SplitName* name : group) {
      const std::string& number = name->numbers[k];
      place.differs = place.differs || number != group[0]->numbers[k];
      decimals = decimals || hasDecimals(number);
      const bool large = std::strtold(number.c_str(), nullptr) >= kLeastStamp;
      all_large = all_large && large;
      any_large = any_large || large;
    }
    if (any_large && !all_large && !decimals)
      throw InputError(folder + ": of its images, " + group[0]->name +
                       " and others, some are named by a number and some by a time; must all be named in one way");
    place.is_time = decimals || all_large;
    places.push_back(place);
  }
  return places;
}

/** \brief Which of the places of one kind says it; none where there is none. */
std::optional<std::size_t> placeOf(const std::string& folder, const Group& group, const std::vector<Place>& places,
                                   bool is_time) {
  const bool any_differs = std::any_of(places.begin(), places.end(), [](const Place& place) { return place.differs; });
  std::vector<std::size_t> candidates;
  for (const Place& place : places)
    if (place.is_time == is_time && (place.differs || !any_differs)) candidates.push_back(place.index);
  if (candidates.empty()) return std::nullopt;
  if (candidates.size() == 1) return candidates[0];
  if (any_differs)
    throw InputError(folder + ": the names of its images, such as " + group[0]->name + " and " + group[1]->name +
                     ", differ in several numbers, must differ in one: that of the frame, or the time");
  const auto shorter = [&](std::size_t a, std::size_t b) {
    return group[0]->numbers[a].size() <= group[0]->numbers[b].size();  // of those as long the last
  };
  std::size_t longest = candidates[0];
  for (const std::size_t candidate : candidates)
    if (shorter(longest, candidate)) longest = candidate;
  return longest;
}

void readTimes(const Group& group, std::size_t place, NamedImages& result) {
  long double largest = 0;
  for (const SplitName* name : group) largest = std::max(largest, std::strtold(name->numbers[place].c_str(), nullptr));
  const StampUnit unit = stampUnit(largest);
  for (std::size_t k = 0; k < group.size(); ++k) {
    result.images[k].stamp = inNanoseconds(std::strtold(group[k]->numbers[place].c_str(), nullptr), unit);
    if (!result.images[k].stamp)
      throw InputError((fs::path(result.folder) / group[k]->name).string() + ": its name is no time in " + unit.name);
  }
  result.times_from = std::string("the names of images, in ") + unit.name;
}

InputError twoOfOne(const NamedImages& images, const std::string& kind, const NamedImage& a, const NamedImage& b) {
  return InputError(images.folder + ": has " + a.name + " and " + b.name + ", must have one " + kind + " image of a " +
                    (a.number ? "frame" : "time"));
}

/** \brief Brings images into their order, and takes of 7 and 000007 the usual one. */
void sortImages(NamedImages& images, const std::string& kind) {
  const bool numbered = images.numbered();
  std::stable_sort(images.images.begin(), images.images.end(), [numbered](const NamedImage& a, const NamedImage& b) {
    return numbered ? *a.number < *b.number : *a.stamp < *b.stamp;
  });
  std::vector<NamedImage> once;
  for (NamedImage& image : images.images) {
    const bool again =
        !once.empty() && (numbered ? once.back().number == image.number : once.back().stamp == image.stamp);
    if (!again) {
      once.push_back(std::move(image));
      continue;
    }
    const std::string stem = fs::path(image.name).stem().string();
    if (!images.plain || fs::path(once.back().name).stem().string() == stem)
      throw twoOfOne(images, kind, once.back(), image);
    if (stem == frameStem(*image.number)) once.back() = std::move(image);
  }
  images.images = std::move(once);
}

/** \brief The names that are a frame's number alone; where times are among them, they are as many. */
Group plainNames(const std::vector<SplitName>& names) {
  Group whole, all;
  for (const SplitName& name : names) {
    if (name.pattern != kNumberPlace) continue;
    all.push_back(&name);
    if (!hasDecimals(name.numbers[0]) && wholeNumber(name.numbers[0])) whole.push_back(&name);
  }
  return 2 * whole.size() >= all.size() ? whole : all;
}

Group mostAlike(const std::string& folder, const std::vector<SplitName>& names) {
  std::map<std::string, Group> groups;
  for (const SplitName& name : names)
    if (!name.numbers.empty()) groups[name.pattern].push_back(&name);
  const Group *most = nullptr, *as_many = nullptr;
  for (const auto& [pattern, group] : groups) {
    if (most == nullptr || group.size() > most->size()) {
      most = &group;
      as_many = nullptr;
    } else if (group.size() == most->size()) {
      as_many = &group;
    }
  }
  if (as_many != nullptr)
    throw InputError(folder + ": has images that are named in several ways, such as " + most->front()->name + " and " +
                     as_many->front()->name + ", must have one way");
  return most == nullptr ? Group() : *most;
}

}  // namespace

NamedImages namedImages(const std::string& folder, const std::string& kind,
                        const std::function<bool(const std::string&)>& isImage, std::vector<std::string>& warnings) {
  std::vector<SplitName> names;
  for (const std::string& name : filesIn(folder))
    if (name[0] != '.' && isImage(name)) names.push_back(split(name));
  NamedImages result;
  result.folder = folder;
  Group group = plainNames(names);
  if (group.empty()) group = mostAlike(folder, names);
  if (!group.empty()) {
    const std::vector<Place> places = placesOf(folder, group);
    const std::optional<std::size_t> number = placeOf(folder, group, places, false),
                                     time = placeOf(folder, group, places, true);
    for (const SplitName* name : group) {
      result.images.push_back({name->name, std::nullopt, std::nullopt});
      if (number) result.images.back().number = wholeNumber(name->numbers[*number]);
    }
    if (time) readTimes(group, *time, result);
    result.plain = number && group[0]->pattern == kNumberPlace;
    sortImages(result, kind);
  }
  const std::size_t others = names.size() - group.size();
  if (others == 0) return result;
  const auto other = std::find_if(names.begin(), names.end(), [&](const SplitName& name) {
    return std::find(group.begin(), group.end(), &name) == group.end();
  });
  warnings.push_back(folder + ": " + std::to_string(others) + (others == 1 ? " image is" : " images are") +
                     " not read, such as " + other->name +
                     (group.empty() ? ": no number in the name tells the frame or the time"
                                    : ": the others are named like " + group[0]->name));
  return result;
}

}  // namespace fuse_flow::io
