// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/claims.h"
#include "datasets/results/results_file.h"
#include "datasets/results/timings.h"

namespace trilat {

// One sensor's clock in one run: frames asked for, with an answer, and with an error below 2 and 4 ms. Runs
// and sensors are independent of each other, frames of one clock are not.
struct ClockUnit {
  std::uint64_t asked = 0, answered = 0, below_2ms = 0, below_4ms = 0;
  bool operator==(const ClockUnit&) const = default;

  static constexpr bool as_list = true;
  TRILAT_FIELDS(asked, answered, below_2ms, below_4ms)
};

// One way to put a sensor's machine on the server's clock, over one kind of network.
struct ClockErrorRow {
  std::string network;
  std::string method;  // "none", "one exchange at the start", "as printed", …
  std::uint64_t asked = 0;
  TimeSpread error;  // absolute; n of those that got an answer
  // Share of all that is asked with an error below 2 ms, with its 95 % interval over sensors and runs.
  double below_2ms = TimeSpread::kNone;
  double below_2ms_low = TimeSpread::kNone, below_2ms_high = TimeSpread::kNone;
  std::vector<ClockUnit> units = {};  // one a run and sensor, all sensors of the first run first

  TRILAT_FIELDS(network, method, asked, error, below_2ms, below_2ms_low, below_2ms_high, units)
};

// Fate of a client's frames in the paper's queue at the server.
struct QueueCounts {
  std::uint64_t came = 0;
  std::uint64_t untimed = 0;  // no exchange yet, so no time of sending
  std::uint64_t too_early = 0,
                too_late = 0;  // stated time of sending too far from the server's time: dropped
  std::uint64_t taken = 0;
  bool operator==(const QueueCounts&) const = default;

  TRILAT_FIELDS(came, untimed, too_early, too_late, taken)
};

// One sensor's frames in one run.
struct QueueUnit {
  std::uint64_t came = 0, taken = 0;

  static constexpr bool as_list = true;
  TRILAT_FIELDS(came, taken)
};

// Counts over all runs and sensors, by one way to give a frame its time, over one kind of network.
struct QueueRow {
  std::string network, method;
  std::string server;  // when it takes frames out: "as they come", "once a frame of its own"
  QueueCounts counts;
  // Interval of the share that is taken, 95 % over sensors and runs.
  double taken_low = TimeSpread::kNone, taken_high = TimeSpread::kNone;
  std::vector<QueueUnit> units = {};  // one a run and sensor, all sensors of the first run first

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(network, method, server)
    QueueCounts::fields(self.counts, field);
    TRILAT_EACH(taken_low, taken_high, units)
  }
};

// The corrected fit's own uncertainty, over one kind of network: means over sensors and runs.
struct ClockFitRow {
  std::string network;
  double offset_sigma_s = TimeSpread::kNone;      // its standard deviation
  double offset_bound_s = TimeSpread::kNone;      // what unlike delays can add, at most
  double within_bound_share = TimeSpread::kNone;  // of frames whose error the bound and 4 sigma hold
  double exchanges_used_share = TimeSpread::kNone;

  TRILAT_FIELDS(network, offset_sigma_s, offset_bound_s, within_bound_share, exchanges_used_share)
};

// summary.json of a study of kind "recording". All of it is simulated.
struct RecordingSummary {
  static constexpr StudyKind kKind = StudyKind::recording;
  std::string study;
  std::uint64_t seed = 0;
  std::uint64_t frames = 0, sensors = 0, runs = 0;
  std::vector<ClockErrorRow> clocks;
  std::vector<ClockFitRow> fits;
  double late_s = 0.0;  // the queue's limit
  std::vector<QueueRow> queues;
  std::vector<ClaimNumber> claims;  // of the paper, that the study bears on

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(study)
    field("simulated", true);
    TRILAT_EACH(seed, frames, sensors, runs, clocks, fits, late_s, queues, claims)
  }
};

}  // namespace trilat
