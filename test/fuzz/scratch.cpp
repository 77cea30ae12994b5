#include "scratch.h"

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

namespace fs = std::filesystem;

namespace fuse_flow_fuzz {
namespace {

// Mutations that move, copy or delete bytes keep it whole more often than lengths.
constexpr std::string_view kSeparator = "\n%%%%\n";

class Folder {
 public:
  Folder() {
    const fs::path parent = fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
    std::string pattern = (parent / "fuse_flow_fuzz_XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error(pattern + ": cannot be created");
    path = pattern;
  }
  ~Folder() {
    std::error_code error;
    fs::remove_all(path, error);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  fs::path path;
  std::set<std::string> there;  ///< folders that were made
};

Folder& folder() {
  static Folder the;
  return the;
}

}  // namespace

// By the system's calls, which take no memory that a parser would be charged with.
std::string scratchFile(const std::string& name, std::string_view bytes) {
  const fs::path path = folder().path / name;
  if (const std::string parent = path.parent_path().string(); folder().there.insert(parent).second)
    fs::create_directories(parent);
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (file < 0) throw std::runtime_error(path.string() + ": cannot be written");
  const bool written = write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
  close(file);
  if (!written) throw std::runtime_error(path.string() + ": cannot be written");
  return path.string();
}

std::string emptyScratchFolder() {
  for (const auto& entry : fs::directory_iterator(folder().path)) fs::remove_all(entry);
  folder().there.clear();
  return folder().path.string();
}

void scratchFiles(const std::vector<std::string>& names, std::string_view input) {
  for (const std::string& name : names) {
    const std::size_t end = input.find(kSeparator);
    scratchFile(name, input.substr(0, end));
    if (end == std::string_view::npos) return;
    input.remove_prefix(end + kSeparator.size());
  }
}

std::string joinedFiles(const std::vector<std::string>& files) {
  std::string input;
  for (std::size_t k = 0; k < files.size(); ++k) input.append(k > 0 ? kSeparator : std::string_view()).append(files[k]);
  return input;
}

}  // namespace fuse_flow_fuzz
