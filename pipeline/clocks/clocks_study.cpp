// SPDX-License-Identifier: MIT
#include "pipeline/clocks/clocks_study.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/results/declared_parameters.h"
#include "datasets/results/figure.h"
#include "evaluators/metrics/statistics.h"
#include "pipeline/claims/paper_claims.h"
#include "pipeline/clocks/clock_trial.h"
#include "pipeline/clocks/clocks_tables.h"
#include "pipeline/study/parallel.h"
#include "pipeline/study/results_run.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kItem = "clocks/all";
constexpr double kSigmas = 4.0;
// Those that say when a frame was sent; the sensor's ticks say when it was exposed.
constexpr auto kQueueMethods = static_cast<std::size_t>(ClockMethod::ticks);

void tell(Settings& s, ClocksSpec& spec) {
  s("late_s", spec.late_s, {0.0, 10.0},
    "the most by which a frame may be late for the paper's queue, and from its exposure to count as in time");
}

// Moments at which the server takes frames out of its queues; a server's own frame is as long as the limit.
struct ServerWay {
  const char* name;
  bool in_frames;
};
constexpr std::array<ServerWay, 2> kServerWays{{{"as they come", false}, {"once a frame of its own", true}}};

struct Recording {
  std::string take;
  fs::path session;
};

std::vector<Recording> recordings_of(const Campaign& campaign) {
  std::vector<Recording> recordings;
  for (const Take& take : campaign.takes)
    if (!take.session.empty()) recordings.push_back({take.id, take.session});
  std::vector<fs::path> others;
  if (campaign.wand) others.push_back(campaign.wand->session);
  for (const StatedDistances& stated : campaign.stated_distances) others.push_back(stated.session);
  for (const FlatWall& wall : campaign.walls) others.push_back(wall.session);
  for (const fs::path& session : others) {
    const fs::path inside = campaign.folder.empty() ? session : fs::relative(session, campaign.folder);
    recordings.push_back(
        {inside.stem() == "session" ? inside.parent_path().generic_string() : inside.generic_string(),
         session});
  }
  if (recordings.empty())
    throw InputError("campaign \"" + campaign.name + '"',
                     "has no take with a session, whose clocks could be looked at");
  return recordings;
}

// Errors of one sensor's clock in one recording.
struct TrialErrors {
  std::vector<std::vector<double>> by_method_s;
  std::vector<std::array<QueueCounts, kServerWays.size()>> queues;  // by method
  MachineRow machine;
};

MachineRow machine_of(const ClockTrial& trial, const std::vector<double>& offline_s, double late_s) {
  const AgentClock& clock = trial.clock.agent;
  MachineRow row;
  row.exchanges = clock.exchanges;
  row.frames = trial.frames.size();
  row.exchanges_used_share = static_cast<double>(clock.exchanges_used) / static_cast<double>(clock.exchanges);
  row.offset_sigma_s = 1e-9 * static_cast<double>(clock.sigma_ns());
  row.offset_bound_s = 1e-9 * static_cast<double>(clock.bound_ns);
  row.bend_s = clock.bend.seconds();
  const double limit_s = row.offset_bound_s + kSigmas * row.offset_sigma_s;
  const auto within = std::ranges::count_if(offline_s, [&](double e) { return std::abs(e) <= limit_s; });
  if (trial.is_exact) row.within_bound_share = static_cast<double>(within) / static_cast<double>(row.frames);
  if (trial.clock.latency.ns <= 0) return row;  // nobody says how long a frame takes to its computer
  std::vector<double> latency_s;
  for (const TrialFrame& f : trial.frames) latency_s.push_back((f.received - f.exposure).seconds());
  const auto in_time = std::ranges::count_if(latency_s, [&](double s) { return s <= late_s; });
  row.in_time_share = static_cast<double>(in_time) / static_cast<double>(row.frames);
  const TimeSpread spread = spread_times(std::move(latency_s));
  row.latency_median_s = spread.median_s;
  row.latency_p99_s = spread.p99_s;
  return row;
}

TrialErrors measure_trial(const ClockTrial& trial, double late_s) {
  TrialErrors errors;
  for (std::size_t m = 0; m < clock_method_names().size(); ++m)
    errors.by_method_s.push_back(clock_errors_s(trial, static_cast<ClockMethod>(m)));
  for (std::size_t m = 0; m < kQueueMethods; ++m) {
    auto& counts = errors.queues.emplace_back();
    for (std::size_t w = 0; w < counts.size(); ++w)
      counts[w] =
          run_queue(trial.frames, errors.by_method_s[m],
                    {duration_from_s(late_s), duration_from_s(kServerWays[w].in_frames ? late_s : 0.0)});
  }
  errors.machine =
      machine_of(trial, errors.by_method_s[static_cast<std::size_t>(ClockMethod::offline)], late_s);
  return errors;
}

