// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
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

// "1 take", "3 takes".
std::string counted(std::size_t count, std::string_view noun);

// "a, b, c".
std::string join_names(const std::vector<std::string>& names);

// The first text that an earlier one equals; empty when all differ.
std::string first_duplicate(const std::vector<std::string>& texts);

// The known name that is nearest to a word that was mistyped, by letters put in, left out, changed or
// exchanged (Damerau 1964); empty when none is near.
std::string nearest_name(std::string_view word, const std::vector<std::string>& known);

// For the end of a refusal: "allowed: head, neck; did you mean \"neck\"?".
std::string known_names(std::string_view word, const std::vector<std::string>& known);

}  // namespace trilat
