// SPDX-License-Identifier: MIT
#include "reports/statuses_text.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace trilat {

std::string statuses_text(const std::map<std::string, std::uint64_t>& statuses, std::uint64_t asked) {
  std::vector<std::pair<std::string, std::uint64_t>> sorted(statuses.begin(), statuses.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (const auto& [name, n] : sorted) {
    const double share = 100.0 * static_cast<double>(n) / static_cast<double>(asked);
    const std::string number = share < 0.05                 ? "<0.1"
                               : share > 99.95 && n < asked ? ">99.9"
                                                            : fmt::format("{:.1f}", share);
    text += (text.empty() ? "" : ", ") + name + " " + number + " %";
  }
  return text;
}

}  // namespace trilat
