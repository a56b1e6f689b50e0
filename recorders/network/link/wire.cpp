// SPDX-License-Identifier: MIT
#include "recorders/network/link/wire.h"

#include <algorithm>
#include <cmath>
#include <concepts>

#include "datasets/base/error.h"

namespace trilat {
namespace {

void pass(auto& wire, Is<SourceNotice> auto& notice) { wire.text(notice.text, kMaxTextBytes); }

void pass(auto& wire, Is<DropCount> auto& drops) {
  wire.count(drops.at_source);
  wire.count(drops.in_queue);
}

// Behind the magic number and the version.
void pass(auto& wire, Is<HelloMessage> auto& hello) {
  wire.word(hello.role, LinkRole::clock);
  wire.text(hello.agent, kMaxNameBytes);
  wire.number(hello.incarnation);
  wire.number(hello.recording);
  wire.flag(hello.simulated);
  wire.list(hello.sensors, kMaxSessionSensors, [&](auto& sensor) { pass(wire, sensor); });
}

void pass(auto& wire, Is<WelcomeMessage> auto& welcome) {
  wire.number(welcome.recording);
  wire.number(welcome.next_number);
}

void pass(auto& wire, Is<RefusalMessage> auto& refusal) {
  wire.flag(refusal.try_again);
  wire.text(refusal.reason, kMaxTextBytes);
}

void pass(auto& wire, Is<ResumeMessage> auto& resume) { wire.number(resume.lost_frames); }

void pass(auto& wire, Is<EventMessage> auto& event) {
  wire.number(event.number);
  wire.number(event.sensor);
  std::visit([&](auto& data) { pass(wire, data); }, event.data);
}

void pass(auto& wire, Is<AckMessage> auto& ack) { wire.number(ack.next_number); }
void pass(auto&, Is<AliveMessage> auto&) {}
void pass(auto&, Is<StopMessage> auto&) {}
void pass(auto& wire, Is<HeldMessage> auto& held) { wire.number(held.end_number); }
void pass(auto& wire, Is<ClockPingMessage> auto& ping) { wire.number(ping.id); }

void pass(auto& wire, Is<ClockPongMessage> auto& pong) {
  wire.number(pong.id);
  wire.number(pong.t2_ns);
  wire.number(pong.t3_ns);
}

void pass(auto& wire, Is<ByeMessage> auto& bye) {
  wire.number(bye.number);
  wire.text(bye.problem, kMaxTextBytes);
}

// An empty message of each type; the type byte is its number here, from 1. None is ever used for anything
// else.
const std::vector<Message>& messages() {
  static const std::vector<Message> all{HelloMessage{},
                                        WelcomeMessage{},
                                        RefusalMessage{},
                                        ResumeMessage{},
                                        EventMessage{.data = BodyFrame{}},
                                        EventMessage{.data = EncodedDepthFrame{}},
                                        EventMessage{.data = SourceNotice{}},
                                        EventMessage{.data = DropCount{}},
                                        AckMessage{},
                                        AliveMessage{},
                                        ClockPingMessage{},
                                        ClockPongMessage{},
                                        ByeMessage{},
                                        StopMessage{},
                                        HeldMessage{}};
  return all;
}

std::uint8_t type_of(const Message& message) {
  const auto same = [&](const Message& other) {
    if (other.index() != message.index()) return false;
    const auto *event = std::get_if<EventMessage>(&message), *known = std::get_if<EventMessage>(&other);
    return !event || event->data.index() == known->data.index();
  };
  const auto found = std::find_if(messages().begin(), messages().end(), same);
  return static_cast<std::uint8_t>(found - messages().begin() + 1);
}

constexpr std::uint8_t kHello = 1;

}  // namespace

std::vector<std::byte> encode_message(const Message& message) {
  ByteWriter out;
  out.put(std::uint32_t{0});
  out.put(type_of(message));
  if (std::holds_alternative<HelloMessage>(message)) {
    out.put(kWireMagic);
    out.put(kWireVersion);
  }
  Put put{out};
  std::visit([&](const auto& m) { pass(put, m); }, message);
  std::vector<std::byte> bytes = out.take();
  const std::size_t length = bytes.size() - kLengthBytes;
  TRILAT_CHECK(length <= kMaxMessageBytes, "a message of ours fits the limit");
  for (std::size_t i = 0; i < kLengthBytes; ++i) bytes[i] = static_cast<std::byte>(length >> (8 * i));
  return bytes;
}

std::variant<Message, WireError> decode_message(std::span<const std::byte> body) {
  if (body.size() > kMaxMessageBytes) return WireError{"a message is too long"};
  ByteReader in(body);
  const auto type = in.get<std::uint8_t>();
  if (type == kHello) {
    if (in.get<std::uint32_t>() != kWireMagic) return WireError{"does not speak trilat's protocol"};
    const auto version = in.get<std::uint16_t>();
    if (!in.failed() && version != kWireVersion)
      return WireError{"speaks version " + std::to_string(version) + " of the protocol, not " +
                       std::to_string(kWireVersion)};
  }
  const bool known = type > 0 && type <= messages().size();
  Message message = known ? messages()[type - 1u] : Message(AliveMessage{});
  Get get{in};
  std::visit([&](auto& m) { pass(get, m); }, message);
  if (!known || in.failed() || in.left() != 0)
    return WireError{"a message of type " + std::to_string(type) + " is damaged"};
  return message;
}

}  // namespace trilat
