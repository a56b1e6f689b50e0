// SPDX-License-Identifier: MIT
#include "datasets/session/session_verify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "datasets/session/body_readings.h"
#include "datasets/session/clock/session_clock.h"

namespace trilat {
namespace {

constexpr std::uint64_t kVerifiedBlock = 1024;
constexpr std::uint64_t kDepthWeight = 20;  // a depth frame costs about as much as so many body frames
constexpr double kRestart_s = 1.0;          // by so much ticks or arrivals jump at least

struct Place {
  std::string sensor;  // file.h5:/sensors/NAME
  std::vector<Finding>* findings;
  void say(Severity severity, const std::string& part, const std::string& text,
           const std::string& affects = {}) const {
    findings->push_back({severity, sensor + part, text, affects});
  }
};

// Results that a finding can affect.
constexpr const char* kAnswers = "coverage of every study: instants near it have one sensor less";
constexpr const char* kTimes =
    "every accuracy study and calibration: sensors and truth are compared at wrong times";
constexpr const char* kPositions = "every accuracy study: wrong joint positions";
constexpr const char* kPersons = "accuracy studies with several persons: who is who is followed by these ids";
constexpr const char* kDepthUses = "wand calibration";

// Counts of odd stamps of one stream; said once.
struct StampCounts {
  std::uint64_t sequence_missing = 0, sequence_backward = 0, restarts = 0, ticks_backward = 0,
                arrival_backward = 0, gaps = 0;
  double longest_gap_s = 0.0;

  void add(const FrameStamp& a, const FrameStamp& b, const SensorDescription& sensor, double gap_periods) {
    const double step_s = (device_time(sensor, b) - device_time(sensor, a)).seconds();
    const double arrival_step_s = Duration{b.arrival_ns - a.arrival_ns}.seconds();
    const bool jumps = std::max(std::abs(step_s), std::abs(arrival_step_s)) > kRestart_s;
    if (b.sequence <= a.sequence)
      ++(jumps ? restarts : sequence_backward);
    else
      sequence_missing += static_cast<std::uint64_t>(b.sequence - a.sequence - 1);
    if (b.device_ticks <= a.device_ticks) ++ticks_backward;
    if (b.arrival_ns < a.arrival_ns) ++arrival_backward;
    if (step_s > gap_periods / sensor.nominal_rate_hz) {
      ++gaps;
      longest_gap_s = std::max(longest_gap_s, step_s);
    }
  }

  void say(const Place& place, const std::string& part) const {
    if (sequence_missing > 0)
      place.say(Severity::warning, part,
                fmt::format("{} frames are missing by their sequence numbers", sequence_missing), kAnswers);
    if (restarts > 0)
      place.say(Severity::warning, part,
                fmt::format("sequence numbers begin anew at {} places, where ticks or arrivals jump: the "
                            "sensor or its agent was restarted",
                            restarts),
                kAnswers);
    if (sequence_backward > 0)
      place.say(Severity::error, part,
                fmt::format("sequence numbers do not rise at {} places", sequence_backward), kTimes);
    if (ticks_backward > 0)
      place.say(Severity::warning, part,
                fmt::format("device ticks do not rise at {} places: the sensor's clock was restarted or "
                            "jumped; times behind are fitted anew",
                            ticks_backward),
                kTimes);
    if (arrival_backward > 0)
      place.say(Severity::warning, part, fmt::format("arrival times go back at {} places", arrival_backward),
                kTimes);
    if (gaps > 0)
      place.say(Severity::note, part,
                fmt::format("{} gaps in time, the longest {:.3f} s", gaps, longest_gap_s), kAnswers);
  }
};

void verify_stamps(const SessionReader& session, std::size_t sensor, FrameStream stream, std::uint64_t frames,
                   double gap_periods, const Place& place, const std::string& part) {
  StampCounts counts;
  std::optional<FrameStamp> last;
  for (std::uint64_t first = 0; first < frames; first += kVerifiedBlock) {
    for (const FrameStamp& stamp :
         session.stamps(sensor, stream, first, std::min(kVerifiedBlock, frames - first))) {
      if (last) counts.add(*last, stamp, session.header().sensors[sensor], gap_periods);
      last = stamp;
    }
  }
  counts.say(place, part);
}

struct BodyCounts {
  std::uint64_t frames_without = 0, not_finite = 0, odd_states = 0, without_id = 0, same_id = 0;
  BodyIdentities identities;
  StaleBodies stale;
  JointFaults joints;
  std::size_t bodies = 0;
  std::set<std::uint64_t> ids;

