// SPDX-License-Identifier: MIT
#include "recorders/network/agent_connect.h"

#include "recorders/network/plain_connect.h"

namespace trilat {
namespace {

constexpr std::chrono::milliseconds kHandshakeLimit{5000};

}  // namespace

ConnectLink connect_to_server(const SocketAddress& address, const TlsKeys& key, bool allow_plain_text) {
  if (key.empty()) return connect_in_plain_text(address, allow_plain_text);
  return [=]() -> std::unique_ptr<ByteLink> {
    return secure_link(connect_socket(address, kConnectLimit), key, TlsSide::agent, kHandshakeLimit);
  };
}

}  // namespace trilat
