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

/** \brief All lines of a file. */
std::vector<std::string> linesOf(const fs::path& file) {
  std::ifstream stream(file);
  return codeLines(stream);
}

const fs::path examples = root / "doc/examples";
const std::vector<fs::path> pages{root / "README.md", root / "doc/tutorial.md"};

// Programs, which whoever reads them copies whole: nothing around them is needed.
TEST(Documentation, TheReadmesCppIsWholeExamplesAsTheyStand) {
  const auto programs = blocks(root / "README.md", "cpp");
  ASSERT_EQ(programs.size(), 2u);
  EXPECT_EQ(joined(programs[0]), joined(linesOf(examples / "ten_lines.cpp")));
  EXPECT_EQ(joined(programs[1]), joined(linesOf(examples / "fuse_recording.cpp")));
}

TEST(Documentation, ShowsOnlyCppThatAnExampleCompiles) {
  const auto shown = blocks(root / "doc/tutorial.md", "cpp");
  for (const auto& block : shown)
    EXPECT_TRUE(quotes(block, examples / "fuse_frame.cpp") || quotes(block, examples / "filters_in_a_pipeline.cpp"))
        << "the tutorial shows what no example has:\n"
        << joined(block);
  EXPECT_GT(shown.size(), 10u);
}

TEST(Documentation, ShowsOnlyCMakeThatTheExamplesAreBuiltWith) {
  for (const fs::path& page : pages) {
    const auto cmake = blocks(page, "cmake");
    ASSERT_EQ(cmake.size(), 1u) << page;
    EXPECT_TRUE(quotes(cmake[0], examples / "CMakeLists.txt")) << page << "\n" << joined(cmake[0]);
  }
}

// What is no program, no CMake and no command is checked by nothing.
TEST(Documentation, EveryBlockIsOfALanguageThatIsChecked) {
  for (const fs::path& page : pages) {
    std::ifstream stream(page);
    bool inside = false;
    for (std::string line; std::getline(stream, line);) {
      if (line.rfind("```", 0) != 0) continue;
      inside = !inside;
      EXPECT_TRUE(!inside || line == "```cpp" || line == "```cmake" || line == "```sh") << page << ": " << line;
    }
    EXPECT_FALSE(inside) << page << " has a block without an end";
  }
}

TEST(Documentation, TheSamplesAreAsShortAsTheReadmeSays) {
  for (const char* sample : {"sample_pcl_pipeline.cpp", "sample_visualize.cpp", "sample_live.cpp"}) {
    std::ifstream stream(root / "apps/samples" / sample);
    int lines = 0;
    for (std::string line; std::getline(stream, line);) ++lines;
    EXPECT_TRUE(lines > 10 && lines < 100) << sample << " has " << lines << " lines";
  }
}

}  // namespace
