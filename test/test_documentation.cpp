#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path root = FUSE_FLOW_TEST_SOURCE_DIR;

/** \brief Lines without indentation or alignment; empty ones left out. */
std::vector<std::string> codeLines(std::istream& stream) {
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string joined;
    for (std::string word; words >> word;) joined += (joined.empty() ? "" : " ") + word;
    if (!joined.empty()) lines.push_back(joined);
  }
  return lines;
}

/** \brief The fenced blocks of a page that are of one language. */
std::vector<std::vector<std::string>> blocks(const fs::path& page, const std::string& language) {
  std::ifstream stream(page);
  std::vector<std::vector<std::string>> result;
  std::string code;
  bool inside = false;
  for (std::string line; std::getline(stream, line);) {
    if (!inside && line == "```" + language) {
      inside = true;
    } else if (inside && line == "```") {
      std::istringstream block(code);
      result.push_back(codeLines(block));
      code.clear();
      inside = false;
    } else if (inside) {
      code += line + "\n";
    }
  }
  return result;
}

/** \brief Whether the lines of the block stand in the file, in that order. */
bool quotes(const std::vector<std::string>& block, const fs::path& file) {
  std::ifstream stream(file);
  std::size_t found = 0;
  for (const std::string& line : codeLines(stream))
    if (found < block.size() && line == block[found]) ++found;
  return found == block.size();
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(Documentation, ShowsOnlyCppThatAnExampleCompiles) {
  const fs::path examples = root / "doc/examples";
  std::size_t count = 0;
  for (const fs::path& page : {root / "README.md", root / "doc/tutorial.md"})
    for (const auto& block : blocks(page, "cpp")) {
      ++count;
      EXPECT_TRUE(quotes(block, examples / "fuse_frame.cpp") || quotes(block, examples / "filters_in_a_pipeline.cpp"))
          << page << " shows what no example has:\n"
          << joined(block);
    }
  EXPECT_GT(count, 10u);
}

TEST(Documentation, ShowsOnlyCMakeThatTheExamplesAreBuiltWith) {
  const auto cmake = blocks(root / "doc/tutorial.md", "cmake");
  ASSERT_EQ(cmake.size(), 1u);
  EXPECT_TRUE(quotes(cmake[0], root / "doc/examples/CMakeLists.txt")) << joined(cmake[0]);
}

TEST(Documentation, TheSamplesAreAsShortAsTheReadmeSays) {
  for (const char* sample : {"sample_pcl_pipeline.cpp", "sample_visualize.cpp", "sample_live.cpp"}) {
    std::ifstream stream(root / "apps" / sample);
    int lines = 0;
    for (std::string line; std::getline(stream, line);) ++lines;
    EXPECT_TRUE(lines > 10 && lines < 100) << sample << " has " << lines << " lines";
  }
}

}  // namespace
