// SPDX-License-Identifier: MIT
#include "datasets/results/gate_history.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/text_output.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 30, kTextColumns = 6;
constexpr std::string_view kSeparator = "; ";

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t first = 0; first < text.size();) {
    const std::size_t end = std::min(text.find(kSeparator, first), text.size());
    parts.push_back(text.substr(first, end - first));
    first = end + kSeparator.size();
  }
  return parts;
}

double error_of(const std::string& cell, const std::string& column, const std::string& place) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc{} || end != cell.data() + cell.size() || !(value >= 0.0) || !std::isfinite(value))
    throw InputError(place,
                     fmt::format("{} is \"{}\"; it must be an error in metres or empty", column, cell));
  return value;
}

Night night_of(const std::vector<std::string>& cells, const std::vector<std::string>& columns,
               const std::string& place) {
  if (cells.size() != columns.size())
    throw InputError(place, fmt::format("has {} of {} cells: the line is cut or was edited; take it out",
                                        cells.size(), columns.size()));
  const auto verdict =
      std::ranges::find(kNightVerdicts, cells[2], [](const char* v) { return std::string(v); });
  if (verdict == kNightVerdicts.end())
    throw InputError(place, fmt::format("verdict is \"{}\"; it must be one of {}", cells[2],
                                        fmt::join(kNightVerdicts, ", ")));
  Night night{.time = cells[0],
              .program = cells[1],
              .verdict = static_cast<NightVerdict>(verdict - kNightVerdicts.begin()),
              .reason = cells[3],
              .alarms = split(cells[4]),
              .not_judged = split(cells[5])};
  for (std::size_t c = kTextColumns; c < cells.size(); ++c)
    if (!cells[c].empty()) night.mean_error_m[columns[c]] = error_of(cells[c], columns[c], place);
  return night;
}

std::vector<std::string> columns_of(const std::string& header, const std::string& place) {
  if (header.starts_with("{"))
    throw InputError(place,
                     "is a history of version 0.4.0; move it away, and the next night begins a new one");
  const bool is_ours = header == kHistoryHeader || header.starts_with(std::string(kHistoryHeader) + ",");
  if (!is_ours) throw InputError(place, fmt::format("must begin with \"{}\"", kHistoryHeader));
  return csv_fields(header);
}

}  // namespace

const char* name_of(NightVerdict verdict) { return kNightVerdicts.at(static_cast<std::size_t>(verdict)); }

std::vector<Night> read_history(const std::filesystem::path& path) {
  std::vector<Night> nights;
  if (!std::filesystem::exists(path)) return nights;
  std::vector<std::string> columns;
  for_each_csv_record(path.string(), read_file(path, kMaxBytes),
                      [&](const std::string& place, const std::string& record) {
                        if (columns.empty())
                          columns = columns_of(record, place);
                        else
                          nights.push_back(night_of(csv_fields(record), columns, place));
                      });
  return nights;
}

void add_to_history(const std::filesystem::path& path, const Night& night) {
  std::vector<Night> nights = read_history(path);
  nights.push_back(night);
  std::set<std::string> columns;
  for (const Night& one : nights)
    for (const auto& [column, error_m] : one.mean_error_m) columns.insert(column);
  TextOutput file(path);
  file.add("{}", kHistoryHeader);
  for (const std::string& column : columns) file.add(",{}", csv_field(column));
  file.add("\n");
  for (const Night& one : nights) {
    file.add("{},{},{},{},{},{}", one.time, csv_field(one.program), name_of(one.verdict),
             csv_field(one.reason), csv_field(fmt::format("{}", fmt::join(one.alarms, kSeparator))),
             csv_field(fmt::format("{}", fmt::join(one.not_judged, kSeparator))));
    for (const std::string& column : columns) {
      const auto error_m = one.mean_error_m.find(column);
      if (error_m == one.mean_error_m.end())
        file.add(",");
      else
        file.add(",{}", error_m->second);
    }
    file.add("\n");
  }
  file.publish();
}

}  // namespace trilat
