// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/claims.h"
#include "datasets/results/results_file.h"
#include "datasets/results/timings.h"

namespace trilat {

// One sensor's clock in one recording: frames, those with an answer, and with an error below 2 and 4 ms.
// Recordings and sensors are independent of each other, frames of one clock are not.
struct ClockUnit {
  std::uint64_t asked = 0, answered = 0, below_2ms = 0, below_4ms = 0;
  bool operator==(const ClockUnit&) const = default;

  static constexpr bool as_list = true;
  TRILAT_FIELDS(asked, answered, below_2ms, below_4ms)
};

// One way to put a sensor's computer on the recorder's clock.
struct ClockErrorRow {
  std::string method;  // "none", "one exchange at the start", "as printed", …
  std::uint64_t asked = 0;
  TimeSpread error;  // absolute; n of those that got an answer
  // Share of all that is asked with an error below 2 ms, with its 95 % interval over sensors and recordings.
  double below_2ms = TimeSpread::kNone;
  double below_2ms_low = TimeSpread::kNone, below_2ms_high = TimeSpread::kNone;
  std::vector<ClockUnit> units = {};  // one a recording and sensor, all sensors of the first recording first

  TRILAT_FIELDS(method, asked, error, below_2ms, below_2ms_low, below_2ms_high, units)
};

// Fate of a sensor's frames in the paper's queue at the server.
struct QueueCounts {
  std::uint64_t came = 0;
  std::uint64_t untimed = 0;  // no exchange yet, so no time of sending
  std::uint64_t too_early = 0,
                too_late = 0;  // stated time of sending too far from the server's time: dropped
  std::uint64_t taken = 0;
  bool operator==(const QueueCounts&) const = default;

  TRILAT_FIELDS(came, untimed, too_early, too_late, taken)
};

// One sensor's frames in one recording.
struct QueueUnit {
  std::uint64_t came = 0, taken = 0;

  static constexpr bool as_list = true;
  TRILAT_FIELDS(came, taken)
};

// Counts over all recordings and sensors, by one way to give a frame its time.
struct QueueRow {
  std::string method;
  std::string server;  // when it takes frames out: "as they come", "once a frame of its own"
  QueueCounts counts;
  // Interval of the share that is taken, 95 % over sensors and recordings.
  double taken_low = TimeSpread::kNone, taken_high = TimeSpread::kNone;
  std::vector<QueueUnit> units = {};  // one a recording and sensor, all sensors of the first recording first

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(method, server)
    QueueCounts::fields(self.counts, field);
    TRILAT_EACH(taken_low, taken_high, units)
  }
};

// The clock of one sensor's computer in one recording, and the way of its frames.
struct MachineRow {
  std::string take, sensor;
  std::uint64_t exchanges = 0, frames = 0;
  double exchanges_used_share = TimeSpread::kNone;  // by the offline fit
  double offset_sigma_s = TimeSpread::kNone;        // the fit's standard deviation
  double offset_bound_s = TimeSpread::kNone;        // what unlike delays can add, at most
  double bend_s = TimeSpread::kNone;                // of the clock from the fitted line, at most
  double within_bound_share = TimeSpread::kNone;    // of frames whose true error bound and 4 sigma hold
  // Time from exposure to the recorder; NaN where the session does not state how long a frame takes to its
  // sensor's computer.
  double latency_median_s = TimeSpread::kNone, latency_p99_s = TimeSpread::kNone;
  double in_time_share = TimeSpread::kNone;  // of frames that are there within the study's limit

  TRILAT_FIELDS(take, sensor, exchanges, frames, exchanges_used_share, offset_sigma_s, offset_bound_s, bend_s,
                within_bound_share, latency_median_s, latency_p99_s, in_time_share)
};

// summary.json of a study of kind "clocks".
struct ClocksSummary {
  static constexpr StudyKind kKind = StudyKind::clocks;
  std::string study, campaign;
  std::string paper = name_of(PaperStudy::none);
  bool simulated = false;
  std::uint64_t recordings = 0;
  double late_s = 0.0;  // the limit of the queue, and of a frame in time
  std::vector<ClockErrorRow> clocks;
  std::vector<QueueRow> queues;
  std::vector<MachineRow> machines;
  std::vector<std::string> left_out;  // takes and sensors without clocks to look at, each with the reason
  std::vector<ClaimNumber> claims;    // of the paper, that the study bears on

  TRILAT_FIELDS(study, campaign, paper, simulated, recordings, late_s, clocks, queues, machines, left_out,
                claims)
};

}  // namespace trilat
