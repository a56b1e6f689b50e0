// SPDX-License-Identifier: MIT
#include "datasets/base/units.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

namespace trilat {
namespace {

struct UnitWords {
  LengthUnit unit;
  std::string_view name;
  double metres;
  std::array<std::string_view, 5> words;
};

constexpr std::array<UnitWords, 5> kUnits{{
    {LengthUnit::metre, "metre", 1.0, {"meters", "metres", "meter", "metre", "m"}},
    {LengthUnit::centimetre,
     "centimetre",
     0.01,
     {"centimeters", "centimetres", "centimeter", "centimetre", "cm"}},
    {LengthUnit::millimetre,
     "millimetre",
     0.001,
     {"millimeters", "millimetres", "millimeter", "millimetre", "mm"}},
    {LengthUnit::inch, "inch", 0.0254, {"inches", "inch", "in", "", ""}},
    {LengthUnit::foot, "foot", 0.3048, {"feet", "foot", "ft", "", ""}},
}};

}  // namespace

std::optional<LengthUnit> length_unit_from_text(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  for (const UnitWords& entry : kUnits)
    for (std::string_view word : entry.words)
      if (!word.empty() && word == lower) return entry.unit;
  return std::nullopt;
}

std::string_view name_of(LengthUnit unit) { return kUnits[static_cast<std::size_t>(unit)].name; }

std::string in_metres_text(double length, double min_m, double max_m) {
  std::string text;
  for (const LengthUnit unit : {LengthUnit::centimetre, LengthUnit::millimetre}) {
    const double length_m = length * metres_per(unit);
    if (length_m < min_m || length_m > max_m) continue;
    char number[32];  // an agent for Windows is built without fmt
    std::snprintf(number, sizeof number, "%g", length_m);
    text += (text.empty() ? "; as " : ", as ") + std::string(name_of(unit)) +
            (text.empty() ? "s it would be " : "s ") + number;
  }
  return text;
}

double metres_per(LengthUnit unit) { return kUnits[static_cast<std::size_t>(unit)].metres; }

}  // namespace trilat
