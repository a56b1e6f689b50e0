// SPDX-License-Identifier: MIT
#include "recorders/network/socket_address.h"

#include <charconv>

#include "datasets/base/error.h"

namespace trilat {

SocketAddress parse_address(const std::string& text) {
  const auto colon = text.rfind(':');
  SocketAddress address;
  const char* end = text.data() + text.size();
  const char* start = colon == std::string::npos ? end : text.data() + colon + 1;
  const auto [stop, error] = std::from_chars(start, end, address.port);
  if (start == end || error != std::errc() || stop != end)
    throw InputError(text, "must be HOST:PORT, with a port of 0 to 65535");
  address.host = text.substr(0, colon);
  if (address.host.starts_with('[') && address.host.ends_with(']'))
    address.host = address.host.substr(1, address.host.size() - 2);
  else if (address.host.find(':') != std::string::npos)
    throw InputError(text, "must have its IPv6 address in brackets, as in [::1]:7345");
  return address;
}

bool is_loopback(const SocketAddress& address) {
  // a name that only begins so could be anybody's
  const bool literal = address.host.find_first_not_of("0123456789.") == std::string::npos;
  return address.host == "localhost" || address.host == "::1" ||
         (literal && address.host.starts_with("127."));
}

std::string text_of(const SocketAddress& address) {
  const bool v6 = address.host.find(':') != std::string::npos;
  return (v6 ? '[' + address.host + ']' : address.host) + ':' + std::to_string(address.port);
}

}  // namespace trilat
