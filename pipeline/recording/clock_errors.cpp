// SPDX-License-Identifier: MIT
#include "pipeline/recording/clock_errors.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "evaluators/metrics/share.h"
#include "pipeline/recording/clock_methods.h"
#include "pipeline/recording/processing_time.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr double kSigmas = 4.0;
// Those that say when a frame was sent; the sensor's ticks say when it was exposed.
constexpr auto kQueueMethods = static_cast<std::size_t>(ClockMethod::corrected_ticks);

struct FitShares {
  double sigma_s = 0.0, bound_s = 0.0, within = 0.0, used = 0.0;
  bool fitted = false;
};

// When the server takes frames out of its queues.
struct ServerWay {
  const char* name;
  bool in_frames;
};
constexpr std::array<ServerWay, 2> kServerWays{{{"as they come", false}, {"once a frame of its own", true}}};

// Errors of one sensor's machine in one run.
struct TrialErrors {
  std::vector<std::vector<double>> by_method_s;
  std::vector<std::array<QueueCounts, kServerWays.size()>> queues;  // by method
  FitShares fit;
};

FitShares shares_of(const ClockTrial& trial, const std::vector<double>& errors_s) {
  const AgentClock clock = fit_agent_clock(trial.exchanges);
  FitShares fit;
  if (clock.exchanges_used == 0) return fit;
  fit.fitted = true;
  fit.sigma_s = 1e-9 * static_cast<double>(clock.sigma_ns());
  fit.bound_s = 1e-9 * static_cast<double>(clock.bound_ns);
  const double limit_s = fit.bound_s + kSigmas * fit.sigma_s;
  const auto within = std::ranges::count_if(errors_s, [&](double e) { return std::abs(e) <= limit_s; });
  fit.within = static_cast<double>(within) / static_cast<double>(errors_s.size());
  fit.used = static_cast<double>(clock.exchanges_used) / static_cast<double>(clock.exchanges);
  return fit;
}

std::array<QueueCounts, kServerWays.size()> queue_counts(const RecordingSpec& spec, const ClockTrial& trial,
                                                         const std::vector<double>& errors_s) {
  std::array<QueueCounts, kServerWays.size()> counts;
  for (std::size_t w = 0; w < counts.size(); ++w) {
    const double server_frame_s = kServerWays[w].in_frames ? 1.0 / spec.rate_hz : 0.0;
    counts[w] =
        run_queue(trial.frames, errors_s, {duration_from_s(spec.late_s), duration_from_s(server_frame_s)});
  }
  return counts;
}

