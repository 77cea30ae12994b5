#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace fuse_flow::stream::foxglove {

/** \brief Bytes of a message of a client. Some ask for all channels in one. */
constexpr std::size_t kMostClientMessage = 16384;

struct Subscribe {
  struct Entry {
    std::uint32_t id, channel;
  };
  std::vector<Entry> entries;
};
struct Unsubscribe {
  std::vector<std::uint32_t> ids;
};
/** \brief What the protocol has, or a later version of it, and this server has not. */
struct Unsupported {
  std::string operation;  ///< printable
};
using ClientRequest = std::variant<Subscribe, Unsubscribe, Unsupported>;

/** \brief Keys that are not known are ignored, as the protocol may have more of them some day. \throws FormatError whose text is a reason to
 *  close for: short, ASCII, and without what the client sent */
ClientRequest clientRequest(std::string_view message, bool binary);

}  // namespace fuse_flow::stream::foxglove