  void add(const BodyFrame& frame, SensorTime time) {
    identities.of(frame.bodies, (time - SensorTime{0}).seconds());
    if (frame.bodies.empty()) ++frames_without;
    std::set<std::uint64_t> here;
    for (const Body& body : frame.bodies) {
      add(body);
      stale.add(body, bodies++);
      if (!here.insert(body.tracking_id).second) ++same_id;
    }
    if (ids.size() < 10'000) ids.merge(here);
  }

  void add(const Body& body) {
    if (body.tracking_id == 0) ++without_id;
    joints.add(body);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      if (body.tracking_state[j] > 2) ++odd_states;
      if (reading_of(body, j) == JointReading::not_finite) ++not_finite;
    }
  }

  void say(const Place& place, std::uint64_t frames) {
    if (const std::size_t count = stale.finish().size(); count > 0)
      place.say(
          Severity::warning, "/bodies/position_m",
          fmt::format(
              "{} bodies repeat the one before to the last bit under new time stamps; they count as not seen",
              count),
          kAnswers);
    if (frames_without > 0)
      place.say(frames_without == frames ? Severity::warning : Severity::note, "/body_frames",
                fmt::format("{} of {} frames hold no body", frames_without, frames), kAnswers);
    if (not_finite > 0)
      place.say(
          Severity::error, "/bodies/position_m",
          fmt::format("{} tracked or inferred joints are not finite; they count as not seen", not_finite),
          kAnswers);
    if (const auto text = joints.out_of_reach_text())
      place.say(Severity::error, "/bodies/position_m", *text, kAnswers);
    if (const auto text = joints.misread_text())
      place.say(Severity::error, "/bodies/position_m", *text, kPositions);
    if (const auto text = joints.upside_down_text())
      place.say(Severity::error, "/bodies/position_m", *text, kPositions);
    if (identities.jumps() > 0)
      place.say(Severity::warning, "/bodies/tracking_id",
                fmt::format("{} times a body moves more than 1 m from one frame to the next under one id; "
                            "from there it counts as another body",
                            identities.jumps()),
                kPersons);
    if (odd_states > 0)
      place.say(Severity::error, "/bodies/tracking_state",
                fmt::format("{} states are none of 0, 1, 2", odd_states), kPositions);
    if (without_id > 0)
      place.say(Severity::warning, "/bodies/tracking_id", fmt::format("{} bodies have the id 0", without_id),
                kPersons);
    if (same_id > 0)
      place.say(Severity::error, "/bodies/tracking_id",
                fmt::format("{} bodies have the id of another in the same frame", same_id), kPersons);
    if (ids.size() > 1)
      place.say(Severity::note, "/bodies/tracking_id",
                fmt::format("{} different ids: several persons, or one who came back", ids.size()));
  }
};

void verify_bodies(const SessionReader& session, std::size_t sensor, const Place& place,
                   std::vector<double>& backward_feet, const std::function<void(std::uint64_t)>& advance) {
  const std::uint64_t frames = session.counts(sensor).body_frames;
  BodyCounts counts;
  for (std::uint64_t first = 0; first < frames; first += kVerifiedBlock) {
    const std::uint64_t count = std::min(kVerifiedBlock, frames - first);
    for (const BodyFrame& frame : session.body_frames(sensor, first, count))
      counts.add(frame, device_time(session.header().sensors[sensor], frame.stamp));
    advance(count);
  }
  counts.say(place, frames);
  if (const auto share = counts.joints.backward_feet()) backward_feet.push_back(*share);
}

void verify_depth(const SessionReader& session, std::size_t sensor, const Place& place,
                  const std::function<void(std::uint64_t)>& advance) {
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  std::uint64_t unreadable = 0, first_unreadable = 0, empty = 0;
  for (std::uint64_t i = 0; i < session.counts(sensor).depth_frames; ++i) {
    try {
      session.depth_frame(sensor, i, depth_mm);
      if (std::ranges::all_of(depth_mm, [](std::uint16_t d) { return d == 0; })) ++empty;
    } catch (const InputError&) {
      if (unreadable++ == 0) first_unreadable = i;
    }
    advance(1);
  }
  if (unreadable > 0)
    place.say(Severity::error, "/depth/frame_mm",
              fmt::format("{} frames are damaged, the first is number {}", unreadable, first_unreadable),
              kDepthUses);
  if (empty > 0)
    place.say(Severity::warning, "/depth/frame_mm", fmt::format("{} frames hold no depth at all", empty),
              kDepthUses);
}

// Checks the recorder's own counts and notices.
void verify_drops_and_notices(const SessionReader& session, std::size_t sensor, const Place& place) {
  const auto drops = session.drop_counts(sensor);
  constexpr std::int64_t kMaxLost = std::int64_t{1} << 40;  // 1,000 years at 30 Hz
  const auto is_count = [](std::int64_t n) { return n >= 0 && n <= kMaxLost; };
  if (!drops.empty() && (!is_count(drops.back().at_source) || !is_count(drops.back().in_queue)))
    place.say(
        Severity::error, "/drop_counts",
        fmt::format("{} frames lost at the source and {} because the queue was full are no counts of frames",
                    drops.back().at_source, drops.back().in_queue),
        kAnswers);
  else if (!drops.empty() && drops.back().at_source + drops.back().in_queue > 0)
    place.say(Severity::warning, "/drop_counts",
              fmt::format("{} frames were lost at the source and {} because the queue was full",
                          drops.back().at_source, drops.back().in_queue),
              kAnswers);
  if (const std::uint64_t more = session.counts(sensor).notices_left_out; more > 0)
    place.say(Severity::warning, "/notices",
              fmt::format("{} notices beyond the first {} are left out", more, kMaxSessionNotices));
  constexpr std::size_t kMaxCount = 20;
  const auto notices = session.notices(sensor);
  for (std::size_t i = 0; i < std::min(kMaxCount, notices.size()); ++i)
    place.say(Severity::note, "/notices", "the recorder said: " + notices[i].text);
  if (notices.size() > kMaxCount)
    place.say(Severity::note, "/notices", fmt::format("and {} notices more", notices.size() - kMaxCount));
}

void verify_exchanges(std::span<const ClockExchange> exchanges, const Place& place) {
  const auto broken = std::ranges::count_if(exchanges, [](const ClockExchange& e) {
    return e.t4_ns < e.t1_ns || e.t3_ns < e.t2_ns || (e.t4_ns - e.t1_ns) < (e.t3_ns - e.t2_ns);
  });
  if (broken > 0)
    place.say(Severity::error, "/clock_exchanges_ns",
              fmt::format("{} of {} exchanges run backwards", broken, exchanges.size()), kTimes);
  if (exchanges.empty())
    place.say(Severity::note, "/clock_exchanges_ns",
              "no clock exchanges: the sensor is taken to share the recording machine's clock");
}

void verify_uncertainty(const OffsetUncertainty& uncertainty, const Place& place) {
  constexpr double kSure_ms = 2.0;  // the paper's "less than 5 ms" leaves no more for two clocks
  constexpr double kNear_s = 10.0;
  const double sigma_ms = 1e-6 * static_cast<double>(uncertainty.sigma_ns);
  const double bound_ms = 1e-6 * static_cast<double>(uncertainty.bound_ns);
  const double outside_s = uncertainty.outside.seconds();
  const bool is_near = outside_s <= kNear_s;
  if (is_near && sigma_ms <= kSure_ms && bound_ms <= kSure_ms) return;
  const std::string where =
      is_near ? "" : fmt::format("frames lie up to {:.1f} s from any exchange; there ", outside_s);
  place.say(Severity::warning, "/clock_exchanges_ns",
            fmt::format("{}the clock of the sensor's computer is known to {:.1f} ms (one standard "
                        "deviation), and unlike delays could add {:.1f} ms",
                        where, sigma_ms, bound_ms),
            kTimes);
}

void verify_clock(const SessionReader& session, std::size_t sensor, const Place& place) {
  verify_exchanges(session.clock_exchanges(sensor), place);
  const SensorCounts& counts = session.counts(sensor);
  if (counts.body_frames + counts.depth_frames == 0) return;
  const SensorClockMap clock = fit_sensor_clock(session, sensor);
  constexpr Duration kMaxDeviation{1'000'000};
  verify_uncertainty(clock.stamps.uncertainty, place);
  if (clock.agent.deviation > kMaxDeviation)
    place.say(Severity::warning, "/clock_exchanges_ns",
              fmt::format("leave a straight line by {:.1f} ms {:.0f} s after the first: the clock of the "
                          "sensor's computer changed its rate, or the network delayed one way",
                          1e3 * clock.agent.deviation.seconds(), clock.agent.deviation_after.seconds()),
              kTimes);
  if (clock.stamps.deviation > kMaxDeviation)
    place.say(Severity::warning, "",
              fmt::format("all frames of 10 s, {:.0f} s after the first, are {:.1f} ms later than a straight "
                          "line from ticks to arrivals; the times there may be off by as much",
                          clock.stamps.deviation_after.seconds(), 1e3 * clock.stamps.deviation.seconds()),
              kTimes);
  if (clock.stamps.drift_left_out != 0.0)
    place.say(Severity::warning, "",
              fmt::format("ticks drift by {:.0f} ppm against arrivals, which no clock does; taken as none, "
                          "since the recording is short",
                          1e6 * clock.stamps.drift_left_out),
              kTimes);
  if (const auto text = arrival_jump_text(clock))
    place.say(Severity::error, "", *text, kTimes);
  else if (clock.epochs.size() > 1)
    place.say(Severity::note, "",
              fmt::format("its ticks began anew {} times while recording; each stretch is fitted by itself",
                          clock.epochs.size() - 1));
}

}  // namespace

std::string_view name_of(Severity severity) {
  return severity == Severity::note ? "note" : severity == Severity::warning ? "warning" : "error";
}

bool has_no_bodies(const SessionReader& session) {
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s)
    if (session.counts(s).bodies > 0 || session.counts(s).body_frames == 0) return false;
  return true;
}

