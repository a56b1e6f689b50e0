// SPDX-License-Identifier: MIT
#include <cmath>

#include "recorders/network/link/wire.h"
#include "recorders/network/link/wire_bytes.h"

namespace trilat {
namespace {

bool get_flag(ByteReader& in) {
  const auto value = in.get<std::uint8_t>();
  if (value > 1) in.refuse();
  return value == 1;
}

SensorDescription get_sensor(ByteReader& in) {
  SensorDescription sensor;
  for (std::string* text : {&sensor.name, &sensor.serial, &sensor.model, &sensor.source})
    *text = in.get_text(kMaxNameBytes);
  DepthIntrinsics& to = sensor.intrinsics;
  to.width_px = in.get<std::int32_t>();
  to.height_px = in.get<std::int32_t>();
  for (double* number :
       {&to.fx_px, &to.fy_px, &to.cx_px, &to.cy_px, &to.k1, &to.k2, &to.k3, &to.p1, &to.p2}) {
    *number = in.get<double>();
    if (!std::isfinite(*number)) in.refuse();
  }
  sensor.tick_ns = in.get<std::int64_t>();
  sensor.nominal_rate_hz = in.get<double>();
  sensor.latency_ns = in.get<std::int64_t>();
  sensor.has_depth = get_flag(in);
  return sensor;
}

FrameStamp get_stamp(ByteReader& in) {
  FrameStamp stamp;
  stamp.sequence = in.get<std::int64_t>();
  stamp.device_ticks = in.get<std::int64_t>();
  stamp.arrival_ns = in.get<std::int64_t>();
  return stamp;
}

template <class Values>
void get_all(ByteReader& in, Values& values) {
  for (auto& value : values) value = in.get<std::remove_reference_t<decltype(value)>>();
}

Body get_body(ByteReader& in) {
  Body body;
  body.tracking_id = in.get<std::uint64_t>();
  for (auto& point : body.position_m) get_all(in, point);
  for (auto& turn : body.orientation_xyzw) get_all(in, turn);
  get_all(in, body.tracking_state);
  get_all(in, body.hand_state);
  get_all(in, body.hand_confidence);
  return body;
}

BodyFrame get_body_frame(ByteReader& in) {
  BodyFrame frame;
  frame.stamp = get_stamp(in);
  get_all(in, frame.floor_plane);
  const auto bodies = in.get<std::uint8_t>();
  if (bodies > kMaxBodies) in.refuse();
  for (int i = 0; i < bodies && !in.failed(); ++i) frame.bodies.push_back(get_body(in));
  return frame;
}

EncodedDepthFrame get_depth_frame(ByteReader& in) {
  EncodedDepthFrame frame;
  frame.stamp = get_stamp(in);
  const auto compression = in.get<std::uint8_t>();
  if (compression > static_cast<std::uint8_t>(ChunkCompression::deflate)) in.refuse();
  frame.compression = static_cast<ChunkCompression>(compression);
  const auto chunk = in.get_bytes(in.left());
  frame.chunk.assign(chunk.begin(), chunk.end());
  return frame;
}

EventMessage get_event(ByteReader& in, WireType type) {
  EventMessage event;
  event.number = in.get<std::uint64_t>();
  event.sensor = in.get<std::uint32_t>();
  if (type == WireType::body_frame) {
    event.data = get_body_frame(in);
  } else if (type == WireType::depth_frame) {
    event.data = get_depth_frame(in);
  } else if (type == WireType::notice) {
    event.data = SourceNotice{in.get_text(kMaxTextBytes)};
  } else {
    DropCount count;
    count.at_source = in.get<std::int64_t>();
    count.in_queue = in.get<std::int64_t>();
    if (count.at_source < 0 || count.in_queue < 0) in.refuse();
    event.data = count;
  }
  return event;
}

HelloMessage get_hello(ByteReader& in) {
  HelloMessage hello;
  const auto role = in.get<std::uint8_t>();
  if (role > static_cast<std::uint8_t>(LinkRole::clock)) in.refuse();
  hello.role = static_cast<LinkRole>(role);
  hello.agent = in.get_text(kMaxNameBytes);
  hello.incarnation = in.get<std::uint64_t>();
  hello.recording = in.get<std::uint64_t>();
  hello.simulated = get_flag(in);
  const auto sensors = in.get<std::uint8_t>();
  if (sensors > kMaxSessionSensors) in.refuse();
  for (int i = 0; i < sensors && !in.failed(); ++i) hello.sensors.push_back(get_sensor(in));
  return hello;
}

WelcomeMessage get_welcome(ByteReader& in) {
  WelcomeMessage welcome;
  welcome.recording = in.get<std::uint64_t>();
  welcome.next_number = in.get<std::uint64_t>();
  return welcome;
}

ClockPongMessage get_pong(ByteReader& in) {
  ClockPongMessage pong;
  pong.id = in.get<std::uint64_t>();
  pong.t2_ns = in.get<std::int64_t>();
  pong.t3_ns = in.get<std::int64_t>();
  return pong;
}

ByeMessage get_bye(ByteReader& in) {
  ByeMessage bye;
  bye.number = in.get<std::uint64_t>();
  bye.problem = in.get_text(kMaxTextBytes);
  return bye;
}

RefusalMessage get_refusal(ByteReader& in) {
  RefusalMessage refusal;
  refusal.try_again = get_flag(in);
  refusal.reason = in.get_text(kMaxTextBytes);
  return refusal;
}

Message get_message(ByteReader& in, WireType type) {
  switch (type) {
    case WireType::hello:
      return get_hello(in);
    case WireType::welcome:
      return get_welcome(in);
    case WireType::refusal:
      return get_refusal(in);
    case WireType::resume:
      return ResumeMessage{in.get<std::uint64_t>()};
    case WireType::body_frame:
    case WireType::depth_frame:
    case WireType::notice:
    case WireType::drop_count:
      return get_event(in, type);
    case WireType::ack:
      return AckMessage{in.get<std::uint64_t>()};
    case WireType::alive:
      return AliveMessage{};
    case WireType::clock_ping:
      return ClockPingMessage{in.get<std::uint64_t>()};
    case WireType::clock_pong:
      return get_pong(in);
    case WireType::bye:
      return get_bye(in);
  }
  in.refuse();
  return AliveMessage{};
}

}  // namespace

std::variant<Message, WireError> decode_message(std::span<const std::byte> body) {
  if (body.size() > kMaxMessageBytes) return WireError{"a message is too long"};
  ByteReader in(body);
  const auto type = static_cast<WireType>(in.get<std::uint8_t>());
  if (type == WireType::hello) {
    if (in.get<std::uint32_t>() != kWireMagic) return WireError{"does not speak trilat's protocol"};
    const auto version = in.get<std::uint16_t>();
    if (!in.failed() && version != kWireVersion)
      return WireError{"speaks version " + std::to_string(version) + " of the protocol, not " +
                       std::to_string(kWireVersion)};
  }
  Message message = get_message(in, type);
  if (in.failed() || in.left() != 0)
    return WireError{"a message of type " + std::to_string(static_cast<int>(type)) + " is damaged"};
  return message;
}

}  // namespace trilat
