// SPDX-License-Identifier: MIT
#include "datasets/base/words.h"

#include <algorithm>
#include <cctype>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace trilat {
namespace {

// Letters of either case are the same.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  const auto same = [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  };
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + !same(a[i - 1], b[j - 1])});
      if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]))
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

// The parts between underscores in the order of the alphabet: left_wrist is nearly wrist_left.
std::string sorted_parts(std::string_view word) {
  std::vector<std::string> parts(1);
  for (const char c : word)
    if (c == '_')
      parts.emplace_back();
    else
      parts.back() += c;
  std::ranges::sort(parts);
  return fmt::format("{}", fmt::join(parts, "_"));
}

}  // namespace

std::string counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string join_names(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string first_duplicate(const std::vector<std::string>& texts) {
  std::set<std::string> seen;
  for (const std::string& text : texts)
    if (!seen.insert(text).second) return text;
  return {};
}

std::string nearest_name(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::size_t kMaxWordLength = 100;
  if (word.size() > kMaxWordLength) return {};
  std::string nearest;
  std::size_t least = 1 + std::max<std::size_t>(1, word.size() / 3);
  for (const std::string& name : known)
    if (const std::size_t off =
            std::min(distance(word, name), 1 + distance(sorted_parts(word), sorted_parts(name)));
        off < least) {
      least = off;
      nearest = name;
    }
  return nearest;
}

std::string known_names(std::string_view word, const std::vector<std::string>& known) {
  const std::string nearest = nearest_name(word, known);
  return "allowed: " + join_names(known) + (nearest.empty() ? "" : "; did you mean \"" + nearest + "\"?");
}

}  // namespace trilat
