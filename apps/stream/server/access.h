#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fuse_flow::stream::network {

/** \brief What a request says of who asks, as it came; empty: the header is not there. */
struct Credentials {
  std::string_view host;           ///< header Host
  std::string_view origin;         ///< header Origin
  std::string_view authorization;  ///< header Authorization
  std::string_view query;          ///< of the target, without '?'
};

/** \brief Who may come in. Nothing changes it, and many threads may use it.
 *
 *  A browser lets any page open a WebSocket to any server, and says in Origin whose page it is; so Origin, where there is one, must be this
 *  server's own, that is, its host the one that was asked for (Host), or one of a list. That alone does not help a server without a token:
 *  a page of http://evil.example/ whose name is made to lead to 127.0.0.1 ("DNS rebinding") has the same Origin as Host. So there Host must
 *  be a name of this machine. */
class Access {
 public:
  Access(std::string token, std::vector<std::string> allowed_origins, std::vector<std::string> allowed_hosts);

  /** \brief Files need no token; but a server without one shows them to no page of another name. */
  bool mayAsk(const Credentials& who) const;
  /** \brief Whether the page that asks is ours, or nobody's. */
  bool mayConnectFrom(const Credentials& who) const;
  /** \brief In a time that does not tell how much of the token is right. */
  bool hasToken(const Credentials& who) const;

 private:
  bool isToken(std::string_view given) const;

  std::string token_;
  std::vector<std::string> allowed_origins_, allowed_hosts_;
};

/** \brief A host without its port: "[::1]:80" → "[::1]". */
std::string_view withoutPort(std::string_view host);

/** \brief localhost, 127.x.x.x or [::1], without a port. */
bool isLoopbackName(std::string_view host);

}  // namespace fuse_flow::stream::network
