// SPDX-License-Identifier: MIT
#include "pipeline/stream_fit/point_stream.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "datasets/mocap/mocap_take.h"

namespace trilat {
namespace {

// Pairs of words for left and right, as plain_name() writes them.
constexpr std::array<std::pair<std::string_view, std::string_view>, 9> kSides{{{"left", "right"},
                                                                               {"左", "右"},
                                                                               {"links", "rechts"},
                                                                               {"linke", "rechte"},
                                                                               {"gauche", "droite"},
                                                                               {"gauche", "droit"},
                                                                               {"izquierd", "derech"},
                                                                               {"Лев", "Прав"},
                                                                               {"лев", "прав"}}};

// The names that the other side may have.
std::vector<std::string> other_sides(const std::string& name) {
  std::vector<std::string> others;
  const auto exchange = [&](std::string_view from, std::string_view to) {
    if (const std::size_t at = name.find(from); at != std::string::npos)
      others.push_back(std::string(name).replace(at, from.size(), to));
  };
  for (const auto& [left, right] : kSides) {
    exchange(left, right);
    exchange(right, left);
  }
  if (name.empty()) return others;
  constexpr std::array<std::pair<char, char>, 4> kLetters{{{'l', 'r'}, {'r', 'l'}, {'+', '-'}, {'-', '+'}}};
  for (const auto& [from, to] : kLetters)
    for (const std::size_t at : {std::size_t{0}, name.size() - 1})
      if (name[at] == from) {
        others.push_back(name);
        others.back()[at] = to;
      }
  return others;
}

}  // namespace

void PointStream::at_time(double when_s, std::span<Eigen::Vector3d> position_m) const {
  const double place = (when_s - first_s) * rate_hz;
  const auto last = static_cast<double>(instants()) - 1.0;
  constexpr double kNear = 1e-6;  // of a step
  if (!(place >= -kNear && place <= last + kNear)) {
    std::ranges::fill(position_m, Eigen::Vector3d::Constant(std::nan("")));
    return;
  }
  const double below = std::clamp(std::floor(place + kNear), 0.0, last);
  const double share = place - below;
  const Eigen::Vector3d* const a = &at_m[static_cast<std::size_t>(below) * points];
  if (std::abs(share) <= kNear) {
    std::copy_n(a, points, position_m.begin());
    return;
  }
  for (std::size_t j = 0; j < points; ++j) position_m[j] = a[j] + share * (a[j + points] - a[j]);
}

std::vector<std::size_t> mirrored_points(const std::vector<std::string>& names) {
  std::vector<std::string> plain;
  for (const std::string& name : names) plain.push_back(plain_name(name));
  std::vector<std::size_t> mirrored(names.size());
  for (std::size_t j = 0; j < names.size(); ++j) {
    mirrored[j] = j;
    for (const std::string& other : other_sides(plain[j]))
      if (const auto found = std::ranges::find(plain, other); found != plain.end())
        mirrored[j] = static_cast<std::size_t>(found - plain.begin());
  }
  for (std::size_t j = 0; j < names.size(); ++j)
    if (mirrored[mirrored[j]] != j) mirrored[j] = j;
  return mirrored;
}

}  // namespace trilat
