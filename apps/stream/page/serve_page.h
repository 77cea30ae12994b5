#pragma once

#include "stream/page/page_files.h"

#include <fuse_flow/stream/server.h>

#include <string>

namespace fuse_flow::stream {

/** \brief Has a server give browsers the page. False: the program was built without it. */
inline bool servePage(Server& server) {
  const std::vector<PageFile> files = pageFiles();
  for (const PageFile& file : files) {
    const std::string path = "/" + std::string(file.path);
    server.serve(path == "/index.html" ? "/" : path,
                 {file.type, std::string(reinterpret_cast<const char*>(file.data), file.size), ""});
  }
  return !files.empty();
}

}  // namespace fuse_flow::stream
