// SPDX-License-Identifier: MIT
#include "pipeline/cli/run_words.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace trilat {
namespace {

std::string some_of(const std::vector<std::string>& ids) {
  constexpr std::size_t kMaxNamed = 8;
  const std::size_t named = std::min(ids.size(), kMaxNamed);
  std::string text =
      fmt::format("{}", fmt::join(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(named), ", "));
  if (ids.size() > named) text += fmt::format(" and {} more", ids.size() - named);
  return text;
}

}  // namespace

Json tally_json(const ItemCounts& tally) {
  return {{"items", tally.all()},
          {"items_computed", tally.computed.size()},
          {"items_found", tally.found.size()},
          {"items_failed", tally.failed.size()},
          {"unchanged", tally.unchanged}};
}

void print_item_counts(const std::string& items, const ItemCounts& tally) {
  if (tally.unchanged) {
    fmt::print(stderr, "nothing changed: the results are there already\n");
    return;
  }
  for (const std::string& damage : tally.damaged)
    fmt::print(stderr, "computed again, because what was there is damaged: {}\n", damage);
  if (!tally.found.empty())
    fmt::print(stderr, "{} {} did not change and were there: {}\n", tally.found.size(), items,
               some_of(tally.found));
  if (!tally.computed.empty() && !tally.found.empty())
    fmt::print(stderr, "{} {} were computed: {}\n", tally.computed.size(), items, some_of(tally.computed));
}

void tell_interrupted(const std::filesystem::path& folder) {
  fmt::print(
      stderr,
      "trilat: interrupted; what was finished has been kept in {}, and the same command goes on from there\n",
      folder.string());
}

}  // namespace trilat
