#include <gtest/gtest.h>

#include <algorithm>
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

const fs::path python_examples = root / "apps/python/examples";

/** \brief The pages of the guide. */
std::vector<fs::path> guide() {
  std::vector<fs::path> pages;
  for (const auto& entry : fs::directory_iterator(root / "doc/guide"))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  return pages;
}

/** \brief The sources that are compiled and run: of the examples and of the samples. */
std::vector<fs::path> compiledSources() {
  std::vector<fs::path> sources;
  for (const fs::path& folder : {examples, root / "apps/samples"})
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".cpp") sources.push_back(entry.path());
  return sources;
}

// Readers copy these programs whole, so they must be complete.
TEST(Documentation, TheReadmesCppIsWholeExamplesAsTheyStand) {
  const std::vector<fs::path> whole{examples / "ten_lines.cpp", examples / "fuse_recording.cpp"};
  const auto programs = blocks(root / "README.md", "cpp");
  ASSERT_EQ(programs.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_EQ(joined(programs[i]), joined(linesOf(whole[i])));
}

TEST(Documentation, ShowsOnlyCppThatAnExampleCompiles) {
  const std::vector<fs::path> sources = compiledSources();
  std::size_t shown = 0;
  for (const fs::path& page : guide())
    for (const auto& block : blocks(page, "cpp")) {
      ++shown;
      EXPECT_TRUE(std::any_of(sources.begin(), sources.end(), [&](const fs::path& s) { return quotes(block, s); }))
          << page << " shows what no example has:\n"
          << joined(block);
    }
  EXPECT_GT(shown, 15u);
}

TEST(Documentation, TheReadmesPythonIsAWholeExampleAsItStands) {
  const auto programs = blocks(root / "README.md", "python");
  ASSERT_EQ(programs.size(), 1u);
  EXPECT_EQ(joined(programs[0]), joined(linesOf(python_examples / "five_lines.py")));
}

TEST(Documentation, ShowsOnlyPythonThatAnExampleRuns) {
  std::vector<fs::path> sources;
  for (const auto& entry : fs::directory_iterator(python_examples)) sources.push_back(entry.path());
  std::size_t shown = 0;
  for (const fs::path& page : guide())
    for (const auto& block : blocks(page, "python")) {
      ++shown;
      EXPECT_TRUE(std::any_of(sources.begin(), sources.end(), [&](const fs::path& s) { return quotes(block, s); }))
          << page << " shows what no example has:\n"
          << joined(block);
    }
  EXPECT_GT(shown, 4u);
}

TEST(Documentation, ShowsOnlyCMakeThatTheExamplesAreBuiltWith) {
  std::vector<fs::path> pages = guide();
  pages.push_back(root / "README.md");
  std::size_t shown = 0;
  for (const fs::path& page : pages)
    for (const auto& block : blocks(page, "cmake")) {
      ++shown;
      EXPECT_TRUE(quotes(block, examples / "CMakeLists.txt")) << page << "\n" << joined(block);
    }
  EXPECT_EQ(shown, 5u);  // of the README, and of the pages of C++, of the GPU, of ranks and of streams
}

// What is no program, no CMake, no command and no rig.json is checked by nothing: a picture of folders, or lines of a --config file. Nor
// is a drawing.
TEST(Documentation, EveryBlockIsOfALanguageThatIsChecked) {
  std::vector<fs::path> pages = guide();
  pages.push_back(root / "README.md");
  std::size_t unchecked = 0;
  for (const fs::path& page : pages) {
    std::ifstream stream(page);
    bool inside = false;
    for (std::string line; std::getline(stream, line);) {
      if (line.rfind("```", 0) != 0) continue;
      inside = !inside;
      if (inside && line == "```text") ++unchecked;
      EXPECT_TRUE(!inside || line == "```cpp" || line == "```cmake" || line == "```sh" || line == "```json" ||
                  line == "```python" || line == "```mermaid" || line == "```text")
          << page << ": " << line;
    }
    EXPECT_FALSE(inside) << page << " has a block without an end";
  }
  EXPECT_LE(unchecked, 3u);
}

// The pages' commands are run one page a test: test/CMakeLists.txt names them.
TEST(Documentation, EveryPageOfTheGuideWithCommandsIsRun) {
  std::ifstream stream(root / "test/CMakeLists.txt");
  std::string names;
  for (std::string line; std::getline(stream, line);)
    if (line.find("set(pages recording") != std::string::npos) names = line;
  for (const fs::path& page : guide()) {
    if (blocks(page, "sh").empty()) continue;
    EXPECT_NE(names.find(" " + page.stem().string()), std::string::npos) << page << " is not run";
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
