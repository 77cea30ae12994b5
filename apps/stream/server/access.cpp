#include "stream/server/access.h"

#include "stream/network/text.h"

#include <openssl/crypto.h>
#include <openssl/sha.h>

#include <algorithm>
#include <utility>

namespace fuse_flow::stream::network {

namespace {

/** \brief The host of an origin "http://host:port", with its port; empty: it is none, as "null". */
std::string_view authorityOf(std::string_view origin, std::string_view& scheme) {
  const std::size_t colon = origin.find("://");
  if (colon == std::string_view::npos) return {};
  scheme = origin.substr(0, colon);
  return origin.substr(colon + 3);
}

/** \brief Without the port that a scheme has anyway: browsers leave it out in one place, and others write it in the other. */
std::string_view withoutUsualPort(std::string_view host, std::string_view scheme) {
  const std::string_view usual = sameWithoutCase(scheme, "https") ? ":443" : ":80";
  if (host.size() > usual.size() && host.substr(host.size() - usual.size()) == usual) host.remove_suffix(usual.size());
  return host;
}

}  // namespace

std::string_view withoutPort(std::string_view host) {
  const std::size_t colon = host.rfind(':');
  if (colon == std::string_view::npos || host.find(']', colon) != std::string_view::npos) return host;
  return host.substr(0, colon);
}

bool isLoopbackName(std::string_view host) {
  if (sameWithoutCase(host, "localhost") || host == "[::1]") return true;
  // 127.x.x.x, and nothing that only begins like it, as 127.evil.example.
  if (host.substr(0, 4) != "127.") return false;
  return std::count(host.begin(), host.end(), '.') == 3 && host.back() != '.' &&
         std::all_of(host.begin(), host.end(), [](char c) { return c == '.' || (c >= '0' && c <= '9'); });
}

Access::Access(std::string token, std::vector<std::string> allowed_origins, std::vector<std::string> allowed_hosts)
    : token_(std::move(token)),
      allowed_origins_(std::move(allowed_origins)),
      allowed_hosts_(std::move(allowed_hosts)) {}

bool Access::mayAsk(const Credentials& who) const {
  if (!token_.empty()) return true;
  const std::string_view name = withoutPort(who.host);
  return isLoopbackName(name) || std::any_of(allowed_hosts_.begin(), allowed_hosts_.end(),
                                             [&](const std::string& host) { return sameWithoutCase(host, name); });
}

bool Access::mayConnectFrom(const Credentials& who) const {
  if (who.origin.empty()) return true;  // no browser, which always says it
  if (std::any_of(allowed_origins_.begin(), allowed_origins_.end(),
                  [&](const std::string& origin) { return sameWithoutCase(origin, who.origin); }))
    return true;
  std::string_view scheme;
  const std::string_view authority = authorityOf(who.origin, scheme);
  if (!sameWithoutCase(scheme, "http") && !sameWithoutCase(scheme, "https")) return false;
  return !authority.empty() && sameWithoutCase(withoutUsualPort(authority, scheme), withoutUsualPort(who.host, scheme));
}

bool Access::isToken(std::string_view given) const {
  // Digests are of one length, and say nothing of how much of it is right.
  unsigned char ours[SHA256_DIGEST_LENGTH], theirs[SHA256_DIGEST_LENGTH];
  SHA256(reinterpret_cast<const unsigned char*>(token_.data()), token_.size(), ours);
  SHA256(reinterpret_cast<const unsigned char*>(given.data()), given.size(), theirs);
  return CRYPTO_memcmp(ours, theirs, sizeof(ours)) == 0;
}

bool Access::hasToken(const Credentials& who) const {
  if (token_.empty()) return true;
  constexpr std::string_view bearer = "Bearer ";
  if (who.authorization.size() > bearer.size() && sameWithoutCase(who.authorization.substr(0, bearer.size()), bearer) &&
      isToken(who.authorization.substr(bearer.size())))
    return true;
  const std::optional<std::string> in_query = queryValue(who.query, "token");
  return in_query && isToken(*in_query);
}

}  // namespace fuse_flow::stream::network
