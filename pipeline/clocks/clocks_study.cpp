// SPDX-License-Identifier: MIT
#include "pipeline/clocks/clocks_study.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <set>
#include <span>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/results/figure.h"
#include "datasets/results/simulation_assumptions.h"
#include "evaluators/metrics/statistics.h"
#include "pipeline/clocks/clock_trial.h"
#include "pipeline/study/parallel.h"
#include "pipeline/study/results_run.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kItem = "clocks/all";
constexpr double kSigmas = 4.0;
// Methods that say when a frame was sent; the last, by the sensor's ticks, says when it was exposed.
constexpr auto kQueueMethods = static_cast<std::size_t>(ClockMethod::ticks);

// Moments at which the server takes frames out of its queues; a server's own frame is as long as the limit.
struct DequeueRule {
  const char* name;
  bool in_frames;
};
constexpr std::array<DequeueRule, 2> kDequeueRules{
    {{"as they come", false}, {"once a frame of its own", true}}};

struct Recording {
  std::string take;
  fs::path session;
};

// Each session once, under a name of its own.
std::vector<Recording> recordings_of(const Campaign& campaign) {
  std::vector<Recording> recordings;
  std::set<std::string> names;
  std::set<fs::path> sessions;
  const auto add = [&](const std::string& name, const fs::path& session) {
    if (!session.empty() && sessions.insert(session.lexically_normal()).second)
      recordings.push_back({unused_name(name, names), session});
  };
  for (const Take& take : campaign.takes) add(take.id, take.session);
  const auto add_other = [&](const fs::path& session) {
    const fs::path inside = campaign.folder.empty() ? session : fs::relative(session, campaign.folder);
    add(inside.stem() == "session" ? inside.parent_path().generic_string() : inside.generic_string(),
        session);
  };
  if (campaign.wand) add_other(campaign.wand->session);
  for (const StatedDistances& stated : campaign.stated_distances) add_other(stated.session);
  for (const FlatWall& wall : campaign.walls) add_other(wall.session);
  if (recordings.empty())
    throw InputError("campaign \"" + campaign.name + '"',
                     "has no take with a session, whose clocks could be looked at");
  return recordings;
}

// One sensor's clock in one recording, and what each method makes of its frames.
struct ClockTrialErrors {
  std::string take, sensor;
  std::vector<std::vector<double>> by_method_s;
  std::vector<std::array<QueueCounts, kDequeueRules.size()>> queues;  // by method
  Numbers machine;
  NumberKey with_unit(const NumberKey& key) const { return key.with({.group = sensor, .take = take}); }
};

std::uint64_t count_below(std::span<const double> errors_s, double limit_s) {
  return static_cast<std::uint64_t>(
      std::ranges::count_if(errors_s, [&](double e) { return std::abs(e) < limit_s; }));
}

// How the offline fit states the clock, and how long frames take from their exposure to the recorder.
Numbers machine_numbers(const ClockTrial& trial, const ClockTrialErrors& errors, double late_s) {
  const AgentClock& clock = trial.clock.agent;
  const std::size_t frames = trial.frames.size();
  Numbers numbers;
  const auto add = [&](const char* measure, const char* statistic, double value, std::uint64_t n) {
    numbers.add({errors.with_unit({.measure = measure, .statistic = statistic}), value, kNaN, kNaN, n});
  };
  const double sigma_s = 1e-9 * static_cast<double>(clock.sigma_ns()),
               bound_s = 1e-9 * static_cast<double>(clock.bound_ns);
  add("clock_fit", "share_used", share_of(clock.exchanges_used, clock.exchanges), clock.exchanges);
  add("clock_fit", "sigma", sigma_s, clock.exchanges);
  add("clock_fit", "bound", bound_s, clock.exchanges);
  add("clock_fit", "bend", clock.deviation.seconds(), clock.exchanges);
  const std::vector<double>& offline_s = errors.by_method_s[static_cast<std::size_t>(ClockMethod::offline)];
  const double limit_s = bound_s + kSigmas * sigma_s;
  const auto within = std::ranges::count_if(offline_s, [&](double e) { return std::abs(e) <= limit_s; });
  if (trial.is_exact)
    add("clock_fit", "share_within_bound", share_of(static_cast<std::uint64_t>(within), frames), frames);
  // without a stated latency the time from exposure is not known
  if (trial.clock.latency.ns <= 0) return numbers;
  std::vector<double> latency_s;
  for (const TrialFrame& f : trial.frames) latency_s.push_back((f.received - f.exposure).seconds());
  const auto in_time = std::ranges::count_if(latency_s, [&](double s) { return s <= late_s; });
  add("latency", "share_in_time", share_of(static_cast<std::uint64_t>(in_time), frames), frames);
  const auto q = quantiles_of(latency_s, {0.5, 0.99});
  add("latency", "median", q[0], frames);
  add("latency", "p99", q[1], frames);
  return numbers;
}

