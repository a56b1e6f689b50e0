// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "datasets/results/numbers.h"
#include "datasets/results/table.h"
#include "datasets/rig/campaign.h"
#include "pipeline/clocks/clocks_summary.h"
#include "pipeline/study/recordings.h"
#include "pipeline/study/study.h"

namespace trilat {

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
