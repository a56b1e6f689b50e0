// SPDX-License-Identifier: MIT
#include "reports/figures/figure_look.h"

#include <algorithm>
#include <array>
#include <map>

namespace trilat {
namespace {

constexpr const char* kBlack = "#000000";
constexpr std::array kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                              "#8c8c1e", "#785ef0", "#56b4e9", "#7f7f7f"};
constexpr std::array kMarkers{7, 9, 5, 11, 13, 6, 4, 8};  // filled circle, triangle, square, …
constexpr int kDashes = 5;

// Families of methods with the colour of each; families that share one differ by their dash.
struct Family {
  const char* name;
  std::size_t colour;
  int dash;
};
constexpr Family kFamilies[] = {{"linear", 0, 1},
                                {"geometric", 1, 1},
                                {"nonlinear", 2, 1},
                                {"newton", 2, 4},
                                {"ceres", 2, 5},
                                {"mean", 3, 1},
                                {"tracked mean", 3, 2},
                                {"median", 4, 1},
                                {"kalman", 5, 2},
                                {"rts", 5, 1},
                                {"window", 5, 3},
                                {"range bearing", 6, 1},
                                {"single", 7, 1},
                                {"printed gradient", 1, 1},
                                {"corrected gradient", 2, 1}};

bool is_letter(char c) { return c >= 'a' && c <= 'z'; }

// The family that a name begins with, whole words only.
const Family* family_of(std::string method) {
  std::ranges::replace(method, '_', ' ');
  for (const Family& family : kFamilies) {
    const std::string name = family.name;
    if (method.compare(0, name.size(), name) == 0 &&
        (method.size() == name.size() || !is_letter(method[name.size()])))
      return &family;
  }
  return nullptr;
}

int dash_of_variant(const std::string& method, const Family& family) {
  if (method.find("printed") != std::string::npos) return 1 + (family.dash + 1) % kDashes;
  if (method.find("occlusion") != std::string::npos) return 1 + (family.dash + 2) % kDashes;
  return family.dash;
}

}  // namespace

FigureLook look_of_method(const std::string& method) {
  if (method == "truth" || method == "the paper's") return {kBlack, 1, 7};
  const Family* family = family_of(method);
  if (!family) return {kColours.back(), 1, kMarkers.back()};
  return {kColours[family->colour], dash_of_variant(method, *family), kMarkers[family->colour]};
}

std::vector<FigureLook> looks_of(const Figure& figure) {
  std::map<std::string, FigureLook> by_group;
  std::vector<std::string> taken;
  for (const FigureSeries& s : figure.series)
    if (!s.method.empty()) taken.push_back((by_group[group_of(s)] = look_of_method(s.method)).colour);
  std::vector<std::size_t> left;
  for (std::size_t k = 0; k < kColours.size(); ++k)
    if (std::ranges::find(taken, kColours[k]) == taken.end()) left.push_back(k);
  if (left.empty())
    for (std::size_t k = 0; k < kColours.size(); ++k) left.push_back(k);
  std::size_t next = 0;
  std::vector<FigureLook> looks;
  for (const FigureSeries& s : figure.series) {
    if (!by_group.contains(group_of(s))) {
      const std::size_t k = left[next % left.size()];
      by_group[group_of(s)] = {kColours[k], 1 + static_cast<int>(next / left.size()) % kDashes, kMarkers[k]};
      ++next;
    }
    looks.push_back(by_group[group_of(s)]);
  }
  return looks;
}

}  // namespace trilat
