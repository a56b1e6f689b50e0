// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "datasets/base/error.h"
#include "recorders/network/agent_connect.h"
#include "recorders/network/agent_link.h"
#include "recorders/network/link/tls_keys.h"
#include "recorders/network/network_source.h"
#include "tests/support/scratch.h"

namespace trilat {

inline constexpr std::chrono::milliseconds kGenerous{120000};

// Delivers events of one sensor, made one by one.
class MadeSource : public FrameSource {
 public:
  using Make = std::function<std::optional<SourceEvent>(std::size_t number)>;
  MadeSource(std::string name, Make make, bool live = false) : make_(std::move(make)), live_(live) {
    SensorDescription sensor;
    sensor.name = std::move(name);
    sensor.source = "made";
    sensor.has_depth = true;
    header_.sensors = {sensor};
  }
  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override { return stopped_ ? std::nullopt : make_(number_++); }
  void stop() override { stopped_ = true; }
  bool live() const override { return live_; }

 private:
  SessionHeader header_;
  Make make_;
  std::size_t number_ = 0;
  bool live_;
  std::atomic<bool> stopped_{false};
};

inline FrameStamp made_stamp(std::size_t number) {
  const auto n = static_cast<std::int64_t>(number);
  return {n, n * 333'333, 1'000'000'000 + n * 33'333'333};
}

inline BodyFrame made_bodies(std::size_t number) {
  BodyFrame frame{made_stamp(number), {0.0f, 1.0f, 0.0f, 1.2f}, {}};
  for (std::size_t b = 0; b < number % 4; ++b) {
    Body body;
    body.tracking_id = 72'057'594'037'927'937u + number;
    body.position_m[3] = {0.1f, 0.2f, 0.001f * static_cast<float>(number)};
    body.orientation_xyzw[5] = {0.5f, -0.5f, 0.5f, 0.5f};
    body.tracking_state[7] = 2;
    body.hand_state = {3, 4};
    frame.bodies.push_back(body);
  }
  return frame;
}

inline DepthFrame made_depth(std::size_t number) {
  DepthFrame frame{made_stamp(number), std::vector<std::uint16_t>(kDepthPixels)};
  for (std::size_t i = 0; i < kDepthPixels; ++i)
    frame.depth_mm[i] = static_cast<std::uint16_t>((i * 7 + number * 131) % 4500);
  return frame;
}

// Bodies, and every `depth_every`th time pixels or compressed depth.
inline SourceEvent made_event(std::size_t number, std::size_t depth_every) {
  if (number % depth_every != depth_every - 1) return {0, made_bodies(number)};
  DepthFrame depth = made_depth(number);
  if (number % 2) return {0, std::move(depth)};
  return {0, encode_depth_frame(depth.stamp, depth.depth_mm, ChunkCompression::blosc)};
}

inline MadeSource::Make made_events(std::size_t count, std::size_t depth_every = 8) {
  return [=](std::size_t number) -> std::optional<SourceEvent> {
    if (number == count) return std::nullopt;
    return made_event(number, depth_every);
  };
}

// Keys of a recording machine and of agents k1, k2, k3.
struct TestKeys {
  ScratchFolder folder;
  TestKeys() { make_tls_keys(folder / "keys", {"k1", "k2", "k3"}); }
  TlsKeys of(const std::string& file) const { return read_tls_keys(folder / "keys" / file); }
};

inline ListenOptions listen_options(const TestKeys& keys) {
  ListenOptions options;
  options.address = {"127.0.0.1", 0};
  options.keys = keys.of("recorder.keys");
  options.silence_limit = options.handshake_limit = kGenerous;
  return options;
}

inline AgentOptions agent_options(const std::string& name) {
  AgentOptions options;
  options.name = name;
  options.incarnation = 1;
  options.silence_limit = options.farewell_limit = kGenerous;
  options.first_retry = std::chrono::milliseconds(5);
  options.last_retry = std::chrono::milliseconds(20);
  return options;
}

// An agent that runs on a thread of its own until it ends.
class RunningAgent {
 public:
  RunningAgent(FrameSource& source, AgentOptions options, ConnectLink connect)
      : link_(source, std::move(options), std::move(connect)),
        report_(std::async(std::launch::async, [this] { return link_.run(); })) {}
  ~RunningAgent() {
    link_.stop();
    if (report_.valid()) report_.wait();
  }
  AgentReport report() { return report_.get(); }
  AgentLink& link() { return link_; }

 private:
  AgentLink link_;
  std::future<AgentReport> report_;
};

inline ConnectLink connect_as(const TestKeys& keys, const std::string& name, std::uint16_t port) {
  return connect_to_server({"127.0.0.1", port}, keys.of(name + ".key"), false);
}

struct Received {
  std::vector<SourceEvent> frames;  // bodies and depth
  std::vector<SourceEvent> exchanges;
  std::vector<DropCount> drops;
  std::vector<std::string> notices;
};

inline void put(Received& received, SourceEvent event) {
  if (const auto* drop = std::get_if<DropCount>(&event.data))
    received.drops.push_back(*drop);
  else if (const auto* notice = std::get_if<SourceNotice>(&event.data))
    received.notices.push_back(notice->text);
  else if (std::holds_alternative<ClockExchange>(event.data))
    received.exchanges.push_back(std::move(event));
  else
    received.frames.push_back(std::move(event));
}

inline Received receive_all(FrameSource& source) {
  Received received;
  while (auto event = source.next()) put(received, std::move(*event));
  return received;
}

inline std::vector<std::uint16_t> pixels_of(const SourceEvent& event) {
  if (const auto* pixels = std::get_if<DepthFrame>(&event.data)) return pixels->depth_mm;
  const auto& depth = std::get<EncodedDepthFrame>(event.data);
  std::vector<std::uint16_t> pixels(kDepthPixels);
  TRILAT_CHECK(decode_chunk(depth.chunk, depth.compression, std::as_writable_bytes(std::span(pixels))),
               "a depth frame that arrived can be read");
  return pixels;
}

inline const FrameStamp& stamp_of(const SourceEvent& event) {
  if (const auto* pixels = std::get_if<DepthFrame>(&event.data)) return pixels->stamp;
  if (const auto* depth = std::get_if<EncodedDepthFrame>(&event.data)) return depth->stamp;
  return std::get<BodyFrame>(event.data).stamp;
}

inline bool same_stamp(const FrameStamp& a, const FrameStamp& b) {
  return a.sequence == b.sequence && a.device_ticks == b.device_ticks && a.arrival_ns == b.arrival_ns;
}

inline bool same_body(const Body& a, const Body& b) {
  return a.tracking_id == b.tracking_id && a.position_m == b.position_m &&
         a.orientation_xyzw == b.orientation_xyzw && a.tracking_state == b.tracking_state &&
         a.hand_state == b.hand_state && a.hand_confidence == b.hand_confidence;
}

// The same bodies or the same pixels, whether compressed or not.
inline bool same_frame(const SourceEvent& a, const SourceEvent& b) {
  if (!same_stamp(stamp_of(a), stamp_of(b))) return false;
  const auto* first = std::get_if<BodyFrame>(&a.data);
  const auto* second = std::get_if<BodyFrame>(&b.data);
  if (!first != !second) return false;
  if (!first) return pixels_of(a) == pixels_of(b);
  return first->floor_plane == second->floor_plane &&
         std::ranges::equal(first->bodies, second->bodies, same_body);
}

}  // namespace trilat
