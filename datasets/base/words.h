// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace trilat {

// Names of an enum's values as documents have them, in the order of the values; specialised beside the enum.
template <class Enum>
inline constexpr std::array<const char*, 0> words{};

template <class Enum>
std::vector<std::string> words_of() {
  return {words<Enum>.begin(), words<Enum>.end()};
}
template <class Enum>
std::string word_of(Enum value) {
  return words<Enum>.at(static_cast<std::size_t>(value));
}

}  // namespace trilat
