// SPDX-License-Identifier: MIT
#include "reports/accuracy_words.h"

#include <fmt/format.h>

#include "datasets/base/units.h"

namespace trilat {

TableValue cm_value(double metres) { return TableValue::of(metres * kCentimetresPerMetre, 2); }
TableValue percent_value(double percent) { return TableValue::of(percent, 1); }
TableValue count_value(std::uint64_t n) { return TableValue::of(static_cast<double>(n), 0); }

std::string about(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  return fmt::format("{}, {}{}; {}{} of {} takes, {} participant{}", s.campaign,
                     condition.empty() ? "" : condition + ", ",
                     s.simulated ? "simulated sensors" : "recorded sensors",
                     alignment.empty() ? "" : "alignment: " + alignment + "; ", s.takes - s.takes_failed,
                     s.takes, s.participants, s.participants == 1 ? "" : "s");
}

std::string interval_note(const ResultsSummary& s) {
  if (s.resamples == 0) return "There are no intervals: the study asks for no resamples.";
  return fmt::format(
      "From and to are a 95 % interval of what stands before them: bootstrap-t with participants as clusters "
      "and blocks of {:g} s within them, {} resamples; of fewer than six participants Student's t. A single "
      "participant has none.",
      s.block_s, s.resamples);
}

void add_take_notes(const ResultsSummary& summary, Table& table) {
  for (const TakeNote& note : summary.notes)
    table.notes.push_back(
        fmt::format("Take {}{}: {}: {}.", note.take, note.failed ? " failed" : "", note.place, note.text));
}

}  // namespace trilat
