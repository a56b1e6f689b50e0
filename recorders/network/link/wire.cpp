// SPDX-License-Identifier: MIT
#include "recorders/network/link/wire.h"

#include <algorithm>
#include <cmath>
#include <concepts>

#include "datasets/base/error.h"

namespace trilat {
namespace {

// Every message says its fields once, in the order of their bytes, to one of these: what they are is written,
// or read into them.
struct Put {
  ByteWriter& out;

  void number(const auto& value) { out.put(value); }
  void finite(const double& value) { out.put(value); }
  void count(const std::int64_t& value) { out.put(value); }
  void numbers(const auto& values) {
    for (const auto& value : values) out.put(value);
  }
  void flag(const bool& value) { out.put(static_cast<std::uint8_t>(value)); }
  void word(const auto& value, auto) { out.put(static_cast<std::uint8_t>(value)); }
  void text(const std::string& text, std::size_t limit) { out.put_text(text, limit); }
  void list(const auto& list, std::size_t most, const auto& each) {
    TRILAT_CHECK(list.size() <= most, "a message of ours keeps its limits");
    out.put(static_cast<std::uint8_t>(list.size()));
    for (const auto& entry : list) each(entry);
  }
  void rest(const std::vector<std::byte>& bytes) { out.put_bytes(bytes); }
};

struct Get {
  ByteReader& in;

  template <class T>
  void number(T& value) {
    value = in.get<T>();
  }
  void finite(double& value) {
    number(value);
    if (!std::isfinite(value)) in.refuse();
  }
  void count(std::int64_t& value) {
    number(value);
    if (value < 0) in.refuse();
  }
  void numbers(auto& values) {
    for (auto& value : values) number(value);
  }
  void flag(bool& value) {
    const auto byte = in.get<std::uint8_t>();
    if (byte > 1) in.refuse();
    value = byte == 1;
  }
  template <class Enum>
  void word(Enum& value, Enum last) {
    const auto byte = in.get<std::uint8_t>();
    if (byte > static_cast<std::uint8_t>(last)) in.refuse();
    value = static_cast<Enum>(byte);
  }
  void text(std::string& text, std::size_t limit) { text = in.get_text(limit); }
  void list(auto& list, std::size_t most, const auto& each) {
    const auto size = in.get<std::uint8_t>();
    if (size > most) in.refuse();
    for (int i = 0; i < size && !in.failed(); ++i) each(list.emplace_back());
  }
  void rest(std::vector<std::byte>& bytes) {
    const auto left = in.get_bytes(in.left());
    bytes.assign(left.begin(), left.end());
  }
};

template <class T, class Wanted>
concept Is = std::same_as<std::remove_const_t<T>, Wanted>;

void pass(auto& wire, Is<SensorDescription> auto& sensor) {
  for (auto* text : {&sensor.name, &sensor.serial, &sensor.model, &sensor.source})
    wire.text(*text, kMaxNameBytes);
  auto& in = sensor.intrinsics;
  wire.number(in.width_px);
  wire.number(in.height_px);
  for (auto* number : {&in.fx_px, &in.fy_px, &in.cx_px, &in.cy_px, &in.k1, &in.k2, &in.k3, &in.p1, &in.p2})
    wire.finite(*number);
  wire.number(sensor.tick_ns);
  wire.number(sensor.nominal_rate_hz);
  wire.number(sensor.latency_ns);
  wire.flag(sensor.has_depth);
}

void pass(auto& wire, Is<FrameStamp> auto& stamp) {
  wire.number(stamp.sequence);
  wire.number(stamp.device_ticks);
  wire.number(stamp.arrival_ns);
}

void pass(auto& wire, Is<Body> auto& body) {
  wire.number(body.tracking_id);
  for (auto& point : body.position_m) wire.numbers(point);
  for (auto& turn : body.orientation_xyzw) wire.numbers(turn);
  wire.numbers(body.tracking_state);
  wire.numbers(body.hand_state);
  wire.numbers(body.hand_confidence);
}

void pass(auto& wire, Is<BodyFrame> auto& frame) {
  pass(wire, frame.stamp);
  wire.numbers(frame.floor_plane);
  wire.list(frame.bodies, kMaxBodies, [&](auto& body) { pass(wire, body); });
}

void pass(auto& wire, Is<EncodedDepthFrame> auto& frame) {
  pass(wire, frame.stamp);
  wire.word(frame.compression, ChunkCompression::deflate);
  wire.rest(frame.chunk);
}

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
