// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include <zlib.h>

#include "datasets/import/xef_layout.h"

namespace trilat {

inline constexpr const char* kXefDepth = "d614390a163be111aac3001e4fd58c0f";
inline constexpr const char* kXefInfrared = "d714390a163be111aac3001e4fd58c0f";
inline constexpr const char* kXefBodies = "7951c4a068517548a75cf8f1760f637c";
inline constexpr const char* kXefRawInfrared = "e214390a163be111aac3001e4fd58c0f";

// Writes .xef files, plain or archived, as far as the layout is known.
class MadeUpXef {
 public:
  explicit MadeUpXef(int streams, bool archived = false) : archived_(archived) {
    bytes_.append("EVENTS1\0", 8);
    put<std::uint32_t>(5);
    put<std::int32_t>(archived ? 0 : streams + 1);
    put<std::int64_t>(0);
    describe(0, "00000000000000000000000000000000", 24);
    footer_ = static_cast<std::uint16_t>(streams + 1);
  }

  void describe(std::uint16_t stream, const std::string& guid, std::uint16_t tag_bytes = 4) {
    std::string tag(24, '\0'), data(292, '\0');
    write(tag, 0, stream);
    for (std::size_t i = 0; i < 16; ++i)
      tag[4 + i] = static_cast<char>(std::stoi(guid.substr(2 * i, 2), nullptr, 16));
    write(data, 258, tag_bytes);
    header(stream, 0, 292, 0, 292);
    bytes_ += tag + data;
    if (archived_) bytes_.append(8, '\0');
    header(0, 0, 98, 0, 98);
    bytes_.append(24 + 98, '\0');
  }

  void event(std::uint16_t stream, std::int64_t ticks, std::uint32_t number, const std::string& data) {
    const std::string stored = archived_ ? deflated(data) : data;
    header(stream, archived_, static_cast<std::uint32_t>(stored.size()), ticks,
           static_cast<std::uint32_t>(data.size()));
    put(number);
    bytes_ += stored;
  }

  void index_block(std::size_t size) {
    header(0xFFFF, 0, 0, 0, 0);
    bytes_.append(size, '\xEE');
  }
  void footer() {
    header(footer_, 0, 0, 0, 0);
    bytes_.append(0x6B0 - 24, '\0');
  }
  std::string& bytes() { return bytes_; }

  template <class T>
  static void write(std::string& text, std::size_t at, T value) {
    std::memcpy(text.data() + at, &value, sizeof value);
  }

 private:
  template <class T>
  void put(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void header(std::uint16_t stream, bool compressed, std::uint32_t stored, std::int64_t ticks,
              std::uint32_t full) {
    put(stream);
    put<std::uint16_t>(compressed);
    put(stored);
    put(ticks);
    put<std::uint32_t>(0);
    put(full);
  }
  static std::string deflated(const std::string& data) {
    uLongf size = compressBound(data.size());
    std::string result(size, '\0');
    compress(reinterpret_cast<Bytef*>(result.data()), &size, reinterpret_cast<const Bytef*>(data.data()),
             data.size());
    result.resize(size);
    return result;
  }

  std::string bytes_;
  bool archived_;
  std::uint16_t footer_ = 0;
};

// Every pixel says its frame and its place.
inline std::string made_up_depth(int frame) {
  std::string data(xef::kDepthBytes, '\0');
  for (std::size_t i = 0; i < kDepthPixels; ++i)
    MadeUpXef::write(data, 2 * i, static_cast<std::uint16_t>(500 + 100 * frame + i % 512));
  return data;
}

// A body in slot 3, with the left hand closed and the right one open.
inline std::string made_up_bodies(int frame, std::uint64_t id) {
  std::string data(xef::kBodyFrameBytes, '\0');
  MadeUpXef::write(data, 4, 1.0f);
  const std::size_t body = 32 + 1040 * 3;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    MadeUpXef::write(data, body + 16 * j, 0.01f * static_cast<float>(frame));
    MadeUpXef::write(data, body + 16 * j + 8, 2.0f + 0.01f * static_cast<float>(j));
    MadeUpXef::write(data, body + 400 + 16 * j + 12, 1.0f);
    MadeUpXef::write(data, body + 800 + 4 * j, std::int32_t{1});
  }
  MadeUpXef::write(data, body + 980, std::int32_t{1});
  MadeUpXef::write(data, body + 984, std::int32_t{2});
  MadeUpXef::write(data, body + 988, std::int32_t{1});
  MadeUpXef::write(data, body + 996, std::int32_t{2});
  MadeUpXef::write(data, body + 1008, id);
  MadeUpXef::write(data, body + 1016, std::int32_t{1});
  return data;
}

}  // namespace trilat
