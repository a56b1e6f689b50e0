// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace trilat {

using FuzzInput = std::span<const std::uint8_t>;

// One reader of what comes from outside. What it throws is a finding, except InputError.
struct Fuzzer {
  std::string_view name;
  void (*read)(FuzzInput);
};

// All there are; seeds of each lie in the folder of its name.
std::span<const Fuzzer> fuzzers();

// The fuzzer of this name reads the input; an unknown name ends the process.
void fuzz(std::string_view name, FuzzInput input);

}  // namespace trilat
