// SPDX-License-Identifier: MIT
#pragma once

#include "recorders/network/link/byte_link.h"
#include "recorders/network/link/socket_address.h"

namespace trilat {

inline constexpr std::chrono::milliseconds kConnectLimit{2000};

// Reaches the recording machine in plain text: InputError unless the address is this machine or
// `allow_everywhere`.
ConnectLink connect_in_plain_text(const SocketAddress& address, bool allow_everywhere = false);

}  // namespace trilat
