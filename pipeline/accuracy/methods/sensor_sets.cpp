// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/sensor_sets.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

using Sets = std::vector<std::vector<std::size_t>>;

// Empty when there are more than `most`.
Sets all_sets(std::size_t sensors, std::size_t size, std::size_t most) {
  std::vector<bool> chosen(sensors, false);
  std::fill_n(chosen.begin(), size, true);
  Sets sets;
  do {
    if (sets.size() == most) return {};
    sets.emplace_back();
    for (std::size_t s = 0; s < sensors; ++s)
      if (chosen[s]) sets.back().push_back(s);
  } while (std::prev_permutation(chosen.begin(), chosen.end()));
  return sets;
}

// Fisher and Yates' shuffle.
std::vector<std::size_t> random_order(std::size_t sensors, std::uint32_t number) {
  std::vector<std::size_t> order(sensors);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t left = sensors; left > 1; --left) {
    const std::uint32_t bits = philox4x32_10({number, static_cast<std::uint32_t>(left), 0, 0}, {0, 0})[0];
    std::swap(order[left - 1], order[bits % left]);
  }
  return order;
}

}  // namespace

std::vector<std::vector<std::size_t>> sensor_sets(std::size_t sensors, std::size_t size, std::size_t most) {
  Sets sets = all_sets(sensors, size, most);
  if (!sets.empty()) return sets;
  for (std::uint32_t number = 0; sets.size() < most; ++number) {
    std::vector<std::size_t> set = random_order(sensors, number);
    set.resize(size);
    std::sort(set.begin(), set.end());
    if (std::find(sets.begin(), sets.end(), set) == sets.end()) sets.push_back(std::move(set));
  }
  return sets;
}

}  // namespace trilat
