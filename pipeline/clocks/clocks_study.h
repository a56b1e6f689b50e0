// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/results/numbers.h"
#include "datasets/results/results_file.h"
#include "datasets/results/table.h"
#include "datasets/rig/campaign.h"
#include "pipeline/study/recordings.h"
#include "pipeline/study/study.h"

namespace trilat {

// A range of Table IV and the statistic that holds the share of frames in it. The paper counts processing
// times below 11 ms as one range, (0, 11): here they are the first three.
struct TimeRange {
  const char* share;
  double below_s;
};
inline constexpr std::array<TimeRange, 6> kTimeRanges{
    {{"share_below_2ms", 0.002},
     {"share_from_2_to_4ms", 0.004},
     {"share_from_4_to_11ms", 0.011},
     {"share_from_11_to_22ms", 0.022},
     {"share_from_22_to_33ms", 0.033},
     {"share_from_33ms", std::numeric_limits<double>::infinity()}}};
inline constexpr const char* kShareBelow4ms = "share_below_4ms";

// summary.json of a study of kind "clocks". Its numbers are
// - "clock_error", by method: median, p95, p99, p999 and max of the absolute errors, and the shares of all
//   frames in each of kTimeRanges; by take and sensor (the group) the shares below 2 and 4 ms;
// - "queue", by method and by when the server takes frames (the condition): the shares of frames that came
//   (1), had no time yet, were too early or too late, and were taken; by take and sensor those taken;
// - "clock_fit" and "latency", by take and sensor: how the offline fit states its clock, and how long its
//   frames take from their exposure to the recorder, where the session says how long they take to its
//   computer.
// Intervals are over recordings and sensors: frames of one clock are not independent of each other.
struct ClocksSummary {
  static constexpr StudyKind kKind = StudyKind::clocks;
  std::string study, campaign;
  std::string paper = name_of(PaperStudy::none);
  bool simulated = false;
  std::uint64_t recordings = 0;
  double late_s = 0.0;              // the limit of the queue, and of a frame in time
  std::vector<std::string> failed;  // takes and sensors without clocks to look at, each with the reason
  std::uint64_t rows = 0;
  Numbers numbers = {};

  static void fields(auto& self, auto&& f) {
    f("study", self.study, "campaign", self.campaign, "paper", self.paper, "simulated", self.simulated,
      "recordings", self.recordings, "late_s", self.late_s, "failed", self.failed, "rows", self.rows);
  }
};

// A study of kind "clocks": how well the clocks of the computers of a campaign's recordings were brought
// together, and which frames came in time.
struct ClocksSpec : RecordingsStudy {
  // The most by which a frame's time of sending may differ from the server's time for the paper's queue, and
  // the time from exposure within which a frame counts as in time.
  double late_s = 1.0 / 30.0;

  static void fields(auto& self, Fields& f) {
    visit_head(self, f, StudyKind::clocks);
    f("late_s", self.late_s,
      opt("Longest time by which a frame may be late for the paper's queue, and from its exposure to count "
          "as in time",
          {0.0, 10.0}));
  }
};

// Evaluates all recordings of the campaign, its wand's too, on the threads of the current arena. summary.json
// is a ClocksSummary. A sensor without clock exchanges is left out and named; InputError where none has any;
// throws Interrupted.
ItemCounts run_clocks(const ClocksSpec& spec, const Campaign& campaign, const std::filesystem::path& folder,
                      const StudyOptions& options);

// The errors of one sensor's frames in one recording by one way to give them their times, in seconds; NaN
// where it has no answer.
struct UnitErrors {
  std::string take, sensor;
  std::span<const double> error_s;
};
// Adds the numbers of measure "clock_error" (see ClocksSummary) of one method; none where it answers nowhere.
void add_clock_errors(const std::string& method, const std::vector<UnitErrors>& units, Numbers& numbers);

// Table IV beside the paper's: clock errors, what the queue drops, each computer's clock and the way of its
// frames; the paper's processing time stands by itself, since nothing here can test it.
StoredTables clocks_tables(const ClocksSummary& summary);

}  // namespace trilat
