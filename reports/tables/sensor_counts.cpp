// SPDX-License-Identifier: MIT
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "reports/figures/figures.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
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

}  // namespace trilat
