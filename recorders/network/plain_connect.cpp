// SPDX-License-Identifier: MIT
#include "recorders/network/plain_connect.h"

#include "datasets/base/error.h"
#include "recorders/network/link/socket_link.h"

namespace trilat {

ConnectLink connect_in_plain_text(const SocketAddress& address, bool allow_everywhere) {
  if (!allow_everywhere && !is_loopback(address))
    throw InputError(
        address.host,
        "plain text may only be spoken on this machine; give keys, or a tunnel's end on this machine");
  return [address] { return connect_socket(address, kConnectLimit); };
}

}  // namespace trilat
