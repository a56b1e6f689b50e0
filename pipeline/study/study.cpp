// SPDX-License-Identifier: MIT
#include "pipeline/study/study.h"

#include <algorithm>
#include <charconv>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/version.h"

namespace trilat {
namespace {

// Reads digits up to `end`; 0 when there is anything else.
std::uint64_t count_in(const char* begin, const char* end) {
  std::uint64_t value = 0;
  const auto [stop, error] = std::from_chars(begin, end, value);
  return error == std::errc{} && stop == end ? value : 0;
}

}  // namespace

Shard parse_shard(const std::string& text, const std::string& place) {
  const std::size_t slash = text.find('/');
  Shard shard{0, 0};
  if (slash != std::string::npos) {
    shard.number = count_in(text.data(), text.data() + slash);
    shard.of = count_in(text.data() + slash + 1, text.data() + text.size());
  }
  if (shard.number == 0 || shard.number > shard.of || shard.of > kMaxShards)
    throw InputError(place, "is \"" + text + "\"; it must be k/n, shard k of n, 1/n to n/n, n at most " +
                                std::to_string(kMaxShards));
  return shard;
}

std::string name_of(const Shard& shard) {
  return std::to_string(shard.number) + '/' + std::to_string(shard.of);
}

std::vector<std::uint64_t> shards_of(std::span<const double> costs, std::uint64_t shards) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return costs[a] > costs[b]; });
  using Load = std::pair<double, std::uint64_t>;  // cost, shard
  std::priority_queue<Load, std::vector<Load>, std::greater<>> lightest;
  for (std::uint64_t s = 1; s <= std::max<std::uint64_t>(1, shards); ++s) lightest.emplace(0.0, s);
  std::vector<std::uint64_t> result(costs.size());
  for (const std::size_t item : order) {
    const auto [cost, shard] = lightest.top();
    lightest.pop();
    result[item] = shard;
    lightest.emplace(cost + costs[item], shard);
  }
  return result;
}

RunControl control_of(const StudyOptions& options, const std::string& stage) {
  RunControl control{options.stop_requested, {}};
  if (options.progress)
    control.progress = [&options, stage](double share) { options.progress(stage, share); };
  return control;
}

std::string key_of(const Json& settings) {
  return hash_of_text(json_text(Json{{"build", build_id()}, {"settings", settings}}, -1));
}

Json manifest_of(const Json& resolved, const Json& more) {
  Json manifest{{"study", resolved}, {"study_sha256", hash_of_text(resolved.dump())}};
  manifest.update(more);
  return manifest;
}

}  // namespace trilat
