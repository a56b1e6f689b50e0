// SPDX-License-Identifier: MIT
#include "datasets/base/error.h"
#include "recorders/network/link/wire.h"
#include "recorders/network/link/wire_bytes.h"

namespace trilat {
namespace {

void put_sensor(ByteWriter& out, const SensorDescription& sensor) {
  for (const std::string* text : {&sensor.name, &sensor.serial, &sensor.model, &sensor.source})
    out.put_text(*text, kMaxNameBytes);
  const DepthIntrinsics& in = sensor.intrinsics;
  out.put(static_cast<std::int32_t>(in.width_px));
  out.put(static_cast<std::int32_t>(in.height_px));
  for (const double number : {in.fx_px, in.fy_px, in.cx_px, in.cy_px, in.k1, in.k2, in.k3, in.p1, in.p2})
    out.put(number);
  out.put(sensor.tick_ns);
  out.put(sensor.nominal_rate_hz);
  out.put(sensor.latency_ns);
  out.put(static_cast<std::uint8_t>(sensor.has_depth));
}

void put_stamp(ByteWriter& out, const FrameStamp& stamp) {
  out.put(stamp.sequence);
  out.put(stamp.device_ticks);
  out.put(stamp.arrival_ns);
}

template <class Values>
void put_all(ByteWriter& out, const Values& values) {
  for (const auto& value : values) out.put(value);
}

void put_body(ByteWriter& out, const Body& body) {
  out.put(body.tracking_id);
  for (const auto& point : body.position_m) put_all(out, point);
  for (const auto& turn : body.orientation_xyzw) put_all(out, turn);
  put_all(out, body.tracking_state);
  put_all(out, body.hand_state);
  put_all(out, body.hand_confidence);
}

struct PutEvent {
  ByteWriter& out;
  const EventMessage& event;

  void begin(WireType type) {
    out.put(type);
    out.put(event.number);
    out.put(event.sensor);
  }
  void operator()(const BodyFrame& frame) {
    TRILAT_CHECK(frame.bodies.size() <= kMaxBodies, "a body frame has at most six bodies");
    begin(WireType::body_frame);
    put_stamp(out, frame.stamp);
    put_all(out, frame.floor_plane);
    out.put(static_cast<std::uint8_t>(frame.bodies.size()));
    for (const Body& body : frame.bodies) put_body(out, body);
  }
  void operator()(const EncodedDepthFrame& frame) {
    begin(WireType::depth_frame);
    put_stamp(out, frame.stamp);
    out.put(static_cast<std::uint8_t>(frame.compression));
    out.put_bytes(frame.chunk);
  }
  void operator()(const SourceNotice& notice) {
    begin(WireType::notice);
    out.put_text(notice.text, kMaxTextBytes);
  }
  void operator()(const DropCount& count) {
    begin(WireType::drop_count);
    out.put(count.at_source);
    out.put(count.in_queue);
  }
};

struct PutMessage {
  ByteWriter& out;

  void operator()(const HelloMessage& hello) {
    TRILAT_CHECK(hello.sensors.size() <= kMaxSessionSensors, "an agent has at most 64 sensors");
    out.put(WireType::hello);
    out.put(kWireMagic);
    out.put(kWireVersion);
    out.put(hello.role);
    out.put_text(hello.agent, kMaxNameBytes);
    out.put(hello.incarnation);
    out.put(hello.recording);
    out.put(static_cast<std::uint8_t>(hello.simulated));
    out.put(static_cast<std::uint8_t>(hello.sensors.size()));
    for (const SensorDescription& sensor : hello.sensors) put_sensor(out, sensor);
  }
  void operator()(const WelcomeMessage& welcome) {
    put_number(WireType::welcome, welcome.recording);
    out.put(welcome.next_number);
  }
  void operator()(const RefusalMessage& refusal) {
    out.put(WireType::refusal);
    out.put(static_cast<std::uint8_t>(refusal.try_again));
    out.put_text(refusal.reason, kMaxTextBytes);
  }
  void operator()(const ResumeMessage& resume) { put_number(WireType::resume, resume.lost_frames); }
  void operator()(const EventMessage& event) { std::visit(PutEvent{out, event}, event.data); }
  void operator()(const AckMessage& ack) { put_number(WireType::ack, ack.next_number); }
  void operator()(const AliveMessage&) { out.put(WireType::alive); }
  void operator()(const ClockPingMessage& ping) { put_number(WireType::clock_ping, ping.id); }
  void operator()(const ClockPongMessage& pong) {
    put_number(WireType::clock_pong, pong.id);
    out.put(pong.t2_ns);
    out.put(pong.t3_ns);
  }
  void operator()(const ByeMessage& bye) {
    put_number(WireType::bye, bye.number);
    out.put_text(bye.problem, kMaxTextBytes);
  }

  void put_number(WireType type, std::uint64_t number) {
    out.put(type);
    out.put(number);
  }
};

}  // namespace

std::vector<std::byte> encode_message(const Message& message) {
  ByteWriter out;
  out.put(std::uint32_t{0});
  std::visit(PutMessage{out}, message);
  std::vector<std::byte> bytes = out.take();
  const std::size_t length = bytes.size() - kLengthBytes;
  TRILAT_CHECK(length <= kMaxMessageBytes, "a message of ours fits the limit");
  for (std::size_t i = 0; i < kLengthBytes; ++i) bytes[i] = static_cast<std::byte>(length >> (8 * i));
  return bytes;
}

}  // namespace trilat
