// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "recorders/network/link/byte_link.h"
#include "recorders/network/link/wire.h"

namespace trilat {

// Cuts a stream of bytes into messages. Holds at most one message and what one add() brought. The first
// message has a limit of its own: a stranger gets little memory.
class MessageReader {
 public:
  void add(std::span<const std::byte> bytes);
  // The next complete message, or what is wrong, from where nothing more is read; nothing when more bytes are
  // needed.
  std::optional<std::variant<Message, WireError>> next();

 private:
  std::vector<std::byte> bytes_;
  std::size_t start_ = 0;
  bool first_ = true;
  bool broken_ = false;
};

// Whoever receives looks after so many messages whether it is to stop: a peer may never pause.
inline constexpr int kMessagesATurn = 64;

// Messages over a link of bytes. Nothing but wait() blocks; all but wake() belong to one thread.
class MessageLink {
 public:
  // A peer that has been silent for longer than `silence_limit` is taken for gone.
  MessageLink(std::unique_ptr<ByteLink> link, std::chrono::milliseconds silence_limit);

  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  void send(Bytes encoded);
  void send(const Message& message);
  // Says that we are there, unless something has been sent within the last second.
  void send_sign_of_life(const Message& message);
  // True while the link has not taken all that was to be sent.
  bool sending() const { return !outgoing_.empty(); }
  // The next message that has arrived, nothing where there is none now. Throws LinkLost, and LinkRefused
  // where the peer sends what is no message.
  std::optional<Message> receive();
  // Waits for something to read, for room where sending(), for a wake() or for the time to pass.
  void wait(std::chrono::milliseconds at_most);
  void wake() { link_->wake(); }
  std::string peer_name() const { return link_->peer_name(); }

 private:
  using Clock = std::chrono::steady_clock;
  void flush();

  std::unique_ptr<ByteLink> link_;
  std::chrono::milliseconds silence_limit_;
  Clock::time_point last_heard_ = Clock::now();
  Clock::time_point last_sent_ = Clock::now();
  MessageReader reader_;
  std::vector<std::byte> block_;
  std::deque<Bytes> outgoing_;
  std::size_t outgoing_start_ = 0;  // of the first
};

}  // namespace trilat
