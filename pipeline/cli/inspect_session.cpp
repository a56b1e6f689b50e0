// SPDX-License-Identifier: MIT
// `trilat info` and `trilat verify`.
#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/json.h"
#include "datasets/base/words.h"
#include "datasets/session/clock/session_clock.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_verify.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "recorders/capture.h"

namespace trilat {
namespace {

struct VerifyArguments {
  std::filesystem::path session;
  bool skip_depth = false;
  bool json = false;
};

struct InfoArguments {
  std::filesystem::path file;
  bool json = false;
};

// A sensor's clock on the host clock, for `trilat info --json`; {"problem": …} when it cannot be
// placed.
Json clock_json(const SessionReader& session, std::size_t sensor) {
  try {
    const SensorClockMap clock = fit_sensor_clock(session, sensor);
    const auto& [uncertainty, lateness_median, lateness_p99, deviation, deviation_after, drift_left_out] =
        clock.stamps;
    const SensorEpoch& longest = *std::ranges::max_element(clock.epochs, {}, &SensorEpoch::frames);
    return {{"sensor_restarts", clock.epochs.size() - 1},
            {"sensor_drift_ppm", 1e6 * longest.line.drift},
            {"sensor_bend_s", deviation.seconds()},
            {"agent_drift_ppm", 1e6 * clock.agent.line.drift},
            {"agent_bend_s", clock.agent.deviation.seconds()},
            {"offset_sigma_s", 1e-9 * static_cast<double>(uncertainty.sigma_ns)},
            {"offset_bound_s", 1e-9 * static_cast<double>(uncertainty.bound_ns)},
            {"outside_exchanges_s", uncertainty.outside.seconds()},
            {"lateness_median_s", lateness_median.seconds()},
            {"lateness_p99_s", lateness_p99.seconds()},
            {"exchanges_used", clock.agent.exchanges_used},
            {"exchanges_backwards", clock.agent.exchanges_backwards}};
  } catch (const InputError& error) {
    return {{"problem", std::string(error.what())}};
  }
}

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
  Json notices = Json::array();
  for (const SensorNotice& notice : session.notices(sensor))
    notices.push_back({{"host_ns", notice.host_ns}, {"text", notice.text}});
  Json json{{"name", d.name},
            {"serial", d.serial},
            {"model", d.model},
            {"source", d.source},
            {"body_frames", c.body_frames},
            {"bodies", c.bodies},
            {"duration_s", bodies.duration_s},
            {"rate_hz", bodies.rate_hz},
            {"depth_frames", c.depth_frames},
            {"depth_stored_bytes", session.depth_stored_bytes(sensor)},
            {"clock_exchanges", c.clock_exchanges},
            {"torn_rows", c.torn_rows},
            {"notices", notices},
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

// By its name, or by what every HDF5 file begins with.
bool may_be_session(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path) || lower_extension(path) == ".h5" ||
      path.extension() == ".partial")
    return true;
  std::string begin(4, '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return begin == "\x89HDF";
}

// Prints what a log holds so far.
int info_of_log(const std::filesystem::path& path, bool json) {
  const bool runs = is_being_written(path);
  std::vector<std::array<std::uint64_t, 3>> counts(
      kMaxSessionSensors);  // body frames, depth frames, clock exchanges
  std::vector<DropCount> drops(kMaxSessionSensors);
  const LogSummary log = read_event_log(path, [&](std::size_t sensor, LogEvent&& event) {
    if (const auto* drop = std::get_if<DropCount>(&event)) drops[sensor] = *drop;
    if (event.index() < 3) ++counts[sensor][event.index()];
  });
  Json sensors = Json::array();
  for (std::size_t s = 0; s < log.head.session.sensors.size(); ++s)
    sensors.push_back({{"name", log.head.session.sensors[s].name},
                       {"body_frames", counts[s][0]},
                       {"depth_frames", counts[s][1]},
                       {"clock_exchanges", counts[s][2]},
                       {"lost_at_source", drops[s].at_source},
                       {"lost_in_queue", drops[s].in_queue}});
  if (json) {
    fmt::print("{}\n", json_text(Json{{"format", "trilat.log"},
                                      {"version", 1},
                                      {"recording", runs},
                                      {"finished", log.finished},
                                      {"bytes", log.end},
                                      {"cut_bytes", log.cut_bytes},
                                      {"damaged_places", log.gap_count},
                                      {"started_utc", log.head.session.started_utc},
                                      {"sensors", sensors}},
                                 2));
    return kDone;
  }
  fmt::print("{}: log of a recording, {}, {:.1f} MB\n", path.string(),
             runs           ? "which runs"
             : log.finished ? "ended in order"
                            : "NOT ended by its recorder",
             1e-6 * static_cast<double>(log.end));
  if (log.gap_count > 0) fmt::print("damaged at {} places\n", log.gap_count);
  fmt::print("{:<10} {:>12} {:>13} {:>10} {:>15} {:>14}\n", "sensor", "body frames", "depth frames",
             "exchanges", "lost at source", "lost in queue");
  for (const Json& s : sensors)
    fmt::print("{:<10} {:>12} {:>13} {:>10} {:>15} {:>14}\n", s["name"].get<std::string>(),
               s["body_frames"].get<std::uint64_t>(), s["depth_frames"].get<std::uint64_t>(),
               s["clock_exchanges"].get<std::uint64_t>(), s["lost_at_source"].get<std::int64_t>(),
               s["lost_in_queue"].get<std::int64_t>());
  if (!runs) fmt::print("`trilat recover {}` makes a session of it\n", path.string());
  return kDone;
}

int info(const InfoArguments& arguments) {
  if (const auto found = found_session(arguments.file); is_event_log(found))
    return info_of_log(found, arguments.json);
  if (!may_be_session(arguments.file)) return info_of_mocap(arguments.file, arguments.json);
  const SessionReader session(found_session(arguments.file));
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
  fmt::print("{}: session, {}{}, written by {}\n", arguments.file.string(),
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

// Alike in all but the sensor and the numbers.
std::string kind_of(const Finding& finding) {
  const std::string sensors = "/sensors/";
  std::string kind = finding.place.substr(finding.place.find(":/") + 1) + finding.text;
  if (const auto at = kind.find(sensors); at != std::string::npos)
    kind.erase(at, kind.find('/', at + sensors.size()) - at);
  std::erase_if(kind, [](char c) { return (c >= '0' && c <= '9') || c == '.'; });
  return std::string(name_of(finding.severity)) + kind;
}

int verify(const VerifyArguments& arguments) {
  if (const auto log = found_session(arguments.session); is_event_log(log))
    throw InputError(log.string(),
                     "is the log of a recording that did not become a session yet; `trilat recover " +
                         log.string() + "` makes one");
  const SessionReader session(found_session(arguments.session));
  std::vector<Finding> findings;
  {
    Progress progress("verifying " + arguments.session.filename().string());
    findings = verify_session(session, {.read_depth = !arguments.skip_depth},
                              [&](double share) { progress.set(share); });
  }
  const auto errors =
      std::ranges::count_if(findings, [](const Finding& f) { return f.severity == Severity::error; });
  if (arguments.json) {
    Json list = Json::array();
    for (const Finding& f : findings)
      list.push_back({{"severity", std::string(name_of(f.severity))},
                      {"place", f.place},
                      {"text", f.text},
                      {"endangers", f.affects}});
    const Json json{{"sound", errors == 0}, {"errors", errors}, {"findings", list}};
    fmt::print("{}\n", json_text(json, 2));
  } else {
    std::set<std::string> reported;  // what findings endanger, each printed once
    std::map<std::string, std::size_t> alike;
    for (const Finding& f : findings) ++alike[kind_of(f)];
    for (const Finding& f : findings) {
      const std::size_t others = std::exchange(alike[kind_of(f)], 0);
      const bool is_error = f.severity == Severity::error;
      if (!is_error && others == 0) continue;
      fmt::print(
          "{}: {}: {}{}{}\n", name_of(f.severity),
          is_error ? f.place : f.place.substr(f.place.find(":/") + 1), f.text,
          !is_error && others > 1 ? fmt::format("; {} more of the kind", others - 1) : "",
          reported.insert(f.affects).second && !f.affects.empty() ? " (endangers " + f.affects + ")" : "");
    }
    fmt::print("{}: {}{}\n", arguments.session.string(), errors == 0 ? "sound" : counted(errors, "error"),
               has_no_bodies(session) ? ", but no sensor sees anybody: no frame holds a body" : "");
  }
  return errors == 0 ? kDone : kItemsFailed;
}

}  // namespace

void add_info(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<InfoArguments>(
      app, code, "info", "what is in a session or in motion capture: sensors or assets, rates, gaps", info,
      OnInterrupt::at_once);
  verb.add_option("file", a.file, "session.h5, or a CSV of Motive, or a TRC")->required();
  add_json(verb, a.json);
}

void add_verify(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<VerifyArguments>(
      app, code, "verify", "read everything in a session and say what is odd", verify, OnInterrupt::at_once);
  verb.add_option("session", a.session, "session.h5")->required();
  verb.add_flag("--skip-depth", a.skip_depth, "do not decompress the depth frames");
  add_json(verb, a.json);
}

}  // namespace trilat
