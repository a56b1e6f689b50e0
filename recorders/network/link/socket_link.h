// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "recorders/network/link/byte_link.h"
#include "recorders/network/link/socket_address.h"

namespace trilat {

// TCP without delay of small messages. Throws LinkLost where nobody answers in time, InputError where there
// is no such host.
std::unique_ptr<ByteLink> connect_socket(const SocketAddress& address, std::chrono::milliseconds at_most);

// Takes connections. One thread at a time. Not on Windows, where only agents are.
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
