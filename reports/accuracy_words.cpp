// SPDX-License-Identifier: MIT
#include "reports/accuracy_words.h"

#include <fmt/format.h>

namespace trilat {

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
      "From and to are a 95 % interval of what stands before them: the wider of Student's t and of a "
      "bootstrap-t with participants as clusters and blocks of {:g} s within them, {} resamples; of fewer "
      "than six participants Student's t. A single participant has none.",
      s.block_s, s.resamples);
}

void add_take_notes(const ResultsSummary& summary, Table& table) {
  for (const TakeNote& note : summary.notes)
    table.notes.push_back(
        fmt::format("Take {}{}: {}: {}.", note.take, note.failed ? " failed" : "", note.place, note.text));
}

}  // namespace trilat
