// SPDX-License-Identifier: MIT
#include "pipeline/gate/judge_numbers.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/gate/number_meaning.h"

namespace trilat {
namespace {

constexpr std::size_t kLongList = 100;       // from here on a list holds samples
constexpr const char* kCounts = "statuses";  // and histograms: what they add up to is judged

struct Leaf {
  std::string place;    // pointer, with what the entries of lists are called
  std::string pattern;  // without their numbers: what its fellows share
  std::string key;
  Json now, before;
};

// What tells an entry of a list from its neighbours: its texts.
std::string name_of_entry(const Json& entry, std::size_t index) {
  std::string name;
  if (entry.is_object())
    for (const auto& [key, value] : entry.items())
      if (value.is_string()) name += (name.empty() ? "" : ", ") + value.get<std::string>();
  return name.empty() ? fmt::format("{}", index) : fmt::format("{} [{}]", index, name);
}

std::string key_below(const Leaf& here, const std::string& key) {
  return here.key == kCounts || key == kCounts || key == "bins" ? std::string(kCounts) : key;
}

void collect(const Json& now, const Json& before, const Leaf& here, std::vector<Leaf>& leaves) {
  const bool lists = now.is_array() && before.is_array() && now.size() == before.size();
  const bool objects = now.is_object() && before.is_object();
  if (objects) {
    for (const auto& [key, value] : now.items())
      collect(value, before.contains(key) ? before.at(key) : Json(),
              {here.place + "/" + key, here.pattern + "/" + key, key_below(here, key), {}, {}}, leaves);
    for (const auto& [key, value] : before.items())
      if (!now.contains(key))
        collect(Json(), value,
                {here.place + "/" + key, here.pattern + "/" + key, key_below(here, key), {}, {}}, leaves);
  } else if (lists) {
    for (std::size_t i = 0; i < now.size(); ++i)
      collect(
          now[i], before[i],
          {fmt::format("{}/{}", here.place, name_of_entry(now[i], i)), here.pattern + "/*", here.key, {}, {}},
          leaves);
  } else {
    leaves.push_back({here.place, here.pattern, here.key, now, before});
  }
}

struct Fellows {
  std::vector<const Leaf*> leaves;
  double rms = 0.0;
};

std::map<std::string, Fellows> fellows_of(const std::vector<Leaf>& leaves) {
  std::map<std::string, Fellows> all;
  for (const Leaf& leaf : leaves) all[leaf.pattern].leaves.push_back(&leaf);
  for (auto& [pattern, fellows] : all) {
    double squares = 0.0;
    std::size_t n = 0;
    for (const Leaf* leaf : fellows.leaves) {
      if (!leaf->before.is_number()) continue;
      const auto value = leaf->before.get<double>();
      squares += value * value;
      ++n;
    }
    if (n > 0) fellows.rms = std::sqrt(squares / static_cast<double>(n));
  }
  return all;
}

double percent_of(double now, double before, double rms) {
  constexpr double kNearlyZero = 1e-3;  // of the fellows
  const double scale = std::max(std::abs(before), kNearlyZero * rms);
  if (now == before) return 0.0;
  return scale > 0.0 ? 100.0 * (now - before) / scale : std::copysign(100.0, now - before);
}

GateFinding finding_of(const std::string& study, const Leaf& leaf, double now, double before,
                       double percent) {
  GateFinding finding;
  finding.kind = FindingKind::number;
  finding.study = study;
  finding.what = leaf.place;
  finding.before = before;
  finding.now = now;
  finding.percent = percent;
  finding.chance = 0.0;
  const NumberMeaning meaning = meaning_of_key(leaf.key);
  if (meaning != NumberMeaning::unknown)
    finding.direction =
        (percent > 0.0) == (meaning == NumberMeaning::more_is_worse) ? Direction::worse : Direction::better;
  finding.alarm = finding.direction != Direction::better;
  return finding;
}

// A number that is there on one side only, or a text that is another.
GateFinding other_value(const std::string& study, const Leaf& leaf) {
  GateFinding finding;
  finding.kind = FindingKind::number;
  finding.study = study;
  finding.what = leaf.place;
  if (leaf.now.is_number()) finding.now = leaf.now.get<double>();
  if (leaf.before.is_number()) finding.before = leaf.before.get<double>();
  finding.note = fmt::format("{} before, {} now", json_text(leaf.before, -1), json_text(leaf.now, -1));
  const bool lost = leaf.before.is_number() && leaf.now.is_null();
  finding.direction = lost ? Direction::worse : Direction::changed;
  finding.alarm = true;
  return finding;
}

struct ListMeans {
  std::uint64_t numbers_now = 0, numbers_before = 0, both = 0;
  double now = GateFinding::kNone, before = GateFinding::kNone;  // over the entries that both have
};

ListMeans means_of(const std::vector<const Leaf*>& leaves) {
  ListMeans means;
  double now = 0.0, before = 0.0;
  for (const Leaf* leaf : leaves) {
    means.numbers_now += leaf->now.is_number();
    means.numbers_before += leaf->before.is_number();
    if (!leaf->now.is_number() || !leaf->before.is_number()) continue;
    now += leaf->now.get<double>();
    before += leaf->before.get<double>();
    ++means.both;
  }
  if (means.both == 0) return means;
  means.now = now / static_cast<double>(means.both);
  means.before = before / static_cast<double>(means.both);
  return means;
}

// Lists of samples: how many there are, and the mean of those that both nights have.
void judge_list(const std::string& study, const Fellows& fellows, const GateLimits& limits,
                NumberChanges& changes) {
  Leaf leaf = *fellows.leaves.front();
  leaf.place = leaf.pattern;
  const ListMeans means = means_of(fellows.leaves);
  if (means.numbers_now != means.numbers_before) {
    const auto now = static_cast<double>(means.numbers_now),
               before = static_cast<double>(means.numbers_before);
    GateFinding finding = finding_of(study, leaf, now, before, percent_of(now, before, 0.0));
    finding.direction = now < before ? Direction::worse : Direction::changed;
    finding.alarm = now < before;
    finding.note = fmt::format("numbers in a list of {}", fellows.leaves.size());
    changes.findings.push_back(finding);
  }
  if (means.both == 0) return;
  const double percent = percent_of(means.now, means.before, fellows.rms);
  changes.largest_percent = std::max(changes.largest_percent, std::abs(percent));
  if (std::abs(percent) <= limits.smallest_percent) return;
  changes.findings.push_back(finding_of(study, leaf, means.now, means.before, percent));
  changes.findings.back().note = fmt::format("mean of {} values", means.both);
}

void judge_leaf(const std::string& study, const Leaf& leaf, double rms, const GateLimits& limits,
                NumberChanges& changes) {
  if (!leaf.now.is_number() || !leaf.before.is_number()) {
    changes.findings.push_back(other_value(study, leaf));
    return;
  }
  const auto now = leaf.now.get<double>(), before = leaf.before.get<double>();
  const double percent = percent_of(now, before, rms);
  changes.largest_percent = std::max(changes.largest_percent, std::abs(percent));
  if (std::abs(percent) > limits.smallest_percent)
    changes.findings.push_back(finding_of(study, leaf, now, before, percent));
}

}  // namespace

NumberChanges judge_numbers(const std::string& study, const Json& now, const Json& before,
                            const GateLimits& limits) {
  NumberChanges changes;
  std::vector<Leaf> leaves;
  collect(now, before, {}, leaves);
  for (const auto& [pattern, fellows] : fellows_of(leaves)) {
    const auto same = [](const Leaf* leaf) { return leaf->now == leaf->before; };
    const auto differing = static_cast<std::uint64_t>(
        std::count_if(fellows.leaves.begin(), fellows.leaves.end(), std::not_fn(same)));
    changes.differing += differing;
    if (differing == 0 || meaning_of_key(fellows.leaves.front()->key) == NumberMeaning::not_judged) continue;
    if (fellows.leaves.size() >= kLongList && fellows.leaves.front()->place.find('[') == std::string::npos) {
      judge_list(study, fellows, limits, changes);
      continue;
    }
    for (const Leaf* leaf : fellows.leaves)
      if (!same(leaf)) judge_leaf(study, *leaf, fellows.rms, limits, changes);
  }
  std::stable_sort(changes.findings.begin(), changes.findings.end(),
                   [](const GateFinding& a, const GateFinding& b) {
                     return a.alarm != b.alarm ? a.alarm
                                               : (std::isnan(a.percent) ? 1e300 : std::abs(a.percent)) >
                                                     (std::isnan(b.percent) ? 1e300 : std::abs(b.percent));
                   });
  return changes;
}

}  // namespace trilat
