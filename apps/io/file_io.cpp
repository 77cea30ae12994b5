#include "io/file_io.h"

#include "io/interrupt.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

/** \brief Empty, or why the bytes are not all on the disk. */
std::string writeBytes(const std::string& path, const std::string& bytes) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (!file) return std::strerror(errno);
  int error = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) error = errno;
  if (std::fflush(file) != 0 && error == 0) error = errno;
  // EINVAL, EROFS: a pipe or a device, which has nothing to synchronise.
  if (error == 0 && fsync(fileno(file)) != 0 && errno != EINVAL && errno != EROFS) error = errno;
  if (std::fclose(file) != 0 && error == 0) error = errno;
  return error ? std::strerror(error) : "";
}

/** \brief What stands in a file's place, which may never give a byte; empty if it is a file. */
std::string otherThanFile(const fs::file_status& status) {
  switch (status.type()) {
    case fs::file_type::regular:
      return "";
    case fs::file_type::directory:
      return "a folder";
    case fs::file_type::fifo:
      return "a pipe";
    case fs::file_type::socket:
      return "a socket";
    default:
      return "a device";
  }
}

bool isOneOf(const fs::path& extension, const std::set<std::string>& extensions) {
  std::string lower = extension.string();
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return extensions.count(lower) > 0;
}

}  // namespace

bool isThere(const std::string& path) {
  std::error_code error;
  const bool there = fs::exists(path, error);
  if (error) throw InputError(path + ": cannot be looked at: " + error.message());
  return there;
}

std::vector<std::string> filesIn(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  if (!isThere(folder)) return names;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    names.push_back(entry->path().filename().string());
  if (error) throw InputError(folder + ": cannot be read: " + error.message() + ", must be a folder");
  std::sort(names.begin(), names.end());
  return names;
}

std::string readFile(const std::string& path) {
  if (!isThere(path)) throw InputError(path + ": not found, must be a file");
  std::error_code error;
  const std::string other = otherThanFile(fs::status(path, error));
  if (!other.empty()) throw InputError(path + ": is " + other + ", must be a file");
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw InputError(path + ": cannot be opened: " + std::strerror(errno));
  const std::streamoff size = file.tellg();
  std::string bytes(size > 0 ? static_cast<std::size_t>(size) : 0, '\0');
  file.seekg(0);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) throw InputError(path + ": cannot be read");
  return bytes;
}

void writeFile(const std::string& path, const std::string& bytes) {
  std::error_code error;
  fs::path target = fs::weakly_canonical(path, error);  // through a symbolic link, rather than in its place
  if (error) target = path;
  const fs::file_status status = fs::status(target, error);
  if (fs::is_directory(status)) throw OutputError(path + ": is a folder, must be a file name");
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    const std::string problem = writeBytes(target.string(), bytes);
    if (!problem.empty()) throw OutputError(path + ": cannot be written: " + problem);
    return;
  }
  if (target.has_parent_path() && !fs::is_directory(target.parent_path(), error))
    throw OutputError(path + ": cannot be written: the folder " + target.parent_path().string() + " does not exist");

  const fs::path temporary = target.string() + ".part" + std::to_string(getpid());
  const UnfinishedFile unfinished(temporary.string());
  const std::string problem = writeBytes(temporary.string(), bytes);
  if (problem.empty()) fs::rename(temporary, target, error);
  if (problem.empty() && !error) return;
  const std::string reason = problem.empty() ? error.message() : problem;
  fs::remove(temporary, error);
  throw OutputError(path + ": cannot be written: " + reason);
}

void refuseToReplace(const std::string& option, const std::string& path, const std::vector<std::string>& inputs) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return;
  const auto refuse = [&] { throw OptionError(option + ' ' + path + ": is an input, must be another file"); };
  const fs::path output = fs::canonical(path, error);
  const bool recorded = isOneOf(output.extension(), {".png", ".jpg", ".jpeg", ".txt", ".log"});
  const bool cloud =
      isOneOf(output.extension(), {".ply", ".pcd"}) && option != "-o";  // which may fuse into the recording's folder
  for (const std::string& input : inputs) {
    for (const fs::path& file : {fs::path(input), fs::path(input) / "rig.json"})
      if (fs::is_regular_file(file, error) && fs::equivalent(file, path, error)) refuse();
    if (!(recorded || cloud) || !fs::is_directory(input, error)) continue;
    for (fs::path folder = output.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
      if (fs::equivalent(folder, input, error)) refuse();
  }
}

}  // namespace fuse_flow::io