// A sensor that stops long before the others is a recording of fewer sensors from there.
void verify_ends(const SessionReader& session, std::vector<Finding>& findings) {
  constexpr double kMinGap_s = 1.0;
  std::vector<std::optional<HostTime>> end_of_sensor(session.header().sensors.size());
  HostTime end{std::numeric_limits<std::int64_t>::min()};
  for (std::size_t s = 0; s < end_of_sensor.size(); ++s) {
    const SensorCounts& counts = session.counts(s);
    if (counts.body_frames + counts.depth_frames == 0) continue;
    const SensorClockMap host_from_sensor = fit_sensor_clock(session, s);
    if (arrival_jump_text(host_from_sensor)) return;  // ends are not on one clock
    for (const auto& [stream, frames] : {std::pair{FrameStream::bodies, counts.body_frames},
                                         std::pair{FrameStream::depth, counts.depth_frames}}) {
      if (frames == 0) continue;
      const HostTime last = host_from_sensor(session.stamps(s, stream, frames - 1, 1).front());
      end_of_sensor[s] = std::max(end_of_sensor[s].value_or(last), last);
      end = std::max(end, last);
    }
  }
  for (std::size_t s = 0; s < end_of_sensor.size(); ++s) {
    if (!end_of_sensor[s]) continue;
    const SensorDescription& sensor = session.header().sensors[s];
    const double before_s = (end - *end_of_sensor[s]).seconds();
    if (before_s > std::max(kMinGap_s, 30.0 / sensor.nominal_rate_hz))
      findings.push_back({Severity::error, session.path().string() + ":/sensors/" + sensor.name,
                          fmt::format("ends {:.1f} s before the last of the others: it stopped, or its "
                                      "connection broke",
                                      before_s),
                          kAnswers});
  }
}

