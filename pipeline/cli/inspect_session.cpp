// SPDX-License-Identifier: MIT
// `trilat info` and `trilat verify`.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"
#include "datasets/session/session_clock.h"
#include "datasets/session/session_verify.h"
#include "pipeline/cli/clock_json.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

struct Span {
  double duration_s = 0.0;
  double rate_hz = 0.0;
};

// How long a stream lasts on the sensor's own clock, and how many frames a second it holds.
Span span_of(const SessionReader& session, std::size_t sensor, FrameStream stream, std::uint64_t frames) {
  if (frames < 2) return {};
  const SensorDescription& description = session.header().sensors[sensor];
  const auto first = session.stamps(sensor, stream, 0, 1);
  const auto last = session.stamps(sensor, stream, frames - 1, 1);
  const double duration_s =
      (device_time(description, last[0]) - device_time(description, first[0])).seconds();
  return {duration_s, duration_s > 0.0 ? static_cast<double>(frames - 1) / duration_s : 0.0};
}

Json json_of(const SessionReader& session, std::size_t sensor) {
  const SensorDescription& d = session.header().sensors[sensor];
  const SensorCounts& c = session.counts(sensor);
  const Span bodies = span_of(session, sensor, FrameStream::bodies, c.body_frames);
  const auto drops = session.drop_counts(sensor);
  const DropCount last_drop = drops.empty() ? DropCount{} : drops.back();
  Json json{{"name", d.name},
            {"serial", d.serial},
            {"model", d.model},
            {"source", d.source},
            {"body_frames", c.body_frames},
            {"bodies", c.bodies},
            {"duration_s", bodies.duration_s},
            {"rate_hz", bodies.rate_hz},
            {"depth_frames", c.depth_frames},
            {"depth_stored_bytes", c.depth_stored_bytes},
            {"clock_exchanges", c.clock_exchanges},
            {"torn_rows", c.torn_rows},
            {"dropped_at_source", last_drop.at_source},
            {"dropped_in_queue", last_drop.in_queue},
            {"fx_px", d.intrinsics.fx_px},
            {"fy_px", d.intrinsics.fy_px},
            {"cx_px", d.intrinsics.cx_px},
            {"cy_px", d.intrinsics.cy_px}};
  if (c.depth_frames > 0) {
    const Span depth = span_of(session, sensor, FrameStream::depth, c.depth_frames);
    json["depth_duration_s"] = depth.duration_s;
    json["depth_rate_hz"] = depth.rate_hz;
  }
  json["clock"] = clock_json(session, sensor);
  return json;
}

}  // namespace

int info(const InfoArguments& arguments) {
  const SessionReader session(arguments.session);
  Json sensors = Json::array();
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) sensors.push_back(json_of(session, s));
  if (arguments.json) {
    const Json json{{"format", "trilat.session"},
                    {"version", 1},
                    {"created_by", session.created_by()},
                    {"complete", session.complete()},
                    {"simulated", session.header().simulated},
                    {"started_utc", session.header().started_utc},
                    {"note", session.header().note},
                    {"sensors", sensors}};
    fmt::print("{}\n", json_text(json, 2));
    return kDone;
  }
  fmt::print("{}: session, {}{}, written by {}\n", arguments.session.string(),
             session.complete() ? "complete" : "NOT closed by its recorder",
             session.header().simulated ? ", simulated" : "", session.created_by());
  if (!session.header().started_utc.empty()) fmt::print("started {}\n", session.header().started_utc);
  fmt::print("{:<10} {:<20} {:>12} {:>10} {:>10} {:>9} {:>13} {:>10}\n", "sensor", "serial", "body frames",
             "bodies", "length s", "rate Hz", "depth frames", "exchanges");
  for (const Json& s : sensors)
    fmt::print("{:<10} {:<20} {:>12} {:>10} {:>10.2f} {:>9.3f} {:>13} {:>10}\n", s["name"].get<std::string>(),
               s["serial"].get<std::string>(), s["body_frames"].get<std::uint64_t>(),
               s["bodies"].get<std::uint64_t>(), s["duration_s"].get<double>(), s["rate_hz"].get<double>(),
               s["depth_frames"].get<std::uint64_t>(), s["clock_exchanges"].get<std::uint64_t>());
  return kDone;
}

int verify(const VerifyArguments& arguments) {
  const SessionReader session(arguments.session);
  std::vector<Finding> findings;
  {
    Progress progress("verifying " + arguments.session.filename().string());
    findings = verify_session(session, {.read_depth = !arguments.skip_depth},
                              [&](double share) { progress.set(share); });
  }
  const auto errors = std::count_if(findings.begin(), findings.end(),
                                    [](const Finding& f) { return f.severity == Severity::error; });
  if (arguments.json) {
    Json list = Json::array();
    for (const Finding& f : findings)
      list.push_back({{"severity", std::string(name_of(f.severity))}, {"place", f.place}, {"text", f.text}});
    const Json json{{"sound", errors == 0}, {"errors", errors}, {"findings", list}};
    fmt::print("{}\n", json_text(json, 2));
  } else {
    for (const Finding& f : findings) fmt::print("{}: {}: {}\n", name_of(f.severity), f.place, f.text);
    fmt::print("{}: {}\n", arguments.session.string(),
               errors == 0 ? "sound" : fmt::format("{} error{}", errors, errors == 1 ? "" : "s"));
  }
  return errors == 0 ? kDone : kItemsFailed;
}

}  // namespace trilat
