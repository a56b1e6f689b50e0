// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "datasets/markers/c3d_parameters.h"

namespace trilat {

// A C3D file laid out by hand, by the guide of c3d.org: the header in block 1, parameters from block 2 on,
// and the points behind them.
struct MadeUpC3d {
  C3dProcessor processor = C3dProcessor::intel;
  float scale = -1.0f;  // positive: integers
  std::string units = "mm";
  std::vector<std::string> labels{"a", "b"};
  std::size_t points = 2;
  std::uint16_t analog = 0;                              // samples a frame
  std::uint16_t first = 1, last = 2;                     // of the header
  std::vector<std::uint16_t> long_first{}, long_last{};  // of TRIAL, low word first
  std::vector<std::vector<float>> frames{{1500, 250, -100, 0, 4, 5, 6, 0}, {1501, 250, -100, 0, 9, 9, 9, -1}};

  std::string text() const {
    std::string parameters = start_of_parameters();
    parameters.resize((parameters.size() + 511) / 512 * 512);
    parameters[2] = static_cast<char>(parameters.size() / 512);
    const auto data_block = static_cast<std::uint16_t>(2 + parameters.size() / 512);
    std::string header{2, 0x50};
    for (const std::uint16_t word :
         {static_cast<std::uint16_t>(points), analog, first, last, std::uint16_t{0}})
      header += integer(word);
    header += real(scale) + integer(data_block) + integer(0) + real(100.0f);
    header.resize(512);
    std::string data;
    for (const auto& frame : frames) {
      for (const float number : frame)
        data +=
            scale < 0 ? real(number) : integer(static_cast<std::uint16_t>(static_cast<std::int16_t>(number)));
      for (int i = 0; i < analog; ++i) data += scale < 0 ? real(7777.0f) : integer(7777);
    }
    return header + parameters + data;
  }

 private:
  std::string integer(std::uint16_t value) const {
    const char low = static_cast<char>(value & 0xff), high = static_cast<char>(value >> 8);
    return processor == C3dProcessor::mips ? std::string{high, low} : std::string{low, high};
  }
  std::string real(float value) const {
    const auto bits = std::bit_cast<std::uint32_t>(processor == C3dProcessor::dec ? 4.0f * value : value);
    const auto byte = [bits](int i) { return static_cast<char>(bits >> (8 * i) & 0xff); };
    if (processor == C3dProcessor::mips) return {byte(3), byte(2), byte(1), byte(0)};
    if (processor == C3dProcessor::dec) return {byte(2), byte(3), byte(0), byte(1)};
    return {byte(0), byte(1), byte(2), byte(3)};
  }
  // `id` is negative for a group. `content` is a type, dimensions and data; a description without text ends
  // it.
  std::string entry(int id, const std::string& name, const std::string& content) const {
    const std::string body = content + '\0';
    return std::string{static_cast<char>(name.size()), static_cast<char>(id)} + name +
           integer(static_cast<std::uint16_t>(2 + body.size())) + body;
  }
  std::string text_entry(const std::string& name, const std::vector<std::string>& texts) const {
    std::string content{-1, 2, 8, static_cast<char>(texts.size())};
    for (std::string padded : texts) {
      padded.resize(8, ' ');
      content += padded;
    }
    return entry(1, name, content);
  }
  std::string words(const std::string& name, const std::vector<std::uint16_t>& values) const {
    std::string content{2, 1, static_cast<char>(values.size())};
    for (const std::uint16_t value : values) content += integer(value);
    return entry(2, name, content);
  }
  std::string start_of_parameters() const {
    std::string result{1, 0x50, 0, static_cast<char>(processor)};
    // A parameter may stand before its group, and its name may be in any case.
    result += text_entry("Units", {units}) + entry(-1, "POINT", "") + entry(-2, "TRIAL", "");
    const std::size_t own = std::min<std::size_t>(labels.size(), 255);
    result += text_entry("LABELS", {labels.begin(), labels.begin() + static_cast<std::ptrdiff_t>(own)});
    if (own < labels.size())
      result += text_entry("LABELS2", {labels.begin() + static_cast<std::ptrdiff_t>(own), labels.end()});
    if (!long_first.empty()) result += words("ACTUAL_START_FIELD", long_first);
    if (!long_last.empty()) result += words("ACTUAL_END_FIELD", long_last);
    return result + std::string(2, '\0');
  }
};

}  // namespace trilat
