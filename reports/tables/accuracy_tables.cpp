// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"
#include "datasets/results/summary.h"
#include "reports/figures/figures.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {

namespace {

// How exactly the truth is known: one sentence a joint group.
void add_floor_notes(const ResultsSummary& s, const std::string& condition, const std::string& alignment,
                     Table& table) {
  for (const TruthFloor& floor : s.truth_floor) {
    if (floor.condition != condition) continue;
    double most_m = kNoNumber;
    for (const SummaryCell& c : s.cells)
      if (c.condition == condition && c.alignment == alignment && c.group == floor.group)
        most_m = std::fmax(most_m, c.one_frame_m);
    std::vector<std::string> known;
    if (std::isfinite(floor.mocap_noise_m))
      known.push_back(fmt::format("noise of at most {:.2f} cm", floor.mocap_noise_m * kCentimetresPerMetre));
    if (std::isfinite(floor.mean_speed_m_s))
      known.push_back(fmt::format("at its mean speed of {:.2f} m/s a clock error of {:g} ms makes {:.2f} cm",
                                  floor.mean_speed_m_s, floor.clock_error_s * 1e3,
                                  floor.clock_m() * kCentimetresPerMetre));
    if (std::isfinite(most_m))
      known.push_back(fmt::format("one instant early or late would change MAE by up to {:.2f} cm",
                                  most_m * kCentimetresPerMetre));
    if (!known.empty())
      table.notes.push_back(fmt::format("Truth of {}: {}.", floor.group, fmt::join(known, "; ")));
  }
}

Table detail_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  Table table;
  table.id = usable_id(fmt::format("accuracy-{}{}", condition.empty() ? "" : condition + "-", alignment));
  table.title = fmt::format("Position error by joint group and method ({})", about(s, condition, alignment));
  table.columns = {{"joint", "joint", true},
                   {"method", "method", true},
                   {"n", "n", false},
                   {"coverage (%)", "coverage_percent", false},
                   interval_column("MAE (cm)", "mae_cm"),
                   {"RMSE (cm)", "rmse_cm", false},
                   {"median (cm)", "median_cm", false},
                   {"p90 (cm)", "p90_cm", false},
                   {"p95 (cm)", "p95_cm", false},
                   {"max (cm)", "max_cm", false},
                   {"MAE x (cm)", "mae_x_cm", false},
                   {"MAE y (cm)", "mae_y_cm", false},
                   {"MAE z (cm)", "mae_z_cm", false},
                   {"GDOP", "gdop", false},
                   {"iterations", "iterations", false},
                   {"statuses", "statuses", true}};
  for (const SummaryCell& c : s.cells) {
    if (c.condition != condition || c.alignment != alignment) continue;
    table.rows.push_back(
        {TableValue::of(c.group), TableValue::of(c.method), count_cell(c.answered),
         percent_cell(c.coverage()), cm_cell(c.mae_m, c.mae_low_m, c.mae_high_m), cm_cell(c.rmse_m),
         cm_cell(c.median_m), cm_cell(c.p90_m), cm_cell(c.p95_m), cm_cell(c.max_m), cm_cell(c.axis_mae_m[0]),
         cm_cell(c.axis_mae_m[1]), cm_cell(c.axis_mae_m[2]), TableValue::of(c.mean_gdop, 2),
         TableValue::of(c.mean_iterations, 1), TableValue::of(statuses_text(c.statuses, c.asked))});
  }
  table.notes = {
      "MAE is the mean Euclidean distance; n counts instants and joints with a truth that the method "
      "answered; coverage is n over all that have one.",
      "x, y, z are the world's axes, y up.", interval_note(s)};
  if (s.left_out()) table.notes.insert(table.notes.begin(), truth_note(s));
  add_coverage_note(s, condition, alignment, table);
  add_floor_notes(s, condition, alignment, table);
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

// "geometric, each three k1+k2+k4" of the family "geometric, each three" is "k1+k2+k4".
std::string set_of(const std::string& method, const std::string& family) {
  return method == family ? "all" : method.substr(std::min(method.size(), family.size() + 1));
}

}  // namespace

