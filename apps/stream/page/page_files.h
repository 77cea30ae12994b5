#pragma once

#include <cstddef>
#include <vector>

namespace fuse_flow::stream {

/** \brief A file of the page, in the program's memory. */
struct PageFile {
  const char* path;  ///< without a slash before it: "index.html"
  const char* type;  ///< for the header Content-Type
  const unsigned char* data;
  std::size_t size;
};

/** \brief All that browsers get. Empty if the program was built without three.js. */
std::vector<PageFile> pageFiles();

}  // namespace fuse_flow::stream
