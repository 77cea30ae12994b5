#pragma once

#include <fuse_flow/stream/encoded_frame.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace fuse_flow::stream::network {

constexpr std::size_t kMostClientMessage = 4096;  ///< bytes

/** \brief A frame has arrived whole. */
struct Got {
  std::uint64_t frame;
};

/** \brief What a client of fuse_flow.v1 may say. */
using ClientMessage = std::variant<Got, Wishes>;

/** \throws FormatError whose text is a reason to close for: short, ASCII, and without what the client sent */
ClientMessage clientMessage(std::string_view json);

std::string toJson(const Got& got);
/** \brief As a message "want". \throws std::invalid_argument if a number is not finite, a length not above 0, or the box inside out */
std::string toJson(const Wishes& wishes);

}  // namespace fuse_flow::stream::network
