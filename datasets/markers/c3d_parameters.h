// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/base/byte_file.h"

namespace trilat {

// Whose numbers a C3D file holds, by the code in the file.
enum class C3dProcessor : std::uint8_t { intel = 84, dec = 85, mips = 86 };

// A number at a place of bytes; the caller knows that they are there.
std::int16_t c3d_integer(std::span<const std::byte> bytes, std::size_t offset, C3dProcessor processor);
float c3d_real(std::span<const std::byte> bytes, std::size_t offset, C3dProcessor processor);

inline constexpr std::size_t kC3dBlock = 512;

// The parameter section of a C3D file (c3d.org, "The C3D file format user guide").
class C3dParameters {
 public:
  // `first_block` counts from 1. InputError when there is no such section.
  C3dParameters(const ByteFile& file, std::size_t first_block);

  C3dProcessor processor() const { return processor_; }
  // Element `i` of a parameter such as "POINT:RATE"; integers are without sign. Nothing when it is not there.
  std::optional<double> number(std::string_view name, std::size_t i = 0) const;
  // The texts of a parameter without the blanks behind; empty when it is not there.
  std::vector<std::string> texts(std::string_view name) const;

 private:
  struct Parameter {
    int bytes = 0;  // an element's: -1 a letter, 1 and 2 an integer, 4 a real number
    std::vector<std::size_t> shape;
    std::vector<std::byte> data;
  };
  void read(std::span<const std::byte> section);

  C3dProcessor processor_ = C3dProcessor::intel;
  std::map<std::string, Parameter, std::less<>> parameters_;
};

}  // namespace trilat