ClockTrialErrors measure_trial(const ClockTrial& trial, std::string take, std::string sensor, double late_s) {
  ClockTrialErrors errors{std::move(take), std::move(sensor), {}, {}, {}};
  for (std::size_t m = 0; m < clock_method_names().size(); ++m)
    errors.by_method_s.push_back(clock_errors_s(trial, static_cast<ClockMethod>(m)));
  for (std::size_t m = 0; m < kQueueMethods; ++m) {
    auto& counts = errors.queues.emplace_back();
    for (std::size_t w = 0; w < counts.size(); ++w)
      counts[w] =
          run_queue(trial.frames, errors.by_method_s[m],
                    {duration_from_s(late_s), duration_from_s(kDequeueRules[w].in_frames ? late_s : 0.0)});
  }
  errors.machine = machine_numbers(trial, errors, late_s);
  return errors;
}

// Adds a share with its interval over the units: clusters of which each has `part` of `whole`.
void add_share(const NumberKey& key, const std::vector<double>& part, const std::vector<double>& whole,
               std::uint64_t n, Numbers& numbers) {
  const ShareEstimate share = estimate_share(part, whole);
  numbers.add({key, share.value, share.low, share.high, n, share.clusters});
}

// The queue's frames by one method and one way of the server; nothing where no frame has a time.
void add_queue(std::size_t method, std::size_t way, const std::vector<ClockTrialErrors>& trials,
               Numbers& numbers) {
  const NumberKey key{
      .condition = kDequeueRules[way].name, .method = clock_method_names()[method], .measure = "queue"};
  QueueCounts all;
  std::vector<double> taken, came;
  for (const ClockTrialErrors& trial : trials) {
    const QueueCounts& counts = trial.queues[method][way];
    all.came += counts.came;
    all.untimed += counts.untimed;
    all.too_early += counts.too_early;
    all.too_late += counts.too_late;
    all.taken += counts.taken;
    taken.push_back(static_cast<double>(counts.taken));
    came.push_back(static_cast<double>(counts.came));
  }
  if (all.untimed == all.came) return;
  for (const ClockTrialErrors& trial : trials) {
    const QueueCounts& counts = trial.queues[method][way];
    numbers.add({trial.with_unit(key.with({.statistic = "taken"})), share_of(counts.taken, counts.came), kNaN,
                 kNaN, counts.came});
  }
  for (const auto& [statistic, count] : {std::pair{"came", all.came},
                                         {"untimed", all.untimed},
                                         {"too_early", all.too_early},
                                         {"too_late", all.too_late}})
    numbers.add({key.with({.statistic = statistic}), share_of(count, all.came), kNaN, kNaN, count});
  add_share(key.with({.statistic = "taken"}), taken, came, all.taken, numbers);
}

// One sensor of one recording.
struct SensorOf {
  std::size_t recording, sensor;
};

struct ReadColumn {
  std::vector<std::optional<SessionReader>> sessions;  // none where it cannot be read
  std::vector<SensorOf> sensors;
  std::vector<std::string> failed;
  bool simulated = false;
};

ReadColumn open_all(const std::vector<Recording>& recordings) {
  ReadColumn opened;
  opened.sessions.resize(recordings.size());
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    try {
      const SessionReader& session = opened.sessions[r].emplace(recordings[r].session);
      opened.simulated |= session.header().simulated;
      for (std::size_t s = 0; s < session.header().sensors.size(); ++s) opened.sensors.push_back({r, s});
    } catch (const InputError& error) {
      opened.failed.push_back(recordings[r].take + ": " + error.problem());
    }
  }
  return opened;
}

ClocksSummary measure(const ClocksSpec& spec, const Campaign& campaign, const RunControl& control) {
  const std::vector<Recording> recordings = recordings_of(campaign);
  ReadColumn opened = open_all(recordings);
  std::vector<std::optional<ClockTrialErrors>> found(opened.sensors.size());
  std::vector<std::string> problems(opened.sensors.size());
  std::atomic<std::size_t> done{0};
  parallel_for_index(opened.sensors.size(), 1, [&](std::size_t k) {
    control.check();
    const auto [recording, sensor] = opened.sensors[k];
    const SessionReader& session = *opened.sessions[recording];
    try {
      found[k] = measure_trial(read_clock_trial(session, sensor), recordings[recording].take,
                               session.header().sensors[sensor].name, spec.late_s);
    } catch (const InputError& error) {
      problems[k] =
          recordings[recording].take + ", " + session.header().sensors[sensor].name + ": " + error.problem();
    }
    control.report(static_cast<double>(++done) / static_cast<double>(found.size()));
  });
  ClocksSummary summary;
  std::vector<ClockTrialErrors> trials;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found[k])
      trials.push_back(std::move(*found[k]));
    else
      opened.failed.push_back(problems[k]);
  }
  if (trials.empty()) throw InputError("campaign \"" + campaign.name + '"', opened.failed.front());
  summary.study = spec.name;
  summary.paper = name_of(spec.paper);
  summary.campaign = campaign.name;
  summary.simulated = campaign.simulated || opened.simulated;
  summary.recordings = recordings.size();
  summary.late_s = spec.late_s;
  summary.failed = std::move(opened.failed);
  for (std::size_t m = 0; m < clock_method_names().size(); ++m) {
    std::vector<UnitErrors> units;
    for (const ClockTrialErrors& trial : trials)
      units.push_back({trial.take, trial.sensor, trial.by_method_s[m]});
    add_clock_errors(clock_method_names()[m], units, summary.numbers);
  }
  for (std::size_t m = 0; m < kQueueMethods; ++m)
    for (std::size_t way = 0; way < kDequeueRules.size(); ++way) add_queue(m, way, trials, summary.numbers);
  for (const ClockTrialErrors& trial : trials) summary.numbers.add(trial.machine);
  summary.rows = summary.numbers.all().size();
  return summary;
}

}  // namespace

