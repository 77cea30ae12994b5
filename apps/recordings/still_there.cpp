#include "recordings/still_there.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <filesystem>
#include <set>

namespace fs = std::filesystem;

namespace fuse_flow::io {

StillThere::StillThere(const Recording& recording) {
  std::set<std::string> folders;
  std::error_code error;
  for (const std::string& input : recording.inputs()) {
    if (input.empty()) continue;
    if (fs::is_directory(input, error)) folders.insert(input);
    const fs::path parent = fs::path(input).parent_path();
    if (fs::is_directory(parent, error)) folders.insert(parent.string());
  }
  folders_.assign(folders.begin(), folders.end());
}

void StillThere::check(const LoadedFrame& frame) const {
  const auto missing = [](const DepthView& view) { return view.missing(); };
  if (std::none_of(frame.rig.views.begin(), frame.rig.views.end(), missing)) return;
  std::error_code error;
  for (const std::string& folder : folders_)
    if (!fs::is_directory(folder, error))
      throw InputError(folder +
                       ": is no longer there; it was when the recording was opened, must stay until it is read");
}

}  // namespace fuse_flow::io
