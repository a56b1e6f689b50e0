// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

namespace trilat {

// HOST:PORT, as a person writes it; an IPv6 address stands in brackets. An empty host means every address.
struct SocketAddress {
  std::string host;
  std::uint16_t port = 0;
};

// InputError naming `text` where it is not HOST:PORT.
SocketAddress parse_address(const std::string& text);

// Text of an address as parse_address() reads it.
std::string text_of(const SocketAddress& address);

// True for localhost and addresses that never leave this machine.
bool is_loopback(const SocketAddress& address);

}  // namespace trilat
