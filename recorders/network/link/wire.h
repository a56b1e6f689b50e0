// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "datasets/session/event_bytes.h"
#include "recorders/frame_source.h"

namespace trilat {

// What agents and the recording machine say to each other. On the wire a message is its length (u32), a type
// byte and its fields, all little-endian; texts carry their length (u16) and hold no control characters.
inline constexpr std::uint16_t kWireVersion = 3;
inline constexpr std::size_t kLengthBytes = 4;
inline constexpr std::size_t kMaxMessageBytes = 2u << 20;        // without the length
inline constexpr std::size_t kMaxFirstMessageBytes = 96u << 10;  // holds kMaxSessionSensors descriptions

enum class LinkRole : std::uint8_t { data = 0, clock = 1 };

// An agent's first message on a connection. `incarnation` tells one run of an agent from the next, whose
// message numbers begin anew. A clock connection names its agent only.
struct HelloMessage {
  LinkRole role = LinkRole::data;
  std::string agent;
  std::uint64_t incarnation = 0;
  bool simulated = false;
  std::vector<SensorDescription> sensors;
  std::uint64_t recording = 0;  // that this run takes part in; 0: none yet
};

// The recording has begun: send from this message number on. `recording` tells one from the next; another
// than the agent takes part in means that the one before is gone, and that it has to come anew.
struct WelcomeMessage {
  std::uint64_t recording = 0;
  std::uint64_t next_number = 0;
};

struct RefusalMessage {
  std::string reason;
  bool try_again = false;  // the reason may pass by itself
};

// The answer to a welcome: frames that this run of the agent has lost for good, all sensors together.
struct ResumeMessage {
  std::uint64_t lost_frames = 0;
};

// One event of a sensor; `sensor` counts the agent's own. Numbers grow within a run of the agent; what was
// lost leaves a gap. A drop count's time is set where it arrives.
struct EventMessage {
  std::uint64_t number = 0;
  std::uint32_t sensor = 0;
  std::variant<BodyFrame, EncodedDepthFrame, SourceNotice, DropCount> data;
};

// Everything before this number has arrived for good. Also sent now and then as a sign of life.
struct AckMessage {
  std::uint64_t next_number = 0;
};

struct AliveMessage {};

struct ClockPingMessage {
  std::uint64_t id = 0;
};

struct ClockPongMessage {
  std::uint64_t id = 0;
  std::int64_t t2_ns = 0;
  std::int64_t t3_ns = 0;
};

// From the recording machine: no more frames are wanted; the agent sends what it holds, and then says bye.
struct StopMessage {};

// An agent's answer: the number behind that of the last message it holds.
struct HeldMessage {
  std::uint64_t end_number = 0;
};

// From an agent: its last message, and why its source broke where it did. From the recording machine: the
// recording is over.
struct ByeMessage {
  std::uint64_t number = 0;
  std::string problem{};
};

using Message =
    std::variant<HelloMessage, WelcomeMessage, RefusalMessage, ResumeMessage, EventMessage, AckMessage,
                 AliveMessage, ClockPingMessage, ClockPongMessage, ByeMessage, StopMessage, HeldMessage>;

struct WireError {
  std::string problem;
};

// With the length in front. Texts are cut to their limit, control characters in them become blanks.
std::vector<std::byte> encode_message(const Message& message);

// `body` is a message without its length. Any bytes whatever give a message or say what is wrong; no size in
// them is believed. Compressed depth is not looked into.
std::variant<Message, WireError> decode_message(std::span<const std::byte> body);

// First in every hello, so that a stranger is recognised whatever it speaks.
inline constexpr std::uint32_t kWireMagic = 0x4c495254;  // "TRIL"

}  // namespace trilat
