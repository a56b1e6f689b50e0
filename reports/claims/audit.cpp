// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"
#include "datasets/results/summary.h"
#include "datasets/results/table.h"
#include "reports/claims/claims.h"

namespace trilat {
namespace {

constexpr const char* kAgrees = "agrees";
constexpr const char* kDiffers = "differs";

// Names a row: the erratum and which of its rows it is.
TableValue row_key(const Table& table, const std::string& erratum) {
  const auto same = [&](const auto& row) { return row[1].text == erratum; };
  const auto before = std::ranges::count_if(table.rows, same);
  return TableValue::of(fmt::format("{}-{}", erratum, before + 1));
}

// A printed number and what follows from the others, compared as it is printed.
void compare(Table& table, const char* erratum, const std::string& what, double printed, double recomputed,
             int decimals, const std::string& how) {
  const double step = std::pow(10.0, -decimals);
  const bool agrees = std::abs(printed - std::round(recomputed / step) * step) < 0.5 * step;
  table.rows.push_back({row_key(table, erratum), TableValue::of(erratum), TableValue::of(what),
                        TableValue::of(printed, decimals), TableValue::of(recomputed, decimals + 1),
                        TableValue::of(agrees ? kAgrees : kDiffers), TableValue::of(how)});
}

const std::vector<double>& printed_row(const PrintedTable3& table, const std::string& group) {
  const auto row = std::ranges::find_if(table.rows, [&](const auto& r) { return r.group == group; });
  return row->mae_cm;
}

void audit_averages(Table& table, const PrintedTable3& paper) {
  const std::vector<double>& printed = printed_row(paper, kAverageGroup);
  for (std::size_t m = 0; m < paper.methods.size(); ++m) {
    double sum_cm = 0.0, rows = 0.0;
    for (const auto& row : paper.rows)
      if (row.group != kAverageGroup) {
        sum_cm += row.mae_cm[m];
        rows += 1.0;
      }
    compare(table, "E13", fmt::format("Table III, average of {} (cm)", paper.methods[m]), printed[m],
            sum_cm / rows, 1, "mean of the four printed rows");
  }
}

void audit_improvements(Table& table, const PrintedTable3& paper, const PrintedErrata& errata) {
  const std::vector<double>& average_cm = printed_row(paper, kAverageGroup);
  const double ours_cm = average_cm.back();
  for (const PrintedErrata::Improvement& i : errata.improvements) {
    const auto m =
        static_cast<std::size_t>(std::ranges::find(paper.methods, i.method) - paper.methods.begin());
    const double gain_cm = average_cm.at(m) - ours_cm;
    for (const auto& [of, base_cm] :
         {std::pair{i.method, average_cm[m]}, std::pair{paper.methods.back(), ours_cm}})
      compare(
          table, "E12", fmt::format("{}, better than {} (%)", i.where, i.method), i.percent,
          100.0 * gain_cm / base_cm, 1,
          fmt::format("({:g} - {:g}) / {:g} cm: of the error of {}", average_cm[m], ours_cm, base_cm, of));
  }
}

void audit_times(Table& table, const PrintedTable4& paper) {
  std::uint64_t frames = 0, samples = 0, in_time = 0;
  for (const PrintedTable4::Row& row : paper.rows) {
    frames += row.frames;
    samples += row.clock_samples;
    if (std::isfinite(row.to_ms)) in_time += row.frames;
  }
  const auto number = [](std::uint64_t n) { return static_cast<double>(n); };
  compare(table, "E14", "Table IV, clock errors below 2 ms (%)", paper.below_2ms_percent,
          100.0 * share_of(paper.rows.back().clock_samples, samples), 2,
          fmt::format("{} of {} printed samples", paper.rows.back().clock_samples, samples));
  compare(
      table, "E14", "Table IV, clock samples", number(paper.frames * paper.clients), number(samples), 0,
      fmt::format("sum of the printed ranges, against {} frames of {} clients", paper.frames, paper.clients));
  compare(table, "none", "Table IV, frames and lost frames", number(paper.frames),
          number(frames + paper.lost_frames), 0,
          fmt::format("sum of the printed ranges and {} lost", paper.lost_frames));
  compare(table, "none", "Table IV, frames in real time (%)", paper.real_time_percent,
          100.0 * share_of(in_time, paper.frames), 2,
          fmt::format("{} below 33 ms of {}", in_time, paper.frames));
}

void audit_words(Table& table, const PrintedErrata& errata) {
  compare(table, "E15", "gait cycles of a participant", errata.gait_cycles[1], errata.gait_cycles[0], 0,
          "stated twice");
  compare(table, "E15", "trilateration systems compared", errata.systems_named, errata.systems_shown, 0,
          "named, and shown");
}

std::string both(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? a + b : a + "; " + b;
}

std::string effect_of(const std::string& erratum, const PaperFindings& findings) {
  const auto stored = findings.evidence.errata.find(erratum);
  const auto numbers = findings.errata.find(erratum);
  return both(stored == findings.evidence.errata.end() ? std::string() : stored->second,
              numbers == findings.errata.end() ? std::string() : numbers_text(numbers->second));
}

}  // namespace

Table audit_table() {
  const PrintedTable3 table3 = printed_table3();
  const PrintedErrata errata = printed_errata();
  Table table;
  table.id = "audit";
  table.title = "The paper's printed numbers, recomputed from its own tables";
  table.columns = {{"row", "row", true},   {"erratum", "erratum", true}, {"number", "number", true},
                   {"printed", "printed"}, {"recomputed", "recomputed"}, {"verdict", "verdict", true},
                   {"how", "how", true}};
  audit_improvements(table, table3, errata);
  audit_averages(table, table3);
  audit_times(table, printed_table4());
  audit_words(table, errata);
  add_notes(table, "audit", {{"source", errata.source}});
  return table;
}

Table errata_table(const PaperFindings& findings) {
  using R = PrintedErrata::Erratum;
  const auto effect = [&](const R& r) {
    const std::string text = effect_of(r.id, findings);
    if (!text.empty()) return text;
    return std::string(r.changes_results ? "its study is not among these results" : "none on a result");
  };
  Table table = table_of<R>("errata",
                            std::string("What is printed that cannot be so, and what the difference does") +
                                (findings.evidence.any_simulated ? " (simulated)" : ""),
                            printed_errata().errata,
                            {{"erratum", "erratum", as_text(&R::id)},
                             {"where", "where", as_text(&R::where)},
                             {"printed", "printed", as_text(&R::printed)},
                             {"why not", "problem", as_text(&R::problem)},
                             {"corrected", "corrected", as_text(&R::corrected)},
                             {"effect in these results", "effect", as_text(effect)}});
  add_notes(table, "errata");
  return table;
}

}  // namespace trilat
