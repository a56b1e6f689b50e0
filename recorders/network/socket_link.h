// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "recorders/network/byte_link.h"

namespace trilat {

// HOST:PORT, as a person writes it; an IPv6 address stands in brackets. An empty host means every address.
struct SocketAddress {
  std::string host;
  std::uint16_t port = 0;
};

// InputError naming `text` where it is not HOST:PORT.
SocketAddress parse_address(const std::string& text);

// True for localhost and literal addresses that never leave this machine; no other name is believed.
bool is_loopback(const SocketAddress& address);

// TCP without delay of small messages. Throws LinkLost where nobody answers in time, InputError where there
// is no such host.
std::unique_ptr<ByteLink> connect_socket(const SocketAddress& address, std::chrono::milliseconds at_most);

// Takes connections. One thread at a time.
class SocketListener {
 public:
  // Port 0 takes any free one. InputError where the address cannot be listened on.
  explicit SocketListener(const SocketAddress& address);
  ~SocketListener();
  SocketListener(const SocketListener&) = delete;
  SocketListener& operator=(const SocketListener&) = delete;

  std::uint16_t port() const { return port_; }

  struct Accepted {
    std::unique_ptr<ByteLink> link;
    std::string from;  // address of the peer, for people
  };
  // The next connection, or nothing when none came in time.
  std::optional<Accepted> accept(std::chrono::milliseconds at_most);

 private:
  int socket_ = -1;
  std::uint16_t port_ = 0;
};

}  // namespace trilat
