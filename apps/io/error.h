#pragma once

#include <stdexcept>
#include <string>

namespace fuse_flow::io {

/** \brief Something given to a tool cannot be used. The message is one line: the path, what is wrong, what would be
 *  right. */
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/** \brief An option cannot be used as it was given, or not with this recording. The message begins with the option. */
struct OptionError : InputError {
  using InputError::InputError;
};

/** \brief A result could not be written. The message is one line; nothing half-written is left behind. */
struct OutputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/** \brief PCL puts ": " before a message without a place in the source. */
inline std::string messageOf(const std::runtime_error& error) {
  const std::string message = error.what();
  return message.rfind(": ", 0) == 0 ? message.substr(2) : message;
}

/** \brief Text of an input as a message quotes it: of a long one the beginning, in whole characters of UTF-8. */
inline std::string cutShort(const std::string& text) {
  constexpr std::size_t most = 80;
  if (text.size() <= most) return text;
  std::size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  return text.substr(0, end) + "…";
}

}  // namespace fuse_flow::io
