// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"
#include "datasets/results/summary.h"
#include "datasets/results/table.h"
#include "reports/figures/figures.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

Table detail_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  using R = SummaryCell;
  const auto axis_m = [](std::size_t axis) { return [=](const R& r) { return r.axis_mae_m[axis]; }; };
  Table table = table_of<R>(
      usable_id(fmt::format("accuracy-{}{}", condition.empty() ? "" : condition + "-", alignment)),
      fmt::format("Position error by joint group and method ({})", about(s, condition, alignment)), s.cells,
      {{"joint", "joint", as_text(&R::group)},
       {"method", "method", as_text(&R::method)},
       {"n", "n", as_count(&R::answered)},
       {"coverage (%)", "coverage_percent", in_percent(&R::coverage)},
       {"MAE (cm)", "mae_cm", in_cm(&R::mae_m, &R::mae_low_m, &R::mae_high_m)},
       {"RMSE (cm)", "rmse_cm", in_cm(&R::rmse_m)},
       {"median (cm)", "median_cm", in_cm(&R::median_m)},
       {"p90 (cm)", "p90_cm", in_cm(&R::p90_m)},
       {"p95 (cm)", "p95_cm", in_cm(&R::p95_m)},
       {"max (cm)", "max_cm", in_cm(&R::max_m)},
       {"MAE x (cm)", "mae_x_cm", in_cm(axis_m(0))},
       {"MAE y (cm)", "mae_y_cm", in_cm(axis_m(1))},
       {"MAE z (cm)", "mae_z_cm", in_cm(axis_m(2))},
       {"iterations", "iterations", as_number(1, &R::mean_iterations)},
       {"statuses", "statuses", as_text([](const R& r) { return statuses_text(r.statuses, r.asked); })}},
      [&](const R& r) { return r.condition == condition && r.alignment == alignment; });
  if (s.left_out()) table.notes.push_back(truth_note(s));
  add_notes(table, "accuracy");
  table.notes.push_back(interval_note(s));
  add_coverage_note(s, condition, alignment, table);
  add_take_notes(s, table);
  return table;
}

}  // namespace

std::vector<Table> accuracy_tables(const ResultsSummary& summary) {
  std::vector<Table> tables;
  const auto add = [&](Table table) {
    if (!table.rows.empty()) tables.push_back(std::move(table));
  };
  for (const std::string& condition : summary.conditions) {
    for (const std::string& alignment : summary.alignments) {
      add(detail_table(summary, condition, alignment));
      add(differences_table(summary, condition, alignment));
    }
    add(bodies_table(summary, condition));
  }
  return tables;
}

namespace {

// Each single sensor is a row of the other tables.
bool is_of_sets(const MethodFamily& family) { return family.sensors > 1; }

const FamilyCell* find_family(const ResultsSummary& s, const std::string& family,
                              const std::string& condition) {
  for (const FamilyCell& cell : s.family_cells)
    if (cell.family == family && cell.condition == condition) return &cell;
  return nullptr;
}

}  // namespace

std::vector<Figure> sensor_counts_figure(const ResultsSummary& s) {
  std::vector<Figure> figures;
  for (const std::string& condition : s.conditions) {
    Figure figure;
    for (const MethodFamily& family : s.families) {
      const FamilyCell* c = find_family(s, family.name, condition);
      const std::string end = fmt::format(", {} sensors", family.sensors);
      if (!c || !family.name.ends_with(end)) continue;
      const std::string method = family.name.substr(0, family.name.size() - end.size());
      auto series = std::ranges::find_if(figure.series,
                                         [&](const FigureSeries& other) { return other.name == method; });
      if (series == figure.series.end())
        series = figure.series.insert(figure.series.end(),
                                      {method, FigureSeries::Style::line_and_dots, {}, {}, method});
      series->points.push_back({static_cast<double>(family.sensors), c->mae_m * kCentimetresPerMetre,
                                c->low_m * kCentimetresPerMetre, c->high_m * kCentimetresPerMetre});
    }
    if (figure.series.empty()) continue;
    figure.id = usable_id(fmt::format("sensors-{}", condition));
    figure.title =
        fmt::format("Number of sensors, {}, {}{}", s.campaign, condition, s.simulated ? ", simulated" : "");
    figure.caption = fmt::format(
        "{}Mean absolute error over sets of so many sensors, with its interval over participants, average "
        "over the joint groups, alignment {}; over what the methods answer.",
        s.simulated ? "Simulated. " : "", s.alignments.front());
    figure.x_label = "sensors";
    figure.y_label = "mean absolute error (cm)";
    figures.push_back(std::move(figure));
  }
  return figures;
}

ResultsSummary without_sets(ResultsSummary s) {
  std::set<std::string> members;
  for (const MethodFamily& family : s.families)
    if (is_of_sets(family) && family.methods.size() > 1)
      members.insert(family.methods.begin(), family.methods.end());
  members.erase(s.reference);
  std::erase_if(s.methods, [&](const std::string& name) { return members.contains(name); });
  const auto is_member = [&](const auto& entry) { return members.contains(entry.method); };
  std::erase_if(s.cells, is_member);
  std::erase_if(s.differences, is_member);
  std::erase_if(s.bodies, is_member);
  return s;
}

Table changes_table(const ErrorChanges& changes) {
  using R = ErrorChange;
  std::vector<R> rows = changes.rows;
  std::ranges::stable_sort(rows, [](const R& a, const R& b) {
    if (a.is_real() != b.is_real()) return a.is_real();
    return std::abs(a.difference_m) > std::abs(b.difference_m);
  });
  Table table =
      table_of<R>("changes",
                  fmt::format("What changed from {} to {}: mean error in cm ({} participants, {})",
                              changes.before, changes.after, changes.participants,
                              changes.paired ? "the same in both" : "others in each"),
                  rows,
                  {{"condition", "condition", as_text(&R::condition)},
                   {"method", "method", as_text(&R::method)},
                   {"before (cm)", "before_mae_cm", in_cm(&R::before_m)},
                   {"after (cm)", "after_mae_cm", in_cm(&R::after_m)},
                   {"after - before (cm)", "difference_cm", in_cm(&R::difference_m, &R::low_m, &R::high_m)},
                   {"differs", "differs", as_text([](const R& r) {
                      return !r.is_real() ? "no" : r.difference_m < 0.0 ? "better" : "worse";
                    })}});
  add_notes(table, "changes");
  return table;
}

std::vector<std::string> changes_sentences(const ErrorChanges& changes) {
  constexpr std::size_t kMost = 3;
  const Table table = changes_table(changes);
  const auto real = std::ranges::count_if(changes.rows, &ErrorChange::is_real);
  std::vector<std::string> sentences{fmt::format(
      "From `{}` to `{}` the mean error of **{} of {}** methods and conditions changed beyond its interval.",
      changes.before, changes.after, real, changes.rows.size())};
  for (std::size_t r = 0; r < std::min<std::size_t>(kMost, static_cast<std::size_t>(real)); ++r) {
    const auto& row = table.rows[r];
    sentences.push_back(fmt::format("`{}`, {}: {:+.2f} cm ({:+.2f} to {:+.2f}), from {:.2f} to {:.2f}.",
                                    row[1].text, row[0].text, *row[4].number, row[4].low, row[4].high,
                                    *row[2].number, *row[3].number));
  }
  return sentences;
}

}  // namespace trilat
