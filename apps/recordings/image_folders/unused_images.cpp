#include "recordings/image_folders/unused_images.h"

#include "recordings/files/file_io.h"
#include "recordings/readers/view_files.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <filesystem>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

/** \brief Whether a name says that an image is no colour image. */
bool saysOtherwise(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const char* word : {"depth", "disparity", "conf", "normal", "mask", "infra", "label", "segment", "truth"})
    if (name.find(word) != std::string::npos) return true;
  return name == "ir" || name.rfind("ir_", 0) == 0 || name.rfind("ir-", 0) == 0;
}

}  // namespace

std::string unusedImages(const std::string& folder, const std::string& expected) {
  std::size_t images = 0, beside = 0;
  std::string first, first_beside;
  const auto look = [](const fs::path& within, const std::string& name, std::size_t& count, std::string& first_of_all) {
    if (saysOtherwise(name) || !isImage(name)) return;
    if (++count == 1) first_of_all = (within / name).string();
  };
  const fs::path root(folder);
  std::error_code error;
  for (const std::string& name : filesIn(folder)) {
    if (!fs::is_directory(root / name, error)) {
      look(root, name, beside, first_beside);
    } else if (!saysOtherwise(name)) {
      for (const std::string& inside : filesIn((root / name).string())) look(root / name, inside, images, first);
    }
  }
  if (images == 0 && beside > 1) {  // one alone is a preview, or the like
    images = beside;
    first = first_beside;
  }
  if (images == 0) return "";
  return folder + ": no colour is read, and " + std::to_string(images) +
         (images == 1 ? " other image is" : " other images are") + " there, such as " + first + "; colour must be " +
         expected;
}

}  // namespace fuse_flow::io
