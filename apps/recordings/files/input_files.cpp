#include <fuse_flow/recordings/input_files.h>

#include <fuse_flow/recordings/error.h>

#include <sys/stat.h>

#include <filesystem>

namespace fs = std::filesystem;

namespace fuse_flow::io {

InputFiles::InputFiles(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) add(path);
}

void InputFiles::add(const std::string& path) {
  struct stat status {};
  if (path.empty() || stat(path.c_str(), &status) != 0) return;
  const Identity identity(status.st_dev, status.st_ino);
  if (!S_ISDIR(status.st_mode))
    files_.insert(identity);
  else if (folders_.insert(identity).second)  // links can make a folder hold itself
    not_looked_into_.push_back(path);
}

void InputFiles::lookInto(const std::string& folder) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    add(entry->path().string());
}

void InputFiles::refuseToReplace(const std::string& option, const std::string& path) {
  std::error_code error;
  const fs::path output = fs::weakly_canonical(fs::absolute(path, error), error);
  struct stat status {};
  for (fs::path folder = output.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
    if (stat(folder.c_str(), &status) == 0 && folders_.count({status.st_dev, status.st_ino}) > 0)
      throw OptionError(option + ' ' + path + ": is an input, or lies among those in " + folder.string() +
                        ", must be in another folder");
  // A device or a pipe keeps nothing, a folder is refused where it is written.
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return;
  while (!not_looked_into_.empty()) {
    const std::string folder = std::move(not_looked_into_.back());
    not_looked_into_.pop_back();
    lookInto(folder);
  }
  if (files_.count({status.st_dev, status.st_ino}) > 0)
    throw OptionError(option + ' ' + path + ": is an input, must be another file");
}

}  // namespace fuse_flow::io
