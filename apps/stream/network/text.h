#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fuse_flow::stream::network {

/** \brief What others sent, fit for a line: what is no printable ASCII becomes '?', and a long text is cut. */
std::string printable(std::string_view text, std::size_t most = 100);

/** \brief Without %20 and the like; absent where that is malformed. */
std::optional<std::string> percentDecoded(std::string_view text);

/** \brief Of the query "a=1&token=x", the value of a name, decoded; absent: it is not there, or malformed. */
std::optional<std::string> queryValue(std::string_view query, std::string_view name);

/** \brief a, b without regard to the case of ASCII letters. */
bool sameWithoutCase(std::string_view a, std::string_view b);

/** \brief Whether a token is one of 16 … 256 letters, digits, '-', '.', '_', '~', which stand in a link as they are. */
bool isToken(std::string_view token);

/** \brief Nanoseconds since 1970, as in FrameTimes. */
std::int64_t nanosecondsSince1970();

/** \brief Lines for whoever asks; many threads may use it. A flood of them is counted, not kept. */
class Notices {
 public:
  void add(std::string line);
  std::vector<std::string> take();

 private:
  std::mutex mutex_;
  std::vector<std::string> lines_;
  std::size_t more_{0};
};

}  // namespace fuse_flow::stream::network