namespace {

// Every part says what it finds; one that cannot be read is a finding itself.
void verify_sensor(const SessionReader& session, std::size_t s, const VerifyOptions& options,
                   const Place& place, std::vector<double>& backward_feet,
                   const std::function<void(std::uint64_t)>& advance) {
  const SensorCounts& counts = session.counts(s);
  const auto check = [&](const auto& part) {
    try {
      part();
    } catch (const InputError& error) {
      place.findings->push_back(
          {Severity::error, error.place(), error.problem(), "every study of this sensor"});
    }
  };
  if (counts.torn_rows > 0)
    place.say(Severity::warning, "",
              fmt::format("{} rows were not written to the end and are left out", counts.torn_rows),
              kAnswers);
  if (counts.body_frames == 0 && counts.depth_frames == 0)
    place.say(Severity::error, "", "holds no frames", "every study of this sensor");
  check([&] {
    verify_stamps(session, s, FrameStream::bodies, counts.body_frames, options.gap_periods, place,
                  "/body_frames");
  });
  if (const auto text = doubt_about(session.header().sensors[s].intrinsics))
    place.say(Severity::warning, "", *text, kDepthUses);
  check([&] { verify_bodies(session, s, place, backward_feet, advance); });
  if (counts.depth_frames > 0) {
    check([&] {
      verify_stamps(session, s, FrameStream::depth, counts.depth_frames, options.gap_periods, place,
                    "/depth");
    });
    if (options.read_depth)
      verify_depth(session, s, place, [&](std::uint64_t n) { advance(n * kDepthWeight); });
  }
  check([&] { verify_drops_and_notices(session, s, place); });
  check([&] { verify_clock(session, s, place); });
}

}  // namespace

