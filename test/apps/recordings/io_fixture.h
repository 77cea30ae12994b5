#pragma once

#include <fuse_flow/recordings/error.h>
#include <fuse_flow/recordings/recording.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace io_test {

namespace fs = std::filesystem;
using namespace fuse_flow;

/** \brief A folder of its own for each test, removed afterwards. */
class IoTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "fuse_flow_io_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr) << pattern;
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /** \brief Writes a file below the folder, creating the folders on the way, and returns its path. */
  std::string write(const std::string& name, const std::string& bytes) const {
    const fs::path file = folder_ / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << bytes;
    return file.string();
  }

  fs::path folder_;
};

/** \brief Whether action throws an Error whose message is one line that holds each of the words. */
template <typename Error = io::InputError, typename Action>
testing::AssertionResult refuses(const Action& action, const std::vector<std::string>& words) {
  try {
    action();
  } catch (const Error& error) {
    const std::string message = error.what();
    if (message.empty() || message.find('\n') != std::string::npos)
      return testing::AssertionFailure() << "the message is not one line: '" << message << "'";
    for (const std::string& word : words)
      if (message.find(word) == std::string::npos)
        return testing::AssertionFailure() << "the message does not say '" << word << "': '" << message << "'";
    return testing::AssertionSuccess();
  } catch (const std::exception& error) {
    return testing::AssertionFailure() << "another exception was thrown: " << error.what();
  }
  return testing::AssertionFailure() << "nothing was thrown";
}

/** \brief Whether a recording says that colour may lie there unused. */
inline bool saysUnused(const io::Recording& recording, const std::vector<std::string>& words) {
  return std::any_of(recording.warnings().begin(), recording.warnings().end(), [&](const std::string& line) {
    return line.find("no colour is read, and ") != std::string::npos &&
           std::all_of(words.begin(), words.end(),
                       [&](const std::string& word) { return line.find(word) != std::string::npos; });
  });
}

}  // namespace io_test
