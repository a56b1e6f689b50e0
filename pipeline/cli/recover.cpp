// SPDX-License-Identifier: MIT
// `trilat recover`.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/json.h"
#include "datasets/base/words.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_recover.h"
#include "datasets/session/write_session.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "recorders/capture.h"

namespace trilat {
namespace {

struct RecoverArguments {
  std::vector<std::filesystem::path> left;  // by recorders: logs, or one unfinished session
  std::filesystem::path output;
  bool force = false;  // may replace what others wrote
  bool json = false;
};

// Default path of the saved session: the name without .partial or .trilog, where there is one.
std::filesystem::path default_output(const std::filesystem::path& left) {
  if (left.extension() == ".partial" || left.extension() == ".trilog")
    return left.parent_path() / left.stem();
  return left.string() + ".recovered.h5";
}

// A recording that was finished, but for its name.
int give_its_name(const std::filesystem::path& damaged, const std::filesystem::path& output, bool json) {
  const bool unnamed = damaged.extension() == ".partial";
  if (unnamed) publish_file(damaged, output);
  const std::filesystem::path session = unnamed ? output : damaged;
  if (json)
    fmt::print("{}\n", json_text(Json{{"session", session.string()}, {"complete", true}}, 2));
  else if (unnamed)
    fmt::print("{} was finished, but for its name: it is now {}\n", damaged.string(), session.string());
  else
    fmt::print("{} is complete; there is nothing to recover\n", session.string());
  return kDone;
}

std::uint64_t lost_rows(const SensorRecovery& r) {
  return r.damaged_body_frames + r.damaged_depth_frames + r.damaged_exchanges + r.damaged_lists;
}

void print_recovery(const std::vector<SensorRecovery>& recoveries, const std::filesystem::path& output,
                    const std::filesystem::path& damaged) {
  fmt::print("{}: everything that had been flushed of {}\n", output.string(), damaged.string());
  fmt::print("{:<10} {:>12} {:>13} {:>10} {:>14} {:>9}\n", "sensor", "body frames", "depth frames",
             "exchanges", "behind flush", "damaged");
  for (const SensorRecovery& r : recoveries)
    fmt::print("{:<10} {:>12} {:>13} {:>10} {:>14} {:>9}\n", r.name, r.saved.body_frames,
               r.saved.depth_frames, r.saved.clock_exchanges, r.torn_rows, lost_rows(r));
  fmt::print(
      "What was recorded after the last flush, at most a second, is lost. {} is as it was; remove it when "
      "you have looked at what was saved\n",
      damaged.string());
}

Json json_of(const std::vector<SensorRecovery>& recoveries, const std::filesystem::path& output,
             const std::filesystem::path& damaged) {
  Json sensors = Json::array();
  for (const SensorRecovery& r : recoveries)
    sensors.push_back({{"name", r.name},
                       {"body_frames", r.saved.body_frames},
                       {"depth_frames", r.saved.depth_frames},
                       {"clock_exchanges", r.saved.clock_exchanges},
                       {"torn_rows", r.torn_rows},
                       {"damaged_body_frames", r.damaged_body_frames},
                       {"damaged_depth_frames", r.damaged_depth_frames},
                       {"damaged_exchanges", r.damaged_exchanges},
                       {"damaged_lists", r.damaged_lists}});
  return {
      {"session", output.string()}, {"from", damaged.string()}, {"complete", false}, {"sensors", sensors}};
}

// A session of version 0.4.0 or older whose recorder was killed.
int recover_session_file(const std::filesystem::path& damaged, const RecoverArguments& arguments) {
  const std::filesystem::path output = arguments.output.empty() ? default_output(damaged) : arguments.output;
  const bool complete = SessionReader(damaged).complete();
  if (!complete || damaged.extension() == ".partial")
    check_output_file({output, {damaged}, arguments.force, ".recovered.partial"});
  if (complete) return give_its_name(damaged, output, arguments.json);
  std::vector<SensorRecovery> recoveries;
  {
    Progress progress("recovering " + damaged.filename().string());
    recoveries = recover_session(damaged, output, [&](double share) {
      progress.set(share);
      return !stop_requested();
    });
  }
  if (arguments.json)
    fmt::print("{}\n", json_text(json_of(recoveries, output, damaged), 2));
  else
    print_recovery(recoveries, output, damaged);
  if (std::ranges::none_of(recoveries, [](const auto& r) { return lost_rows(r) > 0; })) return kDone;
  fmt::print(stderr, "failed: {} has rows that are damaged or cannot be read; they were left out\n",
             damaged.string());
  return kItemsFailed;
}

std::uint64_t damaged_bytes(const LogsWritten& written) {
  std::uint64_t bytes = 0;
  for (const LogSummary& log : written.logs)
    for (const LogGap& gap : log.gaps) bytes += gap.bytes;
  return bytes;
}

void print_recovery(const LogsWritten& written, const std::vector<std::filesystem::path>& logs,
                    const std::filesystem::path& output) {
  fmt::print("{:<10} {:>12} {:>13} {:>10} {:>15} {:>14} {:>9}\n", "sensor", "body frames", "depth frames",
             "exchanges", "lost at source", "lost in queue", "left out");
  for (const SensorWritten& s : written.sensors)
    fmt::print("{:<10} {:>12} {:>13} {:>10} {:>15} {:>14} {:>9}\n", s.name, s.body_frames, s.depth_frames,
               s.clock_exchanges, s.drops.at_source, s.drops.in_queue, s.left_out);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const LogSummary& log = written.logs[i];
    if (log.gap_count > 0)
      fmt::print("{}: damaged at {}, the first behind byte {}; what they held is left out\n",
                 logs[i].string(), counted(log.gap_count, "place"), log.gaps.front().offset);
    if (!log.finished)
      fmt::print("{}: was not ended by its recorder; at most its last second is lost\n", logs[i].string());
  }
  fmt::print("{}: all that is whole of {}, which may be removed now\n", output.string(),
             counted(logs.size(), "log"));
}

Json json_of(const LogsWritten& written, const std::vector<std::filesystem::path>& logs,
             const std::filesystem::path& output) {
  Json sensors = Json::array(), from = Json::array();
  for (const SensorWritten& s : written.sensors)
    sensors.push_back({{"name", s.name},
                       {"body_frames", s.body_frames},
                       {"depth_frames", s.depth_frames},
                       {"clock_exchanges", s.clock_exchanges},
                       {"lost_at_source", s.drops.at_source},
                       {"lost_in_queue", s.drops.in_queue},
                       {"left_out", s.left_out}});
  for (std::size_t i = 0; i < logs.size(); ++i)
    from.push_back({{"log", logs[i].string()},
                    {"finished", written.logs[i].finished},
                    {"damaged_places", written.logs[i].gap_count}});
  return {{"session", output.string()},
          {"from", from},
          {"damaged_bytes", damaged_bytes(written)},
          {"sensors", sensors}};
}

int recover_logs(const std::vector<std::filesystem::path>& logs, const RecoverArguments& arguments) {
  const std::filesystem::path output =
      arguments.output.empty() ? default_output(logs.front()) : arguments.output;
  check_output_file({output, logs, arguments.force});
  LogsWritten written;
  {
    Progress progress("recovering " + output.filename().string());
    written = write_session({logs.begin(), logs.end()}, output, [&](double share) {
      progress.set(share);
      return !stop_requested();
    });
  }
  if (arguments.json)
    fmt::print("{}\n", json_text(json_of(written, logs, output), 2));
  else
    print_recovery(written, logs, output);
  const bool damaged =
      damaged_bytes(written) > 0 ||
      std::ranges::any_of(written.sensors, [](const SensorWritten& s) { return s.left_out > 0; });
  if (!damaged) return kDone;
  fmt::print(stderr, "failed: parts of what was recorded are damaged; they were left out\n");
  return kItemsFailed;
}

int recover(const RecoverArguments& arguments) {
  RecoverArguments found = arguments;
  std::vector<std::filesystem::path> left;
  for (const std::filesystem::path& path : arguments.left) {
    const auto logs = std::filesystem::exists(path) ? std::vector{path} : logs_beside(path);
    if (logs.empty()) {
      left.push_back(found_session(path));
    } else {
      if (found.output.empty() && logs.front() != path) found.output = path;
      left.insert(left.end(), logs.begin(), logs.end());
    }
  }
  if (std::ranges::all_of(left, is_event_log)) return recover_logs(left, found);
  if (left.size() > 1)
    throw InputError(std::ranges::find_if_not(left, is_event_log)->string(),
                     "is not an event log; give event logs only, or one unfinished session alone");
  return recover_session_file(left.front(), found);
}

}  // namespace

void add_recover(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<RecoverArguments>(
      app, code, "recover", "save what a killed recorder left, into a new session", recover);
  verb.add_option("log", a.left,
                  "session.h5.trilog, or several that were recorded apart; session.h5 alone stands for its "
                  "log. Of version "
                  "0.4.0 session.h5.partial")
      ->required();
  verb.add_option("-o,--output", a.output, "the new session; by default the name without .trilog");
  add_force(verb, a.force);
  add_json(verb, a.json);
}

}  // namespace trilat
