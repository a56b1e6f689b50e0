// SPDX-License-Identifier: MIT
#include "reports/tables/accuracy_words.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace trilat {

std::string about(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  return fmt::format("{}, {}{}; {}{}{} of {} takes, {} participant{}", s.campaign,
                     condition.empty() ? "" : condition + ", ",
                     s.simulated ? "simulated sensors" : "recorded sensors",
                     s.left_out() ? "against the sensor left out; " : "",
                     alignment.empty() ? "" : "alignment: " + alignment + "; ", s.takes - s.takes_failed,
                     s.takes, s.participants, s.participants == 1 ? "" : "s");
}

std::string truth_note(const ResultsSummary& s) {
  if (!s.left_out()) return {};
  return "There is no ground truth. Each sensor in turn is left out, and its tracked joints are held against "
         "what the others say; each take counts once for every sensor. What all sensors have in common, such "
         "as a bias of the body model, cannot be seen. The sensor's own error is in every number: compare "
         "methods by these numbers, and do not quote them as their error. A method has one sensor fewer here "
         "than the rig.";
}

std::string interval_note(const ResultsSummary& s) {
  if (s.resamples == 0) return "There are no intervals: the study asks for no resamples.";
  return fmt::format(
      "In brackets stands the 95 % interval: the wider of Student's t and of a "
      "bootstrap-t with participants as clusters and blocks of {:g} s within them, {} resamples; of fewer "
      "than six participants Student's t. A single participant has none.",
      s.block_s, s.resamples);
}

void add_coverage_note(const ResultsSummary& s, const std::string& condition, const std::string& alignment,
                       Table& table) {
  std::string methods;
  for (const std::string& method : s.methods) {
    SummaryCell all;
    for (const SummaryCell& c : s.cells) {
      if (c.method != method || c.condition != condition || c.alignment != alignment ||
          c.group == kAverageGroup)
        continue;
      all.asked += c.asked;
      all.answered += c.answered;
      for (const auto& [status, n] : c.statuses)
        if (status != "converged" && status != "closed_form" && status != "clamped")
          all.statuses[status] += n;
    }
    if (!(all.coverage() < kLeastCoverage) || all.statuses.empty()) continue;
    const auto reason = std::max_element(all.statuses.begin(), all.statuses.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
    methods += fmt::format("{}{} {:.0f} % ({} {:.0f} %)", methods.empty() ? "" : ", ", method,
                           100.0 * all.coverage(), reason->first,
                           100.0 * static_cast<double>(reason->second) / static_cast<double>(all.asked));
  }
  if (!methods.empty())
    table.notes.push_back(
        "Answered less than 80 %, so that errors by themselves flatter these methods: " + methods +
        ". Compare them by the differences, which are of samples that both answer.");
}

void add_take_notes(const ResultsSummary& summary, Table& table) {
  for (const TakeNote& note : summary.notes)
    table.notes.push_back(
        fmt::format("Take {}{}: {}: {}.", note.take, note.failed ? " failed" : "", note.place, note.text));
}

std::string statuses_text(const std::map<std::string, std::uint64_t>& statuses, std::uint64_t asked) {
  std::vector<std::pair<std::string, std::uint64_t>> sorted(statuses.begin(), statuses.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (const auto& [name, n] : sorted) {
    const double share = 100.0 * static_cast<double>(n) / static_cast<double>(asked);
    const std::string number = share < 0.05                 ? "<0.1"
                               : share > 99.95 && n < asked ? ">99.9"
                                                            : fmt::format("{:.1f}", share);
    text += (text.empty() ? "" : ", ") + name + " " + number + " %";
  }
  return text;
}

}  // namespace trilat
