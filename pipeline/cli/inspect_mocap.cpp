// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/json.h"
#include "datasets/mocap/mocap_take.h"
#include "datasets/mocap/read_mocap.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

// Motive's own exports have y up, whatever they show.
LikelyUp up_of(const MocapHeader& header, const MocapSummary& summary) {
  return header.format.starts_with("Motive") ? LikelyUp{} : likely_up(summary);
}

Json json_of(const MocapHeader& header, const MocapSummary& s, const MocapAnomalies& a) {
  Json assets = Json::array();
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    const MocapAsset& asset = header.assets[i];
    const AssetSummary& summary = s.assets[i];
    assets.push_back({{"type", std::string(name_of(asset.type))},
                      {"name", asset.name},
                      {"id", asset.id},
                      {"position", asset.has_position},
                      {"samples", summary.samples},
                      {"missing", summary.missing},
                      {"frozen", summary.no_measurement.held},
                      {"at_origin", summary.no_measurement.at_origin},
                      {"fill_values", summary.no_measurement.filled}});
  }
  const LikelyUp up = up_of(header, s);
  const auto count_or_null = [](const std::optional<std::int64_t>& n) { return n ? Json(*n) : Json(); };
  return {{"format", header.format},
          {"take", header.take_name},
          {"frames", s.frames},
          {"first_frame", header.first_frame},
          {"duration_s", s.duration_s},
          {"rate_hz", s.rate_hz},
          {"length_unit", std::string(name_of(header.length_unit))},
          {"coordinate_space", header.coordinate_space},
          {"probably_up", up.axis ? Json(std::string(1, *up.axis)) : Json()},
          {"capture_start", header.capture_start_text},
          {"stated_frames", count_or_null(header.total_exported_frames)},
          {"index_gaps", s.index_gaps},
          {"skipped_frames", s.skipped_frames},
          {"largest_time_error_s", a.largest_time_error_s},
          {"repeated_frames", a.repeated_frames},
          {"rows_with_extra_fields", a.rows_with_extra_fields},
          {"not_finite_cells", a.not_finite_cells},
          {"partial_poses", a.partial_poses},
          {"printed_time_differs", a.printed_time_differs},
          {"truncated_last_row", a.truncated_last_row},
          {"assets", assets}};
}

void print_anomalies(const MocapAnomalies& a) {
  const std::pair<std::int64_t, const char*> counts[] = {
      {a.repeated_frames, "repeated frames left out"},
      {a.rows_with_extra_fields, "rows with extra fields"},
      {a.not_finite_cells, "cells that are not finite, taken as missing"},
      {a.partial_poses, "positions that are not whole, taken as missing"},
      {a.printed_time_differs, "printed times off their frame by more than a period"},
      {a.truncated_last_row ? 1 : 0, "incomplete last row, left out"}};
  for (const auto& [count, what] : counts)
    if (count > 0) fmt::print("odd: {} {}\n", count, what);
  if (a.frames_promised > 0)
    fmt::print("odd: the header promises {} frames, the file has {}\n", a.frames_promised, a.frames_there);
}

void print_text(const std::string& path, const MocapHeader& header, const MocapSummary& s,
                const MocapAnomalies& a) {
  fmt::print("{}: {}, take \"{}\"\n", path, header.format, header.take_name);
  fmt::print("{} frames from {} at {:g} Hz ({:.3f} s), unit {}\n", s.frames, header.first_frame, s.rate_hz,
             s.duration_s, name_of(header.length_unit));
  if (const LikelyUp up = up_of(header, s); up.axis)
    fmt::print("up: probably {}{}; the assets spread {:.2f}, {:.2f}, {:.2f} m along x, y, z\n", *up.axis,
               *up.axis == 'y' ? "" : " (state \"up_axis\": \"z\" in the take; init does)", up.spread_m.x(),
               up.spread_m.y(), up.spread_m.z());
  if (s.index_gaps > 0)
    fmt::print("{} gaps in the frame numbers, {} frames missing\n", s.index_gaps, s.skipped_frames);
  if (!header.taken_as.empty()) fmt::print("odd: {}\n", header.taken_as);
  print_anomalies(a);
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    const MissingCounts& counts = s.assets[i].no_measurement;
    if (counts.at_origin > 0)
      fmt::print("odd: {}: {} positions are exactly (0, 0, 0), taken as missing\n", header.assets[i].name,
                 counts.at_origin);
    if (counts.filled > 0)
      fmt::print("odd: {}: {} positions are one value again and again, taken as missing\n",
                 header.assets[i].name, counts.filled);
    if (counts.held > 0)
      fmt::print(
          "odd: {}: {} positions repeat the one before to the last digit while others move, taken as "
          "missing\n",
          header.assets[i].name, counts.held);
  }
  if (header.assets.empty()) {
    fmt::print("no assets: the export holds no data columns\n");
    return;
  }
  std::size_t width = 4;
  for (const MocapAsset& asset : header.assets) width = std::max(width, asset.name.size());
  width = std::min<std::size_t>(width, 60);
  fmt::print("{:<18} {:<{}} {:>9} {:>9} {:>8}\n", "type", "name", width, "samples", "missing", "frozen");
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    const AssetSummary& t = s.assets[i];
    fmt::print("{:<18} {:<{}} {:>9} {:>9} {:>8}\n", name_of(header.assets[i].type), header.assets[i].name,
               width, t.samples, t.missing, t.no_measurement.held);
  }
}

}  // namespace

int info_of_mocap(const std::filesystem::path& file, bool json) {
  MocapTake take = read_mocap(file);
  const MocapHeader header = take.header;
  const MocapAnomalies anomalies = take.anomalies;
  const MocapSummary summary = summarize_mocap(std::move(take));
  if (json)
    fmt::print("{}\n", json_text(json_of(header, summary, anomalies), 2));
  else
    print_text(file.string(), header, summary, anomalies);
  return kDone;
}

}  // namespace trilat
