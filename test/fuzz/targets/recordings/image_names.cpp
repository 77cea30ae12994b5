#include "../../fuzz_target.h"
#include "../../scratch.h"

#include "recordings/image_folders/image_names.h"
#include "recordings/streams/frame_sets.h"

#include <fuse_flow/recordings/error.h>

#include <filesystem>
#include <sstream>

/** \brief Names of images, a line each, from which numbers and times are read; and the frames that images of such times make: places of
 *  up to ten thousand lost images for each camera. */
FUSE_FLOW_FUZZ_TARGET(image_names, 4 << 20, 2048, 500) {
  using namespace fuse_flow;
  const std::string folder = fuse_flow_fuzz::emptyScratchFolder();
  std::istringstream lines{std::string(input.substr(0, 1000))};
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(0, line.find('\0')).substr(0, 200);
    if (!line.empty() && line != "." && line != ".." && line.find('/') == std::string::npos)
      fuse_flow_fuzz::scratchFile(line, "");
  }
  std::vector<std::string> warnings;
  fuse_flow_fuzz::accepts<io::InputError>([&] {
    const io::NamedImages images = io::namedImages(
        folder, "depth", [](const std::string& name) { return name.find(".png") != std::string::npos; }, warnings);
    if (!images.timed()) return;
    std::vector<std::vector<io::Nanoseconds>> stamps(2);
    for (std::size_t k = 0; k < images.images.size(); ++k)
      if (stamps[k % 2].empty() || *images.images[k].stamp > stamps[k % 2].back())
        stamps[k % 2].push_back(*images.images[k].stamp);
    io::groupByTime(stamps);
  });
}