std::vector<Finding> verify_session(const SessionReader& session, const VerifyOptions& options,
                                    const std::function<void(double)>& progress) {
  std::vector<Finding> findings;
  if (!session.complete())
    findings.push_back(
        {Severity::warning,
         session.path().string(),
         "was not closed by its recorder; what was flushed is readable, and `trilat recover` makes it whole",
         {}});
  const std::size_t sensors = session.header().sensors.size();
  std::uint64_t total = 0, done = 0;
  for (std::size_t s = 0; s < sensors; ++s)
    total += session.counts(s).body_frames +
             (options.read_depth ? kDepthWeight * session.counts(s).depth_frames : 0);
  const auto advance = [&](std::uint64_t amount) {
    done += amount;
    if (progress && total > 0) progress(static_cast<double>(done) / static_cast<double>(total));
  };
  std::vector<double> backward_feet;
  for (std::size_t s = 0; s < sensors; ++s)
    verify_sensor(session, s, options,
                  {session.path().string() + ":/sensors/" + session.header().sensors[s].name, &findings},
                  backward_feet, advance);
  if (const auto text = backward_feet_text(backward_feet))
    findings.push_back({Severity::warning, session.path().string() + ":/sensors", *text, kPositions});
  try {
    verify_ends(session, findings);
  } catch (const InputError&) {
    // said above, of the sensor's own stamps
  }
  return findings;
}

}  // namespace trilat
