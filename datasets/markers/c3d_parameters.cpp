// SPDX-License-Identifier: MIT
#include "datasets/markers/c3d_parameters.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::size_t kMostBlocks = 255;

std::string upper(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) {
    const char c = static_cast<char>(byte);
    text += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  }
  return text;
}

std::size_t small(std::byte byte) { return std::to_integer<std::size_t>(byte); }

// An entry of the section: a group, whose id is negative, or a parameter of the group with that id.
struct Entry {
  int group = 0;
  std::string name;
  std::span<const std::byte> content;
};

}  // namespace

std::int16_t c3d_integer(std::span<const std::byte> bytes, std::size_t offset, C3dProcessor processor) {
  auto bits = value_at<std::uint16_t>(bytes, offset);
  if (processor == C3dProcessor::mips) bits = static_cast<std::uint16_t>(bits << 8 | bits >> 8);
  return std::bit_cast<std::int16_t>(bits);
}

float c3d_real(std::span<const std::byte> bytes, std::size_t offset, C3dProcessor processor) {
  const auto high_first = [&](std::array<std::size_t, 4> order) {
    std::uint32_t bits = 0;
    for (const std::size_t i : order) bits = bits << 8 | std::to_integer<std::uint32_t>(bytes[offset + i]);
    return std::bit_cast<float>(bits);
  };
  if (processor == C3dProcessor::intel) return high_first({3, 2, 1, 0});
  if (processor == C3dProcessor::mips) return high_first({0, 1, 2, 3});
  // The exponent of a VAX counts from 129, and its mantissa's first bit is a half.
  return high_first({1, 0, 3, 2}) / 4.0f;
}

C3dParameters::C3dParameters(const ByteFile& file, std::size_t first_block) {
  const std::uint64_t start = kC3dBlock * (std::max<std::size_t>(first_block, 1) - 1);
  std::array<std::byte, 4> head;
  if (!file.read(start, head)) throw InputError(file.place(start), "the file ends before its parameters");
  const std::size_t code = small(head[3]);
  if (code < 84 || code > 86)
    throw InputError(file.place(start + 3), "has the processor " + std::to_string(code) +
                                                "; known are 84 (Intel), 85 (DEC) and 86 (MIPS)");
  processor_ = static_cast<C3dProcessor>(code);
  // Some programs leave the number of blocks at zero.
  const std::size_t blocks = head[2] == std::byte{0} ? kMostBlocks : small(head[2]);
  std::vector<std::byte> section(std::min<std::uint64_t>(kC3dBlock * blocks, file.size() - start));
  file.read(start, section);
  read(std::span(section).subspan(head.size()));
}

void C3dParameters::read(std::span<const std::byte> section) {
  std::map<int, std::string> groups;
  std::vector<Entry> entries;
  while (section.size() >= 2) {
    // A negative length is a name that is locked.
    const auto length =
        static_cast<std::size_t>(std::abs(static_cast<int>(static_cast<signed char>(section[0]))));
    const int group = static_cast<signed char>(section[1]);
    if (length == 0 || section.size() < length + 4) break;
    const std::string name = upper(section.subspan(2, length));
    section = section.subspan(2 + length);
    const std::size_t next = static_cast<std::uint16_t>(c3d_integer(section, 0, processor_));
    const std::size_t size = next < 2 ? section.size() : std::min(next, section.size());
    if (group < 0)
      groups.emplace(-group, name);
    else
      entries.push_back({group, name, section.subspan(2, size - 2)});
    if (next < 2) break;
    section = section.subspan(size);
  }
  for (const Entry& entry : entries) {
    if (entry.content.size() < 2) continue;
    const std::size_t dimensions = small(entry.content[1]);
    Parameter parameter{.bytes = static_cast<signed char>(entry.content[0]), .shape = {}, .data = {}};
    auto rest = entry.content.subspan(2);
    if (rest.size() < dimensions) continue;
    std::size_t bytes = static_cast<std::size_t>(std::abs(parameter.bytes));
    for (std::size_t d = 0; d < dimensions; ++d) {
      parameter.shape.push_back(small(rest[d]));
      bytes = std::min(bytes * parameter.shape.back(), rest.size());
    }
    rest = rest.subspan(dimensions);
    rest = rest.first(std::min(bytes, rest.size()));
    parameter.data.assign(rest.begin(), rest.end());
    parameters_.emplace(groups[entry.group] + ":" + entry.name, std::move(parameter));
  }
}

std::optional<double> C3dParameters::number(std::string_view name, std::size_t i) const {
  const auto found = parameters_.find(name);
  if (found == parameters_.end() || found->second.bytes <= 0) return {};
  const Parameter& parameter = found->second;
  const auto bytes = static_cast<std::size_t>(parameter.bytes);
  if (parameter.data.size() < bytes * (i + 1)) return {};
  if (bytes == 1) return static_cast<double>(small(parameter.data[i]));
  if (bytes == 2) return static_cast<std::uint16_t>(c3d_integer(parameter.data, 2 * i, processor_));
  if (bytes == 4) return static_cast<double>(c3d_real(parameter.data, 4 * i, processor_));
  return {};
}

std::vector<std::string> C3dParameters::texts(std::string_view name) const {
  const auto found = parameters_.find(name);
  if (found == parameters_.end() || found->second.bytes != -1) return {};
  const auto& [unused, shape, data] = found->second;
  const std::size_t length = shape.empty() ? 1 : shape[0];
  std::vector<std::string> texts;
  for (std::size_t begin = 0; length > 0 && begin + length <= data.size(); begin += length) {
    std::string text(reinterpret_cast<const char*>(data.data()) + begin, length);
    text.erase(text.find_last_not_of(std::string_view(" \0", 2)) + 1);
    texts.push_back(std::move(text));
  }
  return texts;
}

}  // namespace trilat
