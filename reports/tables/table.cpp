// SPDX-License-Identifier: MIT
#include "reports/tables/table.h"

#include <algorithm>
#include <array>
#include <utility>

namespace trilat {
namespace {

constexpr std::array<std::pair<const char*, const char*>, 8> kUnits{{{"_percent", "%"},
                                                                     {"_cm", "cm"},
                                                                     {"_mm", "mm"},
                                                                     {"_us", "us"},
                                                                     {"_ms", "ms"},
                                                                     {"_deg", "degrees"},
                                                                     {"_ppm", "ppm"},
                                                                     {"_m_s3", "m/s³"}}};

}  // namespace

std::string header_of(const TableColumn& column) {
  if (column.is_text || column.name.find_first_of("(%") != std::string::npos) return column.name;
  if (column.key == "percent_from" || column.key == "percent_to") return column.name + " (%)";
  for (const auto& [ending, unit] : kUnits)
    if (column.key.ends_with(ending)) return column.name + " (" + unit + ")";
  return column.name;
}

std::string usable_id(std::string text) {
  const auto is_kept = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  std::replace_if(
      text.begin(), text.end(), [&](char c) { return !is_kept(c); }, '-');
  return text;
}

}  // namespace trilat