std::vector<Table> sensor_counts_table(const ResultsSummary& s) {
  std::vector<Table> tables;
  for (const std::string& condition : s.conditions) {
    Table table;
    table.id = usable_id("sets-" + condition);
    table.title = fmt::format("Sets of sensors: mean absolute error, average over the joint groups ({})",
                              about(s, condition, s.alignments.front()));
    table.columns = {{"methods", "methods", true},
                     {"sensors", "sensors", false, true},
                     {"sets", "sets"},
                     interval_column("MAE (cm)", "mae_cm"),
                     {"answered (%)", "answered_percent"},
                     {"best set", "best", true},
                     {"its (cm)", "best_cm"},
                     {"worst set", "worst", true},
                     {"its (cm)", "worst_cm"}};
    for (const MethodFamily& family : s.families) {
      const FamilyCell* c = find_family(s, family.name, condition);
      if (!is_of_sets(family) || !c) continue;
      table.rows.push_back({TableValue::of(family.name), count_cell(family.sensors),
                            count_cell(family.methods.size()), cm_cell(c->mae_m, c->low_m, c->high_m),
                            percent_cell(c->answered), TableValue::of(set_of(c->best, family.name)),
                            cm_cell(c->best_m), TableValue::of(set_of(c->worst, family.name)),
                            cm_cell(c->worst_m)});
    }
    if (table.rows.empty()) continue;
    table.notes = {
        fmt::format(
            "Mean over all sets of so many sensors, or over a declared number of them, of what they answer. "
            "The best and the worst set were picked afterwards, by their ratio to \"{}\" on the samples that "
            "both answer.",
            s.reference),
        "In brackets: 95 % interval by Student's t between participants."};
    tables.push_back(std::move(table));
  }
  return tables;
}

std::vector<Figure> sensor_counts_figure(const ResultsSummary& s) {
  std::vector<Figure> figures;
  for (const std::string& condition : s.conditions) {
    Figure figure;
    for (const MethodFamily& family : s.families) {
      const FamilyCell* c = find_family(s, family.name, condition);
      const std::string end = fmt::format(", {} sensors", family.sensors);
      if (!c || !family.name.ends_with(end)) continue;
      const std::string method = family.name.substr(0, family.name.size() - end.size());
      auto series = std::find_if(figure.series.begin(), figure.series.end(),
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
        "over the "
        "joint groups, alignment {}; over what the methods answer.",
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
  Table table;
  table.id = "changes";
  table.title = fmt::format("What changed from {} to {}: mean error in cm ({} participants, {})",
                            changes.before, changes.after, changes.participants,
                            changes.paired ? "the same in both" : "others in each");
  table.columns = {{"condition", "condition", true},
                   {"method", "method", true},
                   {"before (cm)", "before_mae_cm"},
                   {"after (cm)", "after_mae_cm"},
                   interval_column("after - before (cm)", "difference_cm"),
                   {"differs", "differs", true}};
  std::vector<const ErrorChange*> rows;
  for (const ErrorChange& change : changes.rows) rows.push_back(&change);
  std::ranges::stable_sort(rows, [](const ErrorChange* a, const ErrorChange* b) {
    if (a->is_real() != b->is_real()) return a->is_real();
    return std::abs(a->difference_m) > std::abs(b->difference_m);
  });
  for (const ErrorChange* c : rows)
    table.rows.push_back({TableValue::of(c->condition), TableValue::of(c->method), cm_cell(c->before_m),
                          cm_cell(c->after_m), cm_cell(c->difference_m, c->low_m, c->high_m),
                          TableValue::of(!c->is_real()           ? "no"
                                         : c->difference_m < 0.0 ? "better"
                                                                 : "worse")});
  table.notes = notes("changes");
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
