// SPDX-License-Identifier: MIT
#include "recorders/network/agent_connect.h"

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::chrono::milliseconds kConnectLimit{2000};
constexpr std::chrono::milliseconds kHandshakeLimit{5000};

}  // namespace

ConnectLink connect_to_server(const SocketAddress& address, std::shared_ptr<const TlsIdentity> identity,
                              bool allow_plain_text) {
  if (!identity && !allow_plain_text && !is_loopback(address))
    throw InputError(address.host, "plain text may only be spoken on this machine; give keys");
  return [=]() -> std::unique_ptr<ByteLink> {
    auto link = connect_socket(address, kConnectLimit);
    if (!identity) return link;
    return secure_link(std::move(link), *identity, TlsSide::agent, kHandshakeLimit);
  };
}

}  // namespace trilat