ItemCounts run_clocks(const ClocksSpec& spec, const Campaign& campaign, const fs::path& folder,
                      const StudyOptions& options) {
  std::vector<fs::path> files;
  std::vector<RecordingFile> inputs;
  for (const Recording& recording : recordings_of(campaign)) {
    files.push_back(recording.session);
    inputs.push_back({recording.take, "session", recording.session});
  }
  const Json resolved = json_of(spec);
  const WatchedFiles watched(files);  // from before they are read
  HashCache hashes;
  hashes.load(folder);
  ResultsRun run(folder, {{kItem, 1.0}}, options);
  run.find_keys([&](std::size_t, const RunControl& control) {
    return key_of({{"study", resolved},
                   {"simulated", campaign.simulated},
                   {"inputs", hashed_inputs(inputs, hashes, control.stop_requested)}});
  });
  const Json manifest = manifest_of(resolved, {{"campaign", campaign.name},
                                               {"simulated", campaign.simulated},
                                               {"inputs", hashed_inputs(inputs, hashes, {})}});
  if (run.is_finished(manifest)) return run.tally();
  run.begin(manifest);
  if (run.is_whole()) hashes.save(folder);
  run.compute([&](std::size_t, const fs::path& into, const RunControl& control) {
    const ClocksSummary summary = measure(spec, campaign, control);
    watched.check();
    write_numbers(into, summary.numbers);
    return json_of(summary);
  });
  if (run.is_whole())
    run.publish_results(manifest, [&](const fs::path& into) {
      const ItemResult& outcome = run.outcome(0);
      auto summary = read_as<ClocksSummary>(outcome.json, outcome.place());
      summary.numbers = read_numbers(outcome.folder, summary.rows);
      summary.campaign = campaign.name;  // which is not in the item's key
      const std::vector<SimulationAssumption> simulator = read_simulation_assumptions(campaign.folder);
      if (!simulator.empty()) write_simulation_assumptions(into, simulator);
      store_tables(into, clocks_tables(summary));
      write_json_file(into, StoredFigures{});
      write_results(into, summary);
    });
  return run.tally();
}

void add_clock_errors(const std::string& method, const std::vector<UnitErrors>& units, Numbers& numbers) {
  const NumberKey key{.method = method, .measure = "clock_error"};
  std::vector<double> all_s, below_2ms, below_4ms, asked;
  std::uint64_t frames = 0, wholly = 0;
  for (const UnitErrors& unit : units) {
    for (double error_s : unit.error_s)
      if (std::isfinite(error_s)) all_s.push_back(std::abs(error_s));
    frames += unit.error_s.size();
  }
  if (all_s.empty()) return;
  for (const UnitErrors& unit : units) {
    const std::uint64_t good = count_below(unit.error_s, kTimeRanges[0].below_s),
                        fair = count_below(unit.error_s, kTimeRanges[1].below_s), of = unit.error_s.size();
    below_2ms.push_back(static_cast<double>(good));
    below_4ms.push_back(static_cast<double>(fair));
    asked.push_back(static_cast<double>(of));
    wholly += fair == of;
    const NumberKey own = key.with({.group = unit.sensor, .take = unit.take});
    for (const auto& [name, count] : {std::pair{kTimeRanges[0].share, good}, {kShareBelow4ms, fair}})
      numbers.add({own.with({.statistic = name}), share_of(count, of), kNaN, kNaN, of});
  }
  const auto add = [&](const char* statistic, double value, std::uint64_t n) {
    numbers.add({key.with({.statistic = statistic}), value, kNaN, kNaN, n});
  };
  add_share(key.with({.statistic = kTimeRanges[0].share}), below_2ms, asked, frames, numbers);
  std::uint64_t before = count_below(all_s, kTimeRanges[0].below_s);
  for (const TimeRange& range : std::span(kTimeRanges).subspan(1)) {
    const std::uint64_t below = count_below(all_s, range.below_s);
    add(range.share, share_of(below - before, frames), frames);
    before = below;
  }
  add_share(key.with({.statistic = kShareBelow4ms}), below_4ms, asked, frames, numbers);
  add("share_of_units_below_4ms", share_of(wholly, units.size()), units.size());
  const auto q = quantiles_of(all_s, {0.5, 0.95, 0.99, 0.999, 1.0});
  constexpr std::array kNames{"median", "p95", "p99", "p999", "max"};
  for (std::size_t k = 0; k < kNames.size(); ++k) add(kNames[k], q[k], all_s.size());
}

}  // namespace trilat
