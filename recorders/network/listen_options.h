// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "datasets/hdf5/chunk_codec.h"
#include "recorders/network/link/socket_link.h"
#include "recorders/network/link/tls_keys.h"

namespace trilat {

struct ListenOptions {
  SocketAddress address;
  TlsKeys keys;  // of the agents; none: plain text, on loopback only unless allowed
  bool allow_plain_text = false;
  ChunkCompression compression = ChunkCompression::blosc;  // of the frames delivered, whatever agents send
  std::size_t queue_bytes = std::size_t{64} << 20;         // received and not yet taken by next()
  // Connections that have not yet said who they are; where there are more, the oldest go.
  std::size_t max_pending = 64;
  std::size_t max_pending_an_address = 16;  // but for this machine's own
  std::chrono::milliseconds handshake_limit{5000};
  std::chrono::milliseconds silence_limit{5000};
  std::chrono::milliseconds exchange_period{250};
  // How long agents may take to send what they hold when the recording is stopped; what is left then is lost
  // and counted.
  std::chrono::milliseconds drain_limit{10000};
  // Who was turned away and why, at most one line a second. Any thread, one at a time.
  std::function<void(const std::string& line)> on_refusal = [](const std::string&) {};
};

}  // namespace trilat
