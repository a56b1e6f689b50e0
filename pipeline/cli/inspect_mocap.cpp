// SPDX-License-Identifier: MIT
// `trilat mocap`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"
#include "datasets/mocap/mocap_summary.h"
#include "datasets/mocap/optitrack_csv_reader.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

Json json_of(const MocapHeader& header, const MocapSummary& s, const MocapAnomalies& a) {
  Json assets = Json::array();
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    const MocapAsset& asset = header.assets[i];
    const AssetSummary& summary = s.assets[i];
    assets.push_back({{"type", std::string(name_of(asset.type))},
                      {"name", asset.name},
                      {"id", asset.id},
                      {"position", asset.has_position},
                      {"rotation", asset.has_rotation},
                      {"samples", summary.samples},
                      {"missing", summary.missing},
                      {"frozen", summary.frozen},
                      {"jumps", summary.jumps},
                      {"sentinels", summary.sentinels},
                      {"longest_gap_s", summary.longest_gap_s}});
  }
  return {{"format", header.format},
          {"take", header.take_name},
          {"frames", s.frames},
          {"first_frame", s.first_index},
          {"duration_s", s.duration_s},
          {"rate_hz", s.rate_hz},
          {"length_unit", std::string(name_of(header.length_unit))},
          {"rotation_type", header.rotation_type},
          {"coordinate_space", header.coordinate_space},
          {"left_handed", header.left_handed},
          {"capture_start", header.capture_start},
          {"stated_frames", header.stated_frames ? Json(*header.stated_frames) : Json()},
          {"index_gaps", s.index_gaps},
          {"index_missing", s.index_missing},
          {"worst_printed_time_error_s", s.worst_printed_time_error_s},
          {"repeated_frames", a.repeated_frames},
          {"rows_with_extra_fields", a.rows_with_extra_fields},
          {"not_finite_cells", a.not_finite_cells},
          {"truncated_last_row", a.truncated_last_row},
          {"assets", assets}};
}

void print_text(const std::string& path, const MocapHeader& header, const MocapSummary& s,
                const MocapAnomalies& a) {
  fmt::print("{}: {}, take \"{}\"\n", path, header.format, header.take_name);
  fmt::print("{} frames from {} at {:g} Hz ({:.3f} s), unit {}, {}\n", s.frames, s.first_index, s.rate_hz,
             s.duration_s, name_of(header.length_unit),
             header.left_handed ? "left-handed (read as right-handed)" : "right-handed");
  if (s.index_gaps > 0)
    fmt::print("{} gaps in the frame numbers, {} frames missing\n", s.index_gaps, s.index_missing);
  if (a.repeated_frames + a.rows_with_extra_fields + a.not_finite_cells > 0 || a.truncated_last_row)
    fmt::print("put up with: {} repeated frames, {} rows with extra fields, {} cells that are not finite{}\n",
               a.repeated_frames, a.rows_with_extra_fields, a.not_finite_cells,
               a.truncated_last_row ? ", a last row that is cut" : "");
  if (header.assets.empty()) {
    fmt::print("no assets: the export holds no data columns\n");
    return;
  }
  fmt::print("{:<18} {:<32} {:>9} {:>9} {:>8} {:>6} {:>10}\n", "type", "name", "samples", "missing", "frozen",
             "jumps", "longest gap");
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    const AssetSummary& t = s.assets[i];
    fmt::print("{:<18} {:<32} {:>9} {:>9} {:>8} {:>6} {:>8.3f} s\n", name_of(header.assets[i].type),
               header.assets[i].name, t.samples, t.missing, t.frozen, t.jumps, t.longest_gap_s);
  }
}

}  // namespace

int mocap(const MocapArguments& arguments) {
  OptitrackCsvReader reader(arguments.file);
  MocapSummarizer summarizer(reader.header(), {});
  for (MocapFrame frame; reader.next(frame);) summarizer.add(frame);
  const MocapSummary summary = summarizer.finish();
  if (arguments.json)
    fmt::print("{}\n", json_text(json_of(reader.header(), summary, reader.anomalies()), 2));
  else
    print_text(arguments.file.string(), reader.header(), summary, reader.anomalies());
  return kDone;
}

}  // namespace trilat
