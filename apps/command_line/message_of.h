#pragma once

#include <stdexcept>
#include <string>

namespace fuse_flow::io {

/** \brief PCL puts ": " before a message without a place in the source. */
inline std::string messageOf(const std::runtime_error& error) {
  const std::string message = error.what();
  return message.rfind(": ", 0) == 0 ? message.substr(2) : message;
}

}  // namespace fuse_flow::io
