#pragma once

#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"

#include <fuse_flow/recordings/error.h>

#include <nlohmann/json.hpp>

#include <string>

namespace fuse_flow::io {

/** \brief A value as a message quotes it: not all of what somebody has put in the place of a number. */
template <typename Json>
std::string quoted(const Json& value) {
  return cutShort(value.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/** \brief Parses a text. Throws InputError, in words of ours, for one that is not JSON or nested too deep.
 *  \param path where it comes from, for messages  \param what it must be, for messages: "a rig" */
template <typename Json>
Json parseJson(const std::string& path, const std::string& text, const std::string& what) {
  const auto accept = [&](int depth, typename Json::parse_event_t, Json&) {
    constexpr int deep = 16;  // what quotes or frees a value goes as deep as it
    if (depth > deep)
      throw InputError(path + ": has lists or objects more than " + std::to_string(deep) + " deep, must be " + what);
    return true;
  };
  try {
    return Json::parse(text, accept);
  } catch (const typename Json::parse_error& error) {
    throw InputError(path + ": is not JSON: error at byte " + std::to_string(error.byte) + "; so it is not " + what);
  } catch (const typename Json::out_of_range&) {
    throw InputError(path + ": holds a number too large for a double, must be " + what);
  }
}

/** \brief The same with a file's text. */
template <typename Json>
Json readJson(const std::string& path, const std::string& what, std::uint64_t most = kMostCalibrationBytes) {
  return parseJson<Json>(path, readText(path, most), what);
}

}  // namespace fuse_flow::io
