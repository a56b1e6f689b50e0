// SPDX-License-Identifier: MIT
#include "recorders/network/agent_connect.h"

#include "recorders/network/plain_connect.h"

namespace trilat {
namespace {

constexpr std::chrono::milliseconds kHandshakeLimit{5000};

}  // namespace

ConnectLink connect_to_server(const SocketAddress& address, std::shared_ptr<const TlsIdentity> identity,
                              bool allow_plain_text) {
  if (!identity) return connect_in_plain_text(address, allow_plain_text);
  return [=]() -> std::unique_ptr<ByteLink> {
    return secure_link(connect_socket(address, kConnectLimit), *identity, TlsSide::agent, kHandshakeLimit);
  };
}

}  // namespace trilat
