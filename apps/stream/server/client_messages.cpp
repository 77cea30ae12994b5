#include "stream/server/client_messages.h"

#include <fuse_flow/stream/streamed_cloud.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <set>
#include <stdexcept>
#include <vector>

namespace fuse_flow::stream::network {

namespace {

using Json = nlohmann::json;
using Point = std::array<double, 3>;

// No scene is larger, and squares of it are far from overflow.
constexpr double kFarthest = 1e9;  // metres

double coordinate(const Json& json, const char* key) {
  if (!json.is_number()) throw FormatError(std::string(key) + " must be three numbers");
  const double value = json.get<double>();
  if (!(std::abs(value) <= kFarthest)) throw FormatError(std::string(key) + " is not within 1e9 metres");
  return value;
}

Point pointOf(const Json& json, const char* key) {
  if (!json.is_array() || json.size() != 3) throw FormatError(std::string(key) + " must be three numbers");
  return {coordinate(json[0], key), coordinate(json[1], key), coordinate(json[2], key)};
}

std::uint64_t wholeNumber(const Json& json, const char* key) {
  if (!json.is_number_unsigned()) throw FormatError(std::string(key) + " must be a whole number, not negative");
  return json.get<std::uint64_t>();
}

Wishes::Box boxOf(const Json& json) {
  if (!json.is_object() || json.size() != 2 || !json.contains("min") || !json.contains("max"))
    throw FormatError("region must have min and max");
  Wishes::Box box{pointOf(json["min"], "region.min"), pointOf(json["max"], "region.max")};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (box.least[axis] > box.greatest[axis]) throw FormatError("region.min must not be above region.max");
  return box;
}

Wishes wishesOf(const Json& json) {
  Wishes wishes;
  for (const auto& [key, value] : json.items()) {
    if (key == "type") continue;
    if (key == "points") {
      wishes.points = wholeNumber(value, "points");
    } else if (key == "bytes_per_second") {
      wishes.bytes_per_second = wholeNumber(value, "bytes_per_second");
      if (*wishes.bytes_per_second == 0) throw FormatError("bytes_per_second must be above 0");
    } else if (key == "region") {
      wishes.region = boxOf(value);
    } else if (key == "viewpoint") {
      wishes.viewpoint = pointOf(value, "viewpoint");
    } else if (key == "step") {
      if (!value.is_number() || !(value.get<double>() > 0 && value.get<double>() <= kFarthest))
        throw FormatError("step must be a length above 0");
      wishes.step = value.get<double>();
    } else {
      throw FormatError("want has a key that is not known");
    }
  }
  return wishes;
}

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(std::string("stream::Wishes::") + what);
}

void requirePoint(const Point& point, const char* what) {
  for (const double value : point) require(std::abs(value) <= kFarthest, what);
}

}  // namespace

ClientMessage clientMessage(std::string_view text) {
  if (text.size() > kMostClientMessage) throw FormatError("a message must not be longer than 4096 bytes");
  // A key that is there twice is refused: which of the two holds is for parsers to disagree on. Deep nesting, as nothing here has it.
  std::vector<std::set<std::string>> keys;
  bool twice = false, deep = false;
  const Json json = Json::parse(
      text.begin(), text.end(),
      [&](int depth, Json::parse_event_t event, Json& parsed) {
        if (depth > 4) deep = true;
        if (event == Json::parse_event_t::object_start) keys.emplace_back();
        if (event == Json::parse_event_t::object_end && !keys.empty()) keys.pop_back();
        if (event == Json::parse_event_t::key && !keys.empty())
          twice |= !keys.back().insert(parsed.get<std::string>()).second;
        return !deep;
      },
      false);
  if (deep || json.is_discarded() || !json.is_object()) throw FormatError("a message must be a JSON object");
  if (twice) throw FormatError("a message must not have a key twice");
  const auto type = json.find("type");
  if (type == json.end() || !type->is_string()) throw FormatError("a message must have a type");
  if (*type == "got") {
    if (json.size() != 2 || !json.contains("frame")) throw FormatError("got must have frame, and nothing else");
    return Got{wholeNumber(json["frame"], "frame")};
  }
  if (*type == "want") return wishesOf(json);
  throw FormatError("the type of a message must be got or want");
}

std::string toJson(const Got& got) { return "{\"type\":\"got\",\"frame\":" + std::to_string(got.frame) + "}"; }

std::string toJson(const Wishes& wishes) {
  Json json = {{"type", "want"}};
  if (wishes.points) json["points"] = *wishes.points;
  if (wishes.bytes_per_second) {
    require(*wishes.bytes_per_second > 0, "bytes_per_second: must be above 0");
    json["bytes_per_second"] = *wishes.bytes_per_second;
  }
  if (wishes.region) {
    requirePoint(wishes.region->least, "region: must be within 1e9 metres");
    requirePoint(wishes.region->greatest, "region: must be within 1e9 metres");
    for (std::size_t axis = 0; axis < 3; ++axis)
      require(wishes.region->least[axis] <= wishes.region->greatest[axis],
              "region: its least corner must not be above its greatest");
    json["region"] = {{"min", wishes.region->least}, {"max", wishes.region->greatest}};
  }
  if (wishes.viewpoint) {
    requirePoint(*wishes.viewpoint, "viewpoint: must be within 1e9 metres");
    json["viewpoint"] = *wishes.viewpoint;
  }
  if (wishes.step) {
    require(*wishes.step > 0 && *wishes.step <= kFarthest, "step: must be a length above 0, in metres");
    json["step"] = *wishes.step;
  }
  return json.dump();
}

}  // namespace fuse_flow::stream::network
