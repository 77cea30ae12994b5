#pragma once

#include <string>

namespace fuse_flow::stream::network {

/** \brief Where a client connects to. */
struct Link {
  bool tls{false};
  std::string host;  ///< a name or an address, IPv6 without brackets
  std::string port;
  std::string path;
  std::string token;  ///< of the query; empty: none

  /** \brief For the header Host, and for people. */
  std::string authority() const;
};

/** \throws std::invalid_argument whose text says what a link must be, and has no token in it */
Link parseLink(const std::string& text);

}  // namespace fuse_flow::stream::network
