// SPDX-License-Identifier: MIT
#include <charconv>
#include <string_view>

#include "datasets/base/error.h"
#include "recorders/link/byte_stream.h"

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

namespace {

// 127.0.0.0 to 127.255.255.255, written out; a name that only begins so could be anybody's.
bool is_loopback_v4(const std::string& text) {
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int part = 0; part < 4; ++part) {
    std::uint8_t value = 0;
    const auto [stop, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (part == 0 && value != 127)) return false;
    at = stop;
    if (part < 3 && (at == end || *at++ != '.')) return false;
  }
  return at == end;
}

}  // namespace

bool is_loopback(const SocketAddress& address) {
  constexpr std::string_view kMapped = "::ffff:";
  const std::string& host = address.host;
  return host == "localhost" || host == "::1" || is_loopback_v4(host) ||
         (host.starts_with(kMapped) && is_loopback_v4(host.substr(kMapped.size())));
}

std::string text_of(const SocketAddress& address) {
  const bool v6 = address.host.find(':') != std::string::npos;
  return (v6 ? '[' + address.host + ']' : address.host) + ':' + std::to_string(address.port);
}

}  // namespace trilat