ClockUnit count_errors(const std::vector<double>& errors_s) {
  ClockUnit unit{errors_s.size()};
  for (double error_s : errors_s) {
    unit.answered += std::isfinite(error_s);
    unit.below_2ms += std::abs(error_s) < kTimeEdges_s[1];
    unit.below_4ms += std::abs(error_s) < kTimeEdges_s[2];
  }
  return unit;
}

ClockErrorRow row_of(std::size_t method, const std::vector<TrialErrors>& trials) {
  ClockErrorRow row;
  row.method = clock_method_names()[method];
  std::vector<double> all_s, good, asked;
  for (const TrialErrors& trial : trials) {
    const std::vector<double>& errors_s = trial.by_method_s[method];
    const ClockUnit unit = row.units.emplace_back(count_errors(errors_s));
    row.asked += unit.asked;
    for (double error_s : errors_s) all_s.push_back(std::abs(error_s));
    good.push_back(static_cast<double>(unit.below_2ms));
    asked.push_back(static_cast<double>(unit.asked));
  }
  row.error = spread_times(std::move(all_s));
  if (row.error.n == 0) return row;
  const ShareEstimate share = estimate_share(good, asked);
  row.below_2ms = share.value;
  row.below_2ms_low = share.low;
  row.below_2ms_high = share.high;
  return row;
}

QueueRow queue_row_of(std::size_t method, std::size_t way, const std::vector<TrialErrors>& trials) {
  QueueRow row{clock_method_names()[method], kServerWays[way].name, {}};
  std::vector<double> taken, came;
  for (const TrialErrors& trial : trials) {
    const QueueCounts& counts = trial.queues[method][way];
    row.counts.came += counts.came;
    row.counts.untimed += counts.untimed;
    row.counts.too_early += counts.too_early;
    row.counts.too_late += counts.too_late;
    row.counts.taken += counts.taken;
    row.units.push_back({counts.came, counts.taken});
    taken.push_back(static_cast<double>(counts.taken));
    came.push_back(static_cast<double>(counts.came));
  }
  const ShareEstimate share = estimate_share(taken, came);
  row.taken_low = share.low;
  row.taken_high = share.high;
  return row;
}

// One sensor of one recording.
struct SensorOf {
  std::size_t recording, sensor;
};

struct Opened {
  std::vector<std::optional<SessionReader>> sessions;  // none where it cannot be read
  std::vector<SensorOf> sensors;
  std::vector<std::string> left_out;
  bool simulated = false;
};

Opened open_all(const std::vector<Recording>& recordings) {
  Opened opened;
  opened.sessions.resize(recordings.size());
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    try {
      const SessionReader& session = opened.sessions[r].emplace(recordings[r].session);
      opened.simulated |= session.header().simulated;
      for (std::size_t s = 0; s < session.header().sensors.size(); ++s) opened.sensors.push_back({r, s});
    } catch (const InputError& error) {
      opened.left_out.push_back(recordings[r].take + ": " + error.problem());
    }
  }
  return opened;
}

ClocksSummary measure(const ClocksSpec& spec, const Campaign& campaign, const Watch& watch) {
  const std::vector<Recording> recordings = recordings_of(campaign);
  Opened opened = open_all(recordings);
  std::vector<std::optional<TrialErrors>> found(opened.sensors.size());
  std::vector<std::string> problems(opened.sensors.size());
  std::atomic<std::size_t> done{0};
  parallel_for_index(opened.sensors.size(), 1, [&](std::size_t k) {
    watch.check();
    const auto [recording, sensor] = opened.sensors[k];
    const SessionReader& session = *opened.sessions[recording];
    try {
      found[k] = measure_trial(read_clock_trial(session, sensor), spec.late_s);
      found[k]->machine.take = recordings[recording].take;
      found[k]->machine.sensor = session.header().sensors[sensor].name;
    } catch (const InputError& error) {
      problems[k] =
          recordings[recording].take + ", " + session.header().sensors[sensor].name + ": " + error.problem();
    }
    watch.tell(static_cast<double>(++done) / static_cast<double>(found.size()));
  });
  ClocksSummary summary;
  std::vector<TrialErrors> trials;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found[k])
      trials.push_back(std::move(*found[k]));
    else
      opened.left_out.push_back(problems[k]);
  }
  if (trials.empty()) throw InputError("campaign \"" + campaign.name + '"', opened.left_out.front());
  summary.study = spec.name;
  summary.paper = name_of(spec.paper);
  summary.campaign = campaign.name;
  summary.simulated = campaign.simulated || opened.simulated;
  summary.recordings = recordings.size();
  summary.late_s = spec.late_s;
  summary.left_out = std::move(opened.left_out);
  for (std::size_t m = 0; m < clock_method_names().size(); ++m)
    if (ClockErrorRow row = row_of(m, trials); row.error.n > 0) summary.clocks.push_back(std::move(row));
  for (std::size_t m = 0; m < kQueueMethods; ++m)
    for (std::size_t way = 0; way < kServerWays.size(); ++way)
      if (QueueRow row = queue_row_of(m, way, trials); row.counts.untimed < row.counts.came)
        summary.queues.push_back(std::move(row));
  for (TrialErrors& trial : trials) summary.machines.push_back(std::move(trial.machine));
  return summary;
}

}  // namespace

