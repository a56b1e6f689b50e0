// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "recorders/network/link/byte_link.h"
#include "recorders/network/link/tls_keys.h"

namespace trilat {

enum class TlsSide { agent, server };

// TLS 1.3 over `inner` with a key that both sides share, of which an agent has one; neither side proves
// anything else. Blocks until the handshake is done: LinkLost where it is not in time or `give_up` says so,
// LinkRefused where a key is not the other side's.
std::unique_ptr<ByteLink> secure_link(
    std::unique_ptr<ByteLink> inner, const TlsKeys& keys, TlsSide side, std::chrono::milliseconds at_most,
    const std::function<bool()>& give_up = [] { return false; });

}  // namespace trilat
