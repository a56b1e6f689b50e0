// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "datasets/session/event_bytes.h"

namespace trilat {

// Messages between an agent and the recorder. A message is its length (u32), a type byte and its
// fields, all little-endian; texts carry their length (u16) and hold no control characters.
inline constexpr std::uint16_t kLinkVersion = 5;
inline constexpr std::size_t kMaxMessageBytes = 2u << 20;
inline constexpr std::size_t kMaxSentBytes = 256u << 10;  // of a log in one message

enum class LinkRole : std::uint8_t { data = 0, clock = 1 };

// First message of an agent on a connection. Behind the type come "TRIL" and the version, whatever that is.
struct HelloMessage {
  LinkRole role = LinkRole::data;
  std::string agent;
  std::uint64_t run = 0;        // of the agent's process
  std::uint64_t log = 0;        // id of the log that it sends; 0: none yet
  std::uint64_t recording = 0;  // id of the recording that the log belongs to; 0: none yet
};

// The recording has begun. `offset`: bytes of the agent's log that are on the recorder's disk.
struct WelcomeMessage {
  std::uint64_t recording = 0, offset = 0;
};

struct RefusalMessage {
  std::string reason;
  bool try_again = false;  // the reason may pass by itself
};

// Bytes of the agent's log behind those that it sent before. `frames`: in all of its log so far.
struct BytesMessage {
  std::uint64_t offset = 0, frames = 0;
  std::vector<std::byte> bytes;
};

// Newest bodies, of an agent whose log has much that was not sent yet; for a preview, and not stored.
struct LiveMessage {
  std::uint8_t sensor = 0;
  BodyFrame frame;
};

// Bytes of the agent's log that are on the recorder's disk; also a sign of life. `stop`: no more frames are
// wanted.
struct AckMessage {
  std::uint64_t synced = 0;
  bool stop = false;
};

struct PingMessage {};

// When the recorder's host clock received a ping, and when it answered.
struct PongMessage {
  std::int64_t received_ns = 0, sent_ns = 0;
};

using Message = std::variant<HelloMessage, WelcomeMessage, RefusalMessage, BytesMessage, LiveMessage,
                             AckMessage, PingMessage, PongMessage>;

// With the length in front. Texts are cut to their limit, control characters in them become blanks.
std::vector<std::byte> encode_message(const Message& message);

// The other side's message is not one of this program; the text says why.
class BadMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Turns received bytes into messages. Any bytes whatever give a message or BadMessage; no size in them is
// believed.
class MessageReader {
 public:
  void add(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  // The next message that is there whole.
  std::optional<Message> next();

 private:
  std::vector<std::byte> bytes_;
  std::size_t taken_ = 0;
};

}  // namespace trilat