TrialErrors measure_trial(const RecordingSpec& spec, const NetworkSpec& network, std::size_t item) {
  const ClockTrial trial = simulate_clocks(spec, network, item / spec.sensors, item % spec.sensors);
  TrialErrors errors;
  for (std::size_t m = 0; m < clock_method_names().size(); ++m)
    errors.by_method_s.push_back(clock_errors_s(trial, static_cast<ClockMethod>(m)));
  for (std::size_t m = 0; m < kQueueMethods; ++m)
    errors.queues.push_back(queue_counts(spec, trial, errors.by_method_s[m]));
  errors.fit = shares_of(trial, errors.by_method_s[static_cast<std::size_t>(ClockMethod::corrected)]);
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

ClockErrorRow row_of(const NetworkSpec& network, std::size_t method, const std::vector<TrialErrors>& trials) {
  ClockErrorRow row;
  row.network = network.name;
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

QueueRow queue_row_of(const NetworkSpec& network, std::size_t method, std::size_t way,
                      const std::vector<TrialErrors>& trials) {
  QueueRow row{network.name, clock_method_names()[method], kServerWays[way].name, {}};
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

ClockFitRow fit_row_of(const NetworkSpec& network, const std::vector<TrialErrors>& trials) {
  FitShares sum{0.0, 0.0, 0.0, 0.0, false};
  double count = 0.0;
  for (const TrialErrors& trial : trials) {
    if (!trial.fit.fitted) continue;
    count += 1.0;
    sum.sigma_s += trial.fit.sigma_s;
    sum.bound_s += trial.fit.bound_s;
    sum.within += trial.fit.within;
    sum.used += trial.fit.used;
  }
  if (count == 0.0) return {network.name};
  return {network.name, sum.sigma_s / count, sum.bound_s / count, sum.within / count, sum.used / count};
}

std::string clock_item(std::size_t network) { return fmt::format("clocks/network-{}", network); }

// The rows of one network, a method each, and that of the fit.
Json measure_network(const RecordingSpec& spec, const NetworkSpec& network, const Watch& watch) {
  std::vector<TrialErrors> trials(spec.runs * spec.sensors);
  std::atomic<std::size_t> done{0};
  parallel_for_index(trials.size(), 1, [&](std::size_t item) {
    watch.check();
    trials[item] = measure_trial(spec, network, item);
    watch.tell(static_cast<double>(++done) / static_cast<double>(trials.size()));
  });
  Json json{
      {"rows", Json::array()}, {"fit", json_of(fit_row_of(network, trials))}, {"queues", Json::array()}};
  for (std::size_t m = 0; m < clock_method_names().size(); ++m)
    json["rows"].push_back(json_of(row_of(network, m, trials)));
  for (std::size_t m = 0; m < kQueueMethods; ++m)
    for (std::size_t way = 0; way < kServerWays.size(); ++way)
      json["queues"].push_back(json_of(queue_row_of(network, m, way, trials)));
  return json;
}

// The beginning of the server's first frame not before `received_ns`.
std::int64_t next_server_frame_ns(std::int64_t received_ns, std::int64_t length_ns) {
  if (length_ns == 0) return received_ns;
  return (received_ns + length_ns - 1) / length_ns * length_ns;
}

}  // namespace

std::vector<Item> clock_items(const RecordingSpec& spec) {
  std::vector<Item> items;
  for (std::size_t n = 0; n < spec.networks.size(); ++n)
    items.push_back({clock_item(n), 1.0, [spec, n](const std::filesystem::path&, const Watch& watch) {
                       return measure_network(spec, spec.networks[n], watch);
                     }});
  return items;
}

ClockErrorResults read_clocks(const RecordingSpec& spec, const Outcomes& outcomes) {
  ClockErrorResults results;
  for (std::size_t n = 0; n < spec.networks.size(); ++n) {
    const Outcome& outcome = outcomes.at(clock_item(n));
    const Json json = outcome.json;
    JsonObject object(json, outcome.place(), "");
    for (ClockErrorRow& row : read_list<ClockErrorRow>(object, "rows"))
      results.rows.push_back(std::move(row));
    results.fits.push_back(read_as<ClockFitRow>(object.object("fit")));
    for (QueueRow& row : read_list<QueueRow>(object, "queues")) results.queues.push_back(std::move(row));
  }
  return results;
}

QueueCounts run_queue(const std::vector<TrialFrame>& frames, const std::vector<double>& errors_s,
                      const QueueRule& rule) {
  QueueCounts counts;
  std::int64_t free_ns = 0;  // when the server can take the next one
  for (std::size_t f = 0; f < frames.size(); ++f) {
    ++counts.came;
    if (!std::isfinite(errors_s[f])) {
      ++counts.untimed;
      continue;
    }
    const std::int64_t now_ns =
        std::max(free_ns, next_server_frame_ns(frames[f].received.ns, rule.server_frame.ns));
    const std::int64_t age_ns = now_ns - frames[f].sent.ns - duration_from_s(errors_s[f]).ns;
    if (age_ns > rule.late.ns) {
      ++counts.too_late;
    } else if (age_ns < -rule.late.ns) {
      ++counts.too_early;
    } else {
      ++counts.taken;
      free_ns = now_ns + rule.server_frame.ns;
    }
  }
  return counts;
}

}  // namespace trilat
