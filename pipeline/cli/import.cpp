// SPDX-License-Identifier: MIT
// `trilat import`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/import/import_formats.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/exchange_verbs.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

ChunkCompression compression_named(const std::string& name) {
  return name == "deflate" ? ChunkCompression::deflate
         : name == "none"  ? ChunkCompression::none
                           : ChunkCompression::blosc;
}

Json json_of(const ImportedSensor& s) {
  Json json{{"name", s.name},
            {"file", s.file},
            {"body_frames", s.body_frames},
            {"bodies", s.bodies},
            {"depth_frames", s.depth_frames},
            {"gap_frames", s.gap_frames},
            {"skipped_events", s.skipped_events},
            {"skipped_bytes", s.skipped_bytes},
            {"torn_rows", s.left_out.torn_rows},
            {"repeated_times", s.left_out.repeated_times},
            {"backward_times", s.left_out.backward_times},
            {"first_left_out", s.left_out.first}};
  json["intrinsics_rms_px"] = s.intrinsics_rms_px ? Json(*s.intrinsics_rms_px) : Json(nullptr);
  return json;
}

void print_report(const ImportReport& report, const std::filesystem::path& output) {
  fmt::print("{}\n", output.string());
  fmt::print("{:<10} {:>12} {:>8} {:>13} {:>11} {:>9} {:>14} {:>15} {:>9}  {}\n", "sensor", "body frames",
             "bodies", "depth frames", "gap frames", "torn rows", "repeated times", "backward times",
             "skipped", "intrinsics");
  for (const ImportedSensor& s : report.sensors)
    fmt::print("{:<10} {:>12} {:>8} {:>13} {:>11} {:>9} {:>14} {:>15} {:>9}  {}\n", s.name, s.body_frames,
               s.bodies, s.depth_frames, s.gap_frames, s.left_out.torn_rows, s.left_out.repeated_times,
               s.left_out.backward_times, s.skipped_events,
               s.intrinsics_rms_px ? fmt::format("fitted, {:.2f} px", *s.intrinsics_rms_px) : "default");
  fmt::print("{}\n", report.note);
  for (const ImportedSensor& s : report.sensors) {
    if (s.left_out.total() > 0)
      fmt::print("{}: {} left out; first: {}\n", s.name, s.left_out.total(), s.left_out.first);
    if (s.skipped_bytes > 0) fmt::print("{}: {} damaged bytes stepped over\n", s.name, s.skipped_bytes);
  }
}

}  // namespace

int import_session(const ImportArguments& arguments) {
  std::vector<std::filesystem::path> inputs = arguments.files;
  inputs.push_back(arguments.timestamps);
  check_output({arguments.output, OutputKind::session, inputs, arguments.force});
  ImportOptions options{.rate_hz = arguments.rate_hz,
                        .depth_unit_mm = arguments.depth_unit_mm,
                        .timestamps = arguments.timestamps,
                        .time_from_name = arguments.time_from_name,
                        .compression = compression_named(arguments.compression)};
  ImportReport report;
  {
    Progress progress("importing " + arguments.format);
    options.progress = [&](double share) {
      if (stop_requested()) throw Interrupted();
      progress.set(share);
    };
    report = import_recording(arguments.format, arguments.files, arguments.output, options);
  }
  Json sensors = Json::array();
  bool left_out = false;
  for (const ImportedSensor& s : report.sensors) {
    sensors.push_back(json_of(s));
    left_out = left_out || s.left_out.total() > 0 || s.skipped_bytes > 0;
  }
  if (arguments.json)
    fmt::print("{}\n", json_text(Json{{"session", arguments.output.string()},
                                      {"format", arguments.format},
                                      {"note", report.note},
                                      {"sensors", sensors}},
                                 2));
  else
    print_report(report, arguments.output);
  return left_out ? kItemsFailed : kDone;
}

}  // namespace trilat