ClocksSpec parse_clocks_spec(const Json& json, const std::string& place, const fs::path& folder) {
  ClocksSpec spec;
  static_cast<RecordingsStudy&>(spec) = parse_recordings_study(
      json, place, folder, name_of(StudyKind::clocks), [&](Settings& settings) { tell(settings, spec); });
  return spec;
}

Json resolved_json(const ClocksSpec& given) {
  ClocksSpec spec = given;
  return resolved_recordings_study(spec, name_of(StudyKind::clocks),
                                   [&](Settings& settings) { tell(settings, spec); });
}

ItemTally run_clocks(const ClocksSpec& spec, const Campaign& campaign, const fs::path& folder,
                     const StudyOptions& options) {
  std::vector<fs::path> files;
  std::vector<RecordingFile> inputs;
  for (const Recording& recording : recordings_of(campaign)) {
    files.push_back(recording.session);
    inputs.push_back({recording.take, "session", recording.session});
  }
  const Json resolved = resolved_json(spec);
  const WatchedFiles watched(files);  // from before they are read
  HashCache hashes;
  hashes.load(folder);
  ResultsRun run(folder, {{kItem, 1.0}}, options);
  run.find_keys([&](std::size_t, const Watch& watch) {
    return key_of({{"study", resolved},
                   {"simulated", campaign.simulated},
                   {"inputs", hashed_inputs(inputs, hashes, watch.stop_requested)}});
  });
  const Json manifest = manifest_of(resolved, {{"campaign", campaign.name},
                                               {"simulated", campaign.simulated},
                                               {"inputs", hashed_inputs(inputs, hashes, {})}});
  if (run.is_finished(manifest)) return run.tally();
  run.begin(manifest);
  if (run.is_whole()) hashes.save(folder);
  run.compute([&](std::size_t, const fs::path&, const Watch& watch) {
    const ClocksSummary summary = measure(spec, campaign, watch);
    watched.check();
    return json_of(summary);
  });
  if (run.is_whole())
    run.publish_results(manifest, [&](const fs::path& into) {
      const Outcome& outcome = run.outcome(0);
      auto summary = read_as<ClocksSummary>(JsonObject(outcome.json, outcome.place(), ""));
      summary.campaign = campaign.name;  // which is not in the item's key
      summary.claims = claims_of(summary);
      const std::vector<DeclaredParameter> simulator = read_declared_parameters(campaign.folder);
      if (!simulator.empty()) write_declared_parameters(into, simulator);
      store_tables(into, clocks_tables(summary));
      write_beside(into, StoredFigures{});
      write_results(into, summary, -1);
    });
  return run.tally();
}

TimeSpread spread_times(std::vector<double> times_s) {
  std::erase_if(times_s, [](double t) { return !std::isfinite(t); });
  TimeSpread spread;
  spread.n = times_s.size();
  for (double t : times_s) {
    const auto edge = std::upper_bound(kTimeEdges_s.begin() + 1, kTimeEdges_s.end(), t);
    ++spread.bins[static_cast<std::size_t>(edge - kTimeEdges_s.begin()) - 1];
  }
  if (times_s.empty()) return spread;
  const auto q = quantiles_of(times_s, {0.5, 0.95, 0.99, 0.999, 1.0});
  spread.median_s = q[0];
  spread.p95_s = q[1];
  spread.p99_s = q[2];
  spread.p999_s = q[3];
  spread.max_s = q[4];
  return spread;
}

}  // namespace trilat
