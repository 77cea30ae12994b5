#include "../../fuzz_target.h"

#include "stream/network/link.h"
#include "stream/network/text.h"

#include <stdexcept>

/** \brief A link of a server, and the texts of a request: what is behind a question mark, and what of others' is printed. */
FUSE_FLOW_FUZZ_TARGET(stream_link, 1 << 16, 64, 2000) {
  using namespace fuse_flow::stream::network;
  fuse_flow_fuzz::accepts<std::invalid_argument>([&] { parseLink(std::string(input)).authority(); });
  percentDecoded(input);
  queryValue(input, "token");
  isToken(input);
  // A text that was cut ends with …, which is no ASCII.
  for (const char c : printable(input).substr(0, 100))
    fuse_flow_fuzz::require(c >= ' ' && c <= '~', "a character that a terminal may obey");
}
