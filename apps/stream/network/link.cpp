#include "stream/network/link.h"

#include "stream/network/text.h"

#include <algorithm>
#include <stdexcept>

namespace fuse_flow::stream::network {

namespace {

/** \brief Host and port of "host", "host:port", "[address]:port"; false: it is none. */
bool split(const std::string& authority, Link& link) {
  std::size_t end = authority.find(':');
  if (!authority.empty() && authority[0] == '[') {
    const std::size_t bracket = authority.find(']');
    if (bracket == std::string::npos) return false;
    link.host = authority.substr(1, bracket - 1);
    end = bracket + 1;
  } else {
    link.host = authority.substr(0, end);
    end = std::min(end, authority.size());
  }
  if (link.host.empty()) return false;
  for (const char c : link.host)
    if (c <= ' ' || c > '~' || c == '/' || c == '@' || c == '%' || c == '\\') return false;
  if (end >= authority.size()) return true;
  if (authority[end] != ':') return false;
  link.port = authority.substr(end + 1);
  if (link.port.empty() || link.port.size() > 5) return false;
  if (!std::all_of(link.port.begin(), link.port.end(), [](char c) { return c >= '0' && c <= '9'; })) return false;
  const int port = std::stoi(link.port);
  return port >= 1 && port <= 65535;
}

}  // namespace

std::string Link::authority() const {
  return (host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" + port;
}

Link parseLink(const std::string& text) {
  const std::string shown = "'" + printable(text.substr(0, text.find('?'))) + "'";
  const auto fail = [&](const std::string& what) { throw std::invalid_argument(shown + ": " + what); };
  const std::string must = "must be as ws://192.168.1.7:8080 or https://camera-room:8080/?token=…";
  Link link;
  const std::size_t scheme_end = text.find("://");
  if (scheme_end == std::string::npos) fail("is no link, " + must);
  const std::string scheme = text.substr(0, scheme_end);
  if (sameWithoutCase(scheme, "wss") || sameWithoutCase(scheme, "https"))
    link.tls = true;
  else if (!sameWithoutCase(scheme, "ws") && !sameWithoutCase(scheme, "http"))
    fail("is no link to a stream, " + must);
  link.port = link.tls ? "443" : "80";
  std::string rest = text.substr(scheme_end + 3);
  rest.resize(std::min(rest.find('#'), rest.size()));
  const std::size_t query = std::min(rest.find('?'), rest.size());
  const std::size_t path = std::min(rest.find('/'), query);
  if (!split(rest.substr(0, path), link)) fail("has no host, or a wrong port, " + must);
  link.path = rest.substr(path, query - path);
  if (link.path.empty() || link.path == "/") link.path = "/stream";
  for (const char c : link.path)
    if (c <= ' ' || c > '~') fail("has a character in its path that must be written as %20 is");
  if (query < rest.size()) link.token = queryValue(rest.substr(query + 1), "token").value_or("");
  return link;
}

}  // namespace fuse_flow::stream::network
