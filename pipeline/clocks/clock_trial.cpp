// SPDX-License-Identifier: MIT
#include "pipeline/clocks/clock_trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "datasets/base/error.h"
#include "datasets/base/units.h"
#include "datasets/session/clock/agent_clock.h"
#include "datasets/session/clock/true_clocks.h"

namespace trilat {
namespace {

constexpr double kNoTime_s = kNaN;
constexpr std::uint64_t kBlock = 4096;

// Delays of the answers, by when they were received.
class WayBack {
 public:
  WayBack(std::span<const ClockExchange> exchanges, const auto& host_from_agent) {
    for (const ClockExchange& e : exchanges)
      delays_.push_back({e.t4_ns, std::max<std::int64_t>(0, e.t4_ns - host_from_agent({e.t3_ns}).ns)});
    std::ranges::sort(delays_, {}, &Delay::received_ns);
  }
  Duration at(HostTime t) const {
    auto next = std::ranges::lower_bound(delays_, t.ns, {}, &Delay::received_ns);
    if (next == delays_.end() ||
        (next != delays_.begin() && t.ns - (next - 1)->received_ns < next->received_ns - t.ns))
      --next;
    return {next->delay_ns};
  }

 private:
  struct Delay {
    std::int64_t received_ns, delay_ns;
  };
  std::vector<Delay> delays_;
};

// The server's view: D and E of equation 21.
struct PrintedExchange {
  std::int64_t delay_ns, error_ns;
};

PrintedExchange printed_exchange(const ClockExchange& e) {
  return {((e.t4_ns - e.t1_ns) - (e.t3_ns - e.t2_ns)) / 2, ((-e.t2_ns + e.t1_ns) + (e.t4_ns - e.t3_ns)) / 2};
}

double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

// `error_ns` of each frame.
template <typename ErrorNs>
std::vector<double> of_each_frame(const ClockTrial& trial, const ErrorNs& error_ns) {
  std::vector<double> errors_s;
  for (const TrialFrame& f : trial.frames) errors_s.push_back(seconds(error_ns(f)));
  return errors_s;
}

std::vector<double> without_exchanges(const ClockTrial& trial) {
  return of_each_frame(trial, [](const TrialFrame& f) { return f.stamp.arrival_ns - f.sent.ns; });
}

std::vector<double> by_first_exchange(const ClockTrial& trial) {
  const std::int64_t error_ns = printed_exchange(trial.exchanges.front()).error_ns;
  return of_each_frame(trial, [&](const TrialFrame& f) { return f.stamp.arrival_ns + error_ns - f.sent.ns; });
}

// Equation 22 by the latest exchange that the server had when it received the frame, against the time that
// the client or the server has.
template <typename TrueNs>
std::vector<double> as_printed_against(const ClockTrial& trial, const TrueNs& true_ns) {
  std::vector<double> errors_s;
  std::size_t known = 0;
  for (const TrialFrame& f : trial.frames) {
    while (known < trial.exchanges.size() && trial.exchanges[known].t4_ns <= f.received.ns) ++known;
    if (known == 0) {
      errors_s.push_back(kNoTime_s);
      continue;
    }
    const PrintedExchange latest = printed_exchange(trial.exchanges[known - 1]);
    errors_s.push_back(seconds(f.received.ns - latest.delay_ns - latest.error_ns - true_ns(f)));
  }
  return errors_s;
}

std::vector<double> as_printed(const ClockTrial& trial) {
  return as_printed_against(trial, [](const TrialFrame& f) { return f.sent.ns; });
}

std::vector<double> as_printed_on_client(const ClockTrial& trial) {
  return as_printed_against(trial, [](const TrialFrame& f) { return f.stamp.arrival_ns; });
}

std::vector<double> by_live_clock(const ClockTrial& trial) {
  const LiveClock clock(trial.exchanges);
  return of_each_frame(trial, [&](const TrialFrame& f) { return (clock({f.stamp.arrival_ns}) - f.sent).ns; });
}

std::vector<double> by_fit(const ClockTrial& trial) {
  if (!trial.is_exact) return std::vector<double>(trial.frames.size(), kNoTime_s);
  return of_each_frame(
      trial, [&](const TrialFrame& f) { return (trial.clock.agent({f.stamp.arrival_ns}) - f.sent).ns; });
}

std::vector<double> by_ticks(const ClockTrial& trial) {
  if (!trial.is_exact) return std::vector<double>(trial.frames.size(), kNoTime_s);
  return of_each_frame(trial, [&](const TrialFrame& f) { return (trial.clock(f.stamp) - f.exposure).ns; });
}

struct MethodRow {
  const char* name;
  std::vector<double> (*errors_s)(const ClockTrial&);
};

// The methods in the order of ClockMethod.
constexpr std::array<MethodRow, 7> kMethods{{{"none", without_exchanges},
                                             {"one exchange at the start", by_first_exchange},
                                             {"as printed, for the server's clock", as_printed},
                                             {"as printed, on the client's clock", as_printed_on_client},
                                             {"corrected, causal", by_live_clock},
                                             {"corrected, offline", by_fit},
                                             {"corrected, by the sensor's ticks", by_ticks}}};

// The beginning of the server's first frame not before `received_ns`.
std::int64_t next_server_frame_ns(std::int64_t received_ns, std::int64_t length_ns) {
  if (length_ns == 0) return received_ns;
  return (received_ns + length_ns - 1) / length_ns * length_ns;
}

}  // namespace

ClockTrial read_clock_trial(const SessionReader& session, std::size_t sensor) {
  const SensorDescription& description = session.header().sensors.at(sensor);
  ClockTrial trial;
  trial.exchanges = session.clock_exchanges(sensor);
  if (trial.exchanges.empty())
    throw InputError(session.path().string() + ":/sensors/" + description.name,
                     "has no clock exchanges: it was recorded on the recorder's own computer, or converted. "
                     "Sensors of agents have them (docs/how-to/agents.md)");
  std::ranges::stable_sort(trial.exchanges, {}, &ClockExchange::t1_ns);
  trial.clock = fit_sensor_clock(session, sensor);
  const std::optional<TrueClocks> truth = true_clocks(session, description.name);
  trial.is_exact = truth.has_value();
  const auto host_from_agent = [&](AgentTime t) {
    return truth ? truth->host_from_agent(t) : trial.clock.agent(t);
  };
  const WayBack way(trial.exchanges, host_from_agent);
  const SensorCounts& counts = session.counts(sensor);
  const FrameStream stream = counts.body_frames > 0 ? FrameStream::bodies : FrameStream::depth;
  const std::uint64_t frames = counts.body_frames > 0 ? counts.body_frames : counts.depth_frames;
  HostTime before;
  for (std::uint64_t first = 0; first < frames; first += kBlock)
    for (const FrameStamp& stamp : session.stamps(sensor, stream, first, std::min(kBlock, frames - first))) {
      const HostTime exposure =
          truth ? truth->host_from_sensor(device_time(description, stamp)) : trial.clock(stamp);
      const HostTime sent = host_from_agent({stamp.arrival_ns});
      before = std::max(before, sent + way.at(sent));
      trial.frames.push_back({stamp, exposure, sent, before});
    }
  return trial;
}

const std::vector<std::string>& clock_method_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const MethodRow& row : kMethods) list.push_back(row.name);
    return list;
  }();
  return names;
}

std::vector<double> clock_errors_s(const ClockTrial& trial, ClockMethod method) {
  return kMethods.at(static_cast<std::size_t>(method)).errors_s(trial);
}

QueueCounts run_queue(const std::vector<TrialFrame>& frames, const std::vector<double>& errors_s,
                      const QueueRule& rule) {
  QueueCounts counts;
  std::int64_t free_ns = std::numeric_limits<std::int64_t>::min();  // when the server can take the next one
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
