// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace trilat {

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

// First in every hello, so that a stranger is recognised whatever it speaks.
inline constexpr std::uint32_t kWireMagic = 0x4c495254;  // "TRIL"

}  // namespace trilat
