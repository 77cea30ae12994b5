#pragma once

#include "../../../test_length.h"
#include "run_tool.h"
#include "wall_recording.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>
#include <string>

namespace tool_test {

/** \brief A folder of its own for each test, removed afterwards. */
class ToolTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "fuse_flow_tools_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr) << pattern;
    folder_ = pattern;
    recording_ = folder_ / "recording";
    out_ = folder_ / "out";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string recording() const { return recording_.string(); }
  std::string out(const std::string& name = "") const { return (name.empty() ? out_ : folder_ / name).string(); }

  fs::path folder_;
  fs::path recording_;
  fs::path out_;
};

/** \brief The exit code, nothing on the standard output stream, and one line that holds each of the words. */
/** \brief What a tool printed on the standard error stream but for warnings, which may stand before an error or a success. */
inline std::string withoutWarnings(const std::string& err) {
  std::string rest;
  std::istringstream lines(err);
  for (std::string line; std::getline(lines, line);)
    if (line.find(": warning: ") == std::string::npos) rest += line + (lines.eof() ? "" : "\n");
  return rest;
}

inline testing::AssertionResult isOneLineError(const ToolResult& result, int exit_code,
                                               const std::vector<std::string>& words) {
  const auto wrong = [&](const std::string& what) {
    return testing::AssertionFailure() << what << "; exit code " << result.exit_code << ", output '" << result.out
                                       << "', error '" << result.err << "'";
  };
  if (result.exit_code != exit_code) return wrong("the exit code is not " + std::to_string(exit_code));
  if (!result.out.empty()) return wrong("there is output");
  const std::string err = withoutWarnings(result.err);
  if (err.rfind("fuse_flow_", 0) != 0) return wrong("the line does not begin with the tool's name");
  if (std::count(err.begin(), err.end(), '\n') != 1 || err.back() != '\n') return wrong("the error is not one line");
  for (const std::string& word : words)
    if (err.find(word) == std::string::npos) return wrong("the line does not say '" + word + "'");
  return testing::AssertionSuccess();
}

inline testing::AssertionResult succeeded(const ToolResult& result) {
  if (result.exit_code == 0 && withoutWarnings(result.err).empty()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "exit code " << result.exit_code << ", error '" << result.err << "'";
}

}  // namespace tool_test
