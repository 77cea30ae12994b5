#include "recordings/files/file_io.h"

#include "recordings/files/interrupt.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

/** \brief Calls until no signal interrupts the call. */
template <typename Call>
auto uninterrupted(Call call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

/** \brief 0, or the number of the error. Not stdio, whose buffer is lost if a signal interrupts it. */
int writeAll(int file, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count = uninterrupted([&] { return write(file, bytes.data() + done, bytes.size() - done); });
    if (count < 0) return errno;
    if (count == 0) return EIO;
    done += static_cast<std::size_t>(count);
  }
  // EINVAL, EROFS: a pipe or a device, which has nothing to synchronise.
  if (uninterrupted([&] { return fsync(file); }) != 0 && errno != EINVAL && errno != EROFS) return errno;
  return 0;
}

/** \brief Empty, or why the bytes are not all on the disk. */
std::string writeBytes(const std::string& path, const std::string& bytes) {
  const int file = uninterrupted([&] { return open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666); });
  if (file < 0) return std::strerror(errno);
  int error = writeAll(file, bytes);
  if (close(file) != 0 && error == 0 && errno != EINTR) error = errno;
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

/** \brief Not what may never give a byte. */
std::ifstream openFile(const std::string& path) {
  if (!isThere(path)) throw InputError(path + ": not found, must be a file");
  std::error_code error;
  const std::string other = otherThanFile(fs::status(path, error));
  if (!other.empty()) throw InputError(path + ": is " + other + ", must be a file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path + ": cannot be opened: " + std::strerror(errno));
  return file;
}

std::string readBytes(const std::string& path, std::ifstream& file, std::size_t count) {
  std::string bytes(count, '\0');
  file.seekg(0);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) throw InputError(path + ": cannot be read");
  return bytes;
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

std::string readFile(const std::string& path, std::uint64_t most) {
  std::ifstream file = openFile(path);
  file.seekg(0, std::ios::end);
  const std::streamoff size = file.tellg();
  if (size > 0 && static_cast<std::uint64_t>(size) > most)
    throw InputError(path + ": has " + std::to_string(size) + " bytes, must have " + std::to_string(most) + " or less");
  return readBytes(path, file, size > 0 ? static_cast<std::size_t>(size) : 0);
}

std::string readText(const std::string& path, std::uint64_t most) {
  std::string text = readFile(path, most);
  if (const std::size_t zero = text.find('\0'); zero != std::string::npos)
    throw InputError(path + ": byte " + std::to_string(zero) + " is 0, must be text in UTF-8; it may be damaged");
  return text;
}

std::string readFileStart(const std::string& path, std::uint64_t most) {
  std::ifstream file = openFile(path);
  return readBytes(path, file, static_cast<std::size_t>(std::min(most, fileSize(path))));
}

std::uint64_t fileSize(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw InputError(path + ": cannot be looked at: " + error.message());
  return size;
}

std::string unfinishedName(const std::string& path) {
  const fs::path target(path);
  const std::string suffix = ".part" + std::to_string(getpid());
  std::string name = target.filename().string();
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const long longest = pathconf(folder.c_str(), _PC_NAME_MAX);  // -1: no limit, or none that is known
  if (longest > 0 && name.size() + suffix.size() > static_cast<std::size_t>(longest))
    name.resize(static_cast<std::size_t>(longest) - suffix.size());
  return (target.parent_path() / (name + suffix)).string();
}

void makeFolder(const std::string& folder) {
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw OutputError(folder + ": cannot be created: " + error.message());
}

void makeFolderOf(const std::string& path) { makeFolder(fs::path(path).parent_path().string()); }

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

  const fs::path temporary = unfinishedName(target.string());
  const UnfinishedFile unfinished(temporary.string());
  const std::string problem = writeBytes(temporary.string(), bytes);
  if (problem.empty()) fs::rename(temporary, target, error);
  if (problem.empty() && !error) return;
  const std::string reason = problem.empty() ? error.message() : problem;
  fs::remove(temporary, error);
  throw OutputError(path + ": cannot be written: " + reason);
}

}  // namespace fuse_flow::io
