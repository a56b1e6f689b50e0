// SPDX-License-Identifier: MIT
#pragma once

#include "recorders/network/link/byte_link.h"
#include "recorders/network/link/socket_link.h"
#include "recorders/network/link/tls_link.h"

namespace trilat {

// How an agent reaches the recording machine. Without its key in plain text: InputError unless the address is
// this machine or plain text is allowed.
ConnectLink connect_to_server(const SocketAddress& address, const TlsKeys& key, bool allow_plain_text);

}  // namespace trilat
