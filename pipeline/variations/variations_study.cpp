// SPDX-License-Identifier: MIT
#include "pipeline/variations/variations_study.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/text_output.h"
#include "datasets/results/item_store.h"
#include "datasets/results/results_file.h"
#include "datasets/results/stored_take.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/errors/condition_errors.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/variations/variations_results.h"

namespace trilat {
namespace {

std::string item_of(std::size_t point) { return fmt::format("points/{:05}", point + 1); }

// By method the mean over the joint groups of each participant's mean error, under the first alignment.
std::vector<std::vector<double>> errors_of_persons(const ResultsSummary& summary) {
  struct Sums {
    double length_m = 0.0, n = 0.0;
  };
  std::map<std::string, std::map<std::string, std::map<std::string, Sums>>> sums;  // method, person, group
  for (const TakeJointRow& row : summary.by_take) {
    if (row.condition != summary.conditions.front() || row.answered == 0) continue;
    Sums& of = sums[row.method][row.participant][row.group];
    of.length_m += static_cast<double>(row.answered) * row.mae_m;
    of.n += static_cast<double>(row.answered);
  }
  std::vector<std::vector<double>> errors;
  for (const std::string& method : summary.methods) {
    errors.emplace_back();
    for (const auto& [person, by_group] : sums[method]) {
      double mean_m = 0.0;
      for (const auto& [group, of] : by_group)
        mean_m += of.length_m / of.n / static_cast<double>(by_group.size());
      errors.back().push_back(mean_m);
    }
  }
  return errors;
}

// Errors in the study's first condition.
void take_errors(const std::filesystem::path& results, const ResultsSummary& summary, VariationPoint& point) {
  const std::string& condition = summary.conditions.front();
  for (const std::string& method : summary.methods) {
    double asked = 0.0, answered = 0.0;
    for (const TakeJointRow& row : summary.by_take)
      if (row.condition == condition && row.method == method) {
        asked += static_cast<double>(row.asked);
        answered += static_cast<double>(row.answered);
      }
    point.answered.push_back(answered / asked);
  }
  point.person_m = errors_of_persons(summary);
  std::vector<TakeTable> tables;
  std::vector<std::string> joints;
  for (const ResultTake& take : result_takes(results)) {
    if (take.folder.empty()) continue;
    const StoredTake file = open_take(take);
    joints = file.head().joints;
    tables.push_back({take.id, take.id, take.condition, file.read_errors()});
  }
  point.paired_m = paired_errors_m(tables, joints, summary.methods.size(), condition);
}

// A take that fails makes the point fail: its errors would be of other persons than those of the others.
void evaluate(const VariationsSpec& spec, const Campaign& campaign, const std::filesystem::path& results,
              const Watch& watch, VariationPoint& point) {
  try {
    const ResultsSummary summary =
        execute_study(spec.study, campaign, results, {.stop_requested = watch.stop_requested});
    for (const TakeNote& note : summary.notes)
      if (note.failed && point.problem.empty()) point.problem = note.take + ": " + note.text;
    if (point.problem.empty()) take_errors(results, summary, point);
  } catch (const OutputError&) {
    throw;
  } catch (const InputError& error) {
    point.problem = error.what();
  }
}

Computed compute(const VariationsSpec& spec, std::size_t number, const std::filesystem::path& into,
                 const Watch& watch) {
  VariationPoint point = spec.head.points[number];
  const std::filesystem::path work = into / "work";
  const Campaign campaign =
      simulate_campaign(simulation_at(spec, number), work / "campaign", {watch.stop_requested, {}});
  evaluate(spec, campaign, work / "results", watch, point);
  spec.inputs.check();
  std::filesystem::remove_all(work);
  return {json_of(point), !point.problem.empty()};
}

std::string key_of_point(const VariationsSpec& spec, std::size_t number) {
  return key_of({{"kind", "point of a study of variations"},
                 {"study", resolved_json(spec.study)},
                 {"simulation", simulation_json_at(spec, number)},
                 {"name", spec.head.points[number].name},
                 {"inputs_sha256", spec.inputs_sha256}});
}

VariationsSummary summary_of(const VariationsSpec& spec, const Outcomes& outcomes) {
  VariationsSummary summary = spec.head;
  for (std::size_t p = 0; p < summary.points.size(); ++p) {
    const Outcome& outcome = outcomes.at(item_of(p));
    const Json json = outcome.json;
    summary.points[p] = read_as<VariationPoint>(JsonObject(json, outcome.place(), ""));
  }
  return summary;
}

// A row a point and method.
void write_points(const std::filesystem::path& path, const VariationsSummary& s) {
  TextOutput text(path);
  text.add("point");
  for (const VariedRange& range : s.ranges) text.add(",{}", csv_field(range.name));
  text.add(",method,mae_m,answered,problem\n");
  for (std::size_t p = 0; p < s.points.size(); ++p) {
    const VariationPoint& point = s.points[p];
    const bool is_there = point.problem.empty();
    for (std::size_t m = 0; m < s.methods.size(); ++m) {
      text.add("{}", point.name.empty() ? std::to_string(p + 1) : csv_field(point.name));
      for (std::size_t r = 0; r < s.ranges.size(); ++r)
        text.add(",{}", csv_field(s.ranges[r].text_at(point.position[r])));
      text.add(",{}", csv_field(s.methods[m]));
      const double error_m = is_there ? point.paired_m[m * s.methods.size() + m] : kNoNumber;
      for (const double number : {error_m, is_there ? point.answered[m] : kNoNumber})
        text.add(",{}", std::isfinite(number) ? fmt::format("{:.9g}", number) : "");
      text.add(",{}\n", csv_field(point.problem));
    }
  }
  text.publish();
}

}  // namespace

Study variations_study(const VariationsSpec& spec) {
  const auto shared = std::make_shared<const VariationsSpec>(spec);
  const Json resolved = resolved_json(spec);
  Study study{.kind = name_of(StudyKind::variations),
              .settings = {{"study", resolved}, {"inputs_sha256", spec.inputs_sha256}},
              .write_beside =
                  [shared](const std::filesystem::path& folder) {
                    write_declared_parameters(folder, simulation_parameters(simulation_at(*shared, 0)));
                  },
              .reduce =
                  [shared](const Outcomes& outcomes, const std::filesystem::path& folder, const Watch&) {
                    VariationsSummary summary = summary_of(*shared, outcomes);
                    analyse(summary);
                    write_points(folder / "points.csv", summary);
                    store_tables(folder, variation_tables(summary));
                    write_beside(folder, StoredFigures{variation_figures(summary)});
                    write_results(folder, summary);
                  },
              .manifest = [resolved] { return manifest_of_generated(resolved); }};
  for (std::size_t p = 0; p < spec.head.points.size(); ++p) {
    simulation_at(spec, p);  // InputError before anything is simulated
    study.items.push_back({item_of(p), 1.0,
                           [shared, p](const std::filesystem::path& into, const Watch& watch) {
                             return compute(*shared, p, into, watch);
                           },
                           [shared, p](const Watch&) { return key_of_point(*shared, p); }});
  }
  return study;
}

}  // namespace trilat
