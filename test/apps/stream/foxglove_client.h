#pragma once

#include "raw_socket.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace fuse_flow::test {

/** \brief A message of Protocol Buffers, read by what its documentation says, to compare with what the server wrote. */
class ProtobufMessage {
 public:
  explicit ProtobufMessage(const std::string& bytes) {
    std::size_t at = 0;
    const auto take = [&](std::size_t size) {
      if (size > bytes.size() - at) throw std::runtime_error("a message ends in a field");
      at += size;
      return bytes.substr(at - size, size);
    };
    const auto varint = [&] {
      std::uint64_t value = 0;
      for (int shift = 0;; shift += 7) {
        const auto byte = static_cast<unsigned char>(take(1)[0]);
        value |= static_cast<std::uint64_t>(byte & 127u) << shift;
        if (byte < 128) return value;
      }
    };
    while (at < bytes.size()) {
      const std::uint64_t key = varint();
      Value value;
      switch (key & 7u) {
        case 0:
          value.number = varint();
          break;
        case 1:
          value.bytes = take(8);
          break;
        case 2:
          value.bytes = take(varint());
          break;
        case 5:
          value.bytes = take(4);
          break;
        default:
          throw std::runtime_error("a field of an unknown kind");
      }
      fields_[key >> 3].push_back(value);
    }
  }

  std::size_t count(std::uint64_t field) const { return fields_.count(field) ? fields_.at(field).size() : 0; }
  std::uint64_t number(std::uint64_t field) const { return one(field).number; }
  const std::string& text(std::uint64_t field) const { return one(field).bytes; }
  std::uint32_t fixed32(std::uint64_t field) const { return as<std::uint32_t>(text(field)); }
  double real(std::uint64_t field) const { return as<double>(text(field)); }
  std::vector<double> reals(std::uint64_t field) const {
    std::vector<double> result;
    for (std::size_t at = 0; at < text(field).size(); at += 8) result.push_back(as<double>(text(field).substr(at, 8)));
    return result;
  }
  ProtobufMessage message(std::uint64_t field, std::size_t k = 0) const {
    return ProtobufMessage(fields_.at(field).at(k).bytes);
  }
  /** \brief A Timestamp, in nanoseconds. */
  std::uint64_t time(std::uint64_t field) const {
    const ProtobufMessage time = message(field);
    return time.number(1) * 1'000'000'000 + time.number(2);
  }

 private:
  struct Value {
    std::uint64_t number{0};
    std::string bytes;
  };
  const Value& one(std::uint64_t field) const {
    if (count(field) != 1) throw std::runtime_error("field " + std::to_string(field) + " is not there once");
    return fields_.at(field)[0];
  }
  template <typename T>
  static T as(const std::string& bytes) {
    T value;
    if (bytes.size() != sizeof(value)) throw std::runtime_error("a field of another size");
    std::memcpy(&value, bytes.data(), sizeof(value));
    return value;
  }

  std::map<std::uint64_t, std::vector<Value>> fields_;
};

/** \brief A client of Foxglove's protocol that does what a test says. */
class FoxgloveClient : public RawWebSocket {
 public:
  using Json = nlohmann::json;

  /** \brief Message of a channel. */
  struct Data {
    std::uint32_t subscription;
    std::uint64_t time;
    std::string payload;
  };

  explicit FoxgloveClient(std::uint16_t port, const std::string& headers = "", const std::string& target = "/",
                          const std::string& subprotocol = "foxglove.websocket.v1")
      : RawWebSocket(port, headers, target, subprotocol) {}

  Json nextJson() { return Json::parse(next(kText).payload); }
  /** \brief The next of an operation; others are left out. */
  Json next(const std::string& operation) {
    for (;;) {
      Json json = nextJson();
      if (json["op"] == operation) return json;
    }
  }
  using RawWebSocket::next;
  /** \brief What the server begins with; topics and their channels. */
  std::map<std::string, std::uint32_t> channels() {
    std::map<std::string, std::uint32_t> result;
    const Json advertise = next("advertise");
    for (const Json& channel : advertise["channels"]) result[channel["topic"]] = channel["id"];
    return result;
  }
  void subscribe(std::uint32_t id, std::uint32_t channel) {
    send(kText, Json{{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}}.dump());
  }
  void unsubscribe(std::uint32_t id) { send(kText, Json{{"op", "unsubscribe"}, {"subscriptionIds", {id}}}.dump()); }
  Data nextData() {
    const std::string bytes = next(kBinary).payload;
    if (bytes.size() < 13 || bytes[0] != 1) throw std::runtime_error("no message of a channel");
    Data data;
    std::memcpy(&data.subscription, bytes.data() + 1, 4);
    std::memcpy(&data.time, bytes.data() + 5, 8);
    data.payload = bytes.substr(13);
    return data;
  }
  /** \brief After all that the server had to say so far: it answers what it does not know, in order. */
  Json answerToUnknown() {
    send(kText, R"({"op":"unknown"})");
    return next("status");
  }
};

}  // namespace fuse_flow::test
