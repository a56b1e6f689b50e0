// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "datasets/base/error.h"
#include "datasets/session/session_types.h"

// Sensors and their events as bytes, for event logs and for what agents and the recorder say to each other.
namespace trilat {

inline constexpr std::size_t kMaxNameBytes = 64;
inline constexpr std::size_t kMaxTextBytes = 1024;

// Numbers as little-endian bytes, behind one another.
class ByteWriter {
 public:
  template <class T>
  void put(T value) {
    if constexpr (std::is_same_v<T, float>) {
      put(std::bit_cast<std::uint32_t>(value));
    } else if constexpr (std::is_same_v<T, double>) {
      put(std::bit_cast<std::uint64_t>(value));
    } else {
      const auto bits = static_cast<std::uint64_t>(value);
      for (std::size_t i = 0; i < sizeof(T); ++i) bytes_.push_back(static_cast<std::byte>(bits >> (8 * i)));
    }
  }
  void put_text(const std::string& text, std::size_t limit) {
    const std::size_t size = std::min(text.size(), limit);
    put(static_cast<std::uint16_t>(size));
    for (const char c : text.substr(0, size)) put(is_control(c) ? ' ' : c);
  }
  void put_bytes(std::span<const std::byte> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

  static bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

 private:
  std::vector<std::byte> bytes_;
};

// Reads what ByteWriter wrote. Past the end, or after refuse(), everything is zero and failed() is true.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  T get() {
    if constexpr (std::is_same_v<T, float>) {
      return std::bit_cast<float>(get<std::uint32_t>());
    } else if constexpr (std::is_same_v<T, double>) {
      return std::bit_cast<double>(get<std::uint64_t>());
    } else {
      std::uint64_t bits = 0;
      const auto bytes = get_bytes(sizeof(T));
      for (std::size_t i = 0; i < bytes.size(); ++i)
        bits |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
      return static_cast<T>(bits);
    }
  }
  std::span<const std::byte> get_bytes(std::size_t count) {
    if (failed_ || count > rest_.size()) {
      refuse();
      return {};
    }
    const auto bytes = rest_.first(count);
    rest_ = rest_.subspan(count);
    return bytes;
  }
  std::string get_text(std::size_t limit) {
    const std::size_t size = get<std::uint16_t>();
    if (size > limit) refuse();
    std::string text;
    for (const std::byte byte : get_bytes(size)) text.push_back(static_cast<char>(byte));
    if (std::ranges::any_of(text, ByteWriter::is_control)) refuse();
    return text;
  }
  std::size_t left() const { return rest_.size(); }
  void refuse() {
    failed_ = true;
    rest_ = {};
  }
  bool failed() const { return failed_; }

 private:
  std::span<const std::byte> rest_;
  bool failed_ = false;
};

// A structure passes its fields, in the order of their bytes, to one of these: Put writes their values, Get
// reads into them.
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
    TRILAT_CHECK(list.size() <= most, "lists of ours keep their limits");
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

}  // namespace trilat
