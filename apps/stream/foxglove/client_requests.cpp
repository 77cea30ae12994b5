#include "stream/foxglove/client_requests.h"

#include "stream/network/text.h"

#include <fuse_flow/stream/streamed_cloud.h>

#include <nlohmann/json.hpp>

#include <limits>

namespace fuse_flow::stream::foxglove {

namespace {

using Json = nlohmann::json;

constexpr int kDeepest = 16;

std::uint32_t number(const Json& json, const char* what) {
  if (!json.is_number_unsigned() || json.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max())
    throw FormatError(std::string(what) + " must be a whole number from 0 to 4294967295");
  return json.get<std::uint32_t>();
}

const Json& list(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array()) throw FormatError(std::string(key) + " must be a list");
  return *found;
}

const Json& entry(const Json& json, const char* key) {
  if (!json.is_object() || !json.contains(key))
    throw FormatError("a subscription must be an object with id and channelId");
  return json[key];
}

}  // namespace

ClientRequest clientRequest(std::string_view message, bool binary) {
  if (message.size() > kMostClientMessage) throw FormatError("a message must not be longer than 16384 bytes");
  if (binary) {
    if (message.empty()) throw FormatError("a binary message must begin with its operation");
    return Unsupported{"binary " + std::to_string(static_cast<unsigned char>(message[0]))};
  }
  bool deep = false;  // a value of thousands of brackets is none of the protocol's
  const Json json = Json::parse(
      message.begin(), message.end(),
      [&](int depth, Json::parse_event_t, Json&) { return !(deep |= depth > kDeepest); }, false);
  if (deep || json.is_discarded() || !json.is_object()) throw FormatError("a message must be a JSON object");
  const auto operation = json.find("op");
  if (operation == json.end() || !operation->is_string()) throw FormatError("a message must have an op");
  if (*operation == "subscribe") {
    Subscribe subscribe;
    for (const Json& each : list(json, "subscriptions"))
      subscribe.entries.push_back({number(entry(each, "id"), "id"), number(entry(each, "channelId"), "channelId")});
    return subscribe;
  }
  if (*operation == "unsubscribe") {
    Unsubscribe unsubscribe;
    for (const Json& each : list(json, "subscriptionIds"))
      unsubscribe.ids.push_back(number(each, "each of subscriptionIds"));
    return unsubscribe;
  }
  return Unsupported{network::printable(operation->get<std::string>(), 40)};
}

}  // namespace fuse_flow::stream::foxglove
