#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <string>
#include <vector>

// Which way includes point, as doc/architecture.md draws it: distributed → gpu → impl → include, and in each of them from the rooms that fuse to those
// that they stand on.

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = FUSE_FLOW_TEST_SOURCE_DIR;

/** \brief A header of the library. */
struct Header {
  std::string root;  ///< include, impl, gpu or distributed
  std::string room;  ///< empty: beside the rooms
};

/** \brief A room may include what is in rooms below it, and its own. */
const std::map<std::string, int> kLevels = {
    {"math", 0},   {"host", 1},        {"runtime", 2}, {"live", 3},    {"sensors", 3}, {"stereo", 3}, {"fusion", 4},
    {"frames", 5}, {"calibration", 5}, {"filters", 5}, {"quality", 5}, {"impl", 6},    {"gpu", 6}};

Header headerOf(const std::string& include) {
  Header header{"include", ""};
  std::string rest = include.substr(std::string("fuse_flow/").size());
  for (const std::string folder : {"impl", "gpu", "distributed"})
    if (rest.rfind(folder + "/", 0) == 0) {
      header.root = folder;
      rest = rest.substr(folder.size() + 1);
    }
  const std::size_t slash = rest.find('/');
  if (slash != std::string::npos) header.room = rest.substr(0, slash);
  return header;
}

bool mayInclude(const Header& from, const Header& to, bool at_the_end) {
  const std::map<std::string, int> roots = {{"include", 0}, {"impl", 1}, {"gpu", 2}, {"distributed", 3}};
  // A header ends with its definitions, as PCL's do. Or begins with what its members are, of its own room.
  if (roots.at(to.root) > roots.at(from.root))
    return from.root == "include" && to.root == "impl" && (at_the_end || from.room == to.room);
  if (from.room == to.room || to.room.empty() || from.room.empty()) return true;
  // Equations take the parameters of the sensors' rooms as they are.
  if (from.room == "math" && to.room == "sensors" && to.root == "include") return true;
  return kLevels.at(to.room) < kLevels.at(from.room);
}

TEST(Rooms, IncludesPointFromWhatFusesToWhatItStandsOn) {
  const std::regex include("#include <(fuse_flow/[^>]+)>");
  std::size_t includes = 0;
  for (const std::string folder : {"include", "impl", "gpu", "distributed"})
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      if (!entry.is_regular_file() || entry.path().extension() == ".md") continue;
      const std::string name = fs::relative(entry.path(), kRoot / folder).generic_string();
      const Header from = headerOf(name);
      ASSERT_EQ(from.root, folder) << name;
      ASSERT_TRUE(from.room.empty() || kLevels.count(from.room) == 1) << name << " is in a room of no level";
      std::ifstream file(entry.path());
      bool code = false;
      for (std::string line; std::getline(file, line);) {
        std::smatch match;
        if (line.rfind("namespace", 0) == 0) code = true;
        if (!std::regex_search(line, match, include) || line.rfind("#include", 0) != 0) continue;
        ++includes;
        EXPECT_TRUE(mayInclude(from, headerOf(match[1]), code)) << folder << "/" << name << " includes " << match[1];
      }
    }
  EXPECT_GT(includes, 400u);
}

TEST(Rooms, NoneHoldsMoreThanATwentyOddFiles) {
  for (const std::string folder : {"include", "impl", "gpu", "distributed"})
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      if (!entry.is_directory()) continue;
      std::size_t files = 0;
      for (const fs::directory_entry& inside : fs::directory_iterator(entry.path()))
        files += inside.is_regular_file() ? 1 : 0;
      EXPECT_LE(files, 24u) << entry.path();
    }
}

}  // namespace
