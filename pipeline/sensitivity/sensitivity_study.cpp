// SPDX-License-Identifier: MIT
#include "pipeline/sensitivity/sensitivity_study.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/results/declared_parameters.h"
#include "datasets/results/item_store.h"
#include "datasets/results/results_file.h"
#include "evaluators/metrics/sobol_indices.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/errors/summarise.h"
#include "pipeline/sensitivity/sensitivity_analysis.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/simulate/simulate_take.h"

namespace trilat {
namespace {

constexpr std::size_t kDefaultRows = 8;  // campaigns of the simulation as it is, for an interval

// The points of an item, without their errors.
struct Row {
  std::string item;
  std::vector<SensitivityPoint> points;
};

std::vector<Row> space_rows(const SensitivitySummary& head) {
  const std::size_t columns = head.factors.size() + 2;
  const auto design = saltelli_design(head.factors.size(), head.rows);
  std::vector<Row> rows;
  for (std::size_t r = 0; r < head.rows; ++r) {
    rows.push_back({fmt::format("space/{:05}", r), {}});
    for (std::size_t c = 0; c < columns; ++c)
      rows.back().points.push_back({.design = "space", .row = r, .position = design[r * columns + c]});
  }
  return rows;
}

std::size_t index_of(const SensitivitySummary& head, const std::string& factor) {
  return static_cast<std::size_t>(std::ranges::find(head.factors, factor, &SensitivityFactor::name) -
                                  head.factors.begin());
}

std::vector<Row> slice_rows(const SensitivitySummary& head, std::size_t number) {
  const SensitivitySlice& slice = head.slices[number];
  const auto middle = [&](std::size_t step) {
    return (static_cast<double>(step) + 0.5) / static_cast<double>(slice.steps);
  };
  std::vector<Row> rows;
  for (std::size_t y = 0; y < slice.steps; ++y) {
    rows.push_back({fmt::format("slices/{}-{:03}", number + 1, y), {}});
    for (std::size_t x = 0; x < slice.steps; ++x) {
      SensitivityPoint point{.design = slice.name, .row = y, .position = {}};
      point.position.assign(head.factors.size(), kNoNumber);
      point.position[index_of(head, slice.x)] = middle(x);
      point.position[index_of(head, slice.y)] = middle(y);
      rows.back().points.push_back(point);
    }
  }
  return rows;
}

std::vector<Row> rows_of(const SensitivitySummary& head) {
  std::vector<Row> rows = space_rows(head);
  for (std::size_t r = 0; r < kDefaultRows; ++r) {
    SensitivityPoint as_it_is{.design = "default", .row = r, .position = {}};
    as_it_is.position.assign(head.factors.size(), kNoNumber);
    rows.push_back({fmt::format("default/{}", r), {as_it_is}});
  }
  for (std::size_t s = 0; s < head.slices.size(); ++s)
    for (Row& row : slice_rows(head, s)) rows.push_back(std::move(row));
  return rows;
}

// The shares that the methods answer in the study's first condition, and their errors.
void take_errors(const std::filesystem::path& results, const ResultsSummary& summary,
                 SensitivityPoint& point) {
  for (std::size_t m = 0; m < summary.methods.size(); ++m)
    for (const SummaryCell& cell : summary.cells)
      if (cell.group == kAverageGroup && cell.method == summary.methods[m] &&
          cell.condition == summary.conditions.front() && cell.alignment == summary.alignments.front())
        point.answered[m] = cell.coverage();
  std::vector<TakeTable> tables;
  std::vector<std::string> joints;
  for (const ResultTake& take : result_takes(results)) {
    if (take.folder.empty()) continue;
    const StoredTake file = open_take(take);
    joints = file.head().joints;
    tables.push_back({take.id, take.id, take.condition, file.read_errors()});
  }
  if (!tables.empty())
    point.paired_m = paired_errors_m(tables, joints, summary.methods.size(), summary.conditions.front());
}

// Rows of the space have seeds of their own, and so has each campaign as it is: the points of a row have the
// same persons, as have those of all slices.
std::uint64_t seed_of(const SensitivitySpec& spec, const Row& row) {
  const SensitivityPoint& first = row.points.front();
  if (first.design == "space") return spec.head.seed + 1 + first.row;
  if (first.design == "default") return spec.head.seed + 1 + spec.head.rows + first.row;
  return spec.head.seed;
}

// Why no take of a campaign can be evaluated; empty: some can.
std::string problem_of(const StudySpec& study, const Campaign& campaign, const Watch& watch) {
  try {
    make_plan(study, campaign, {watch.stop_requested, {}});
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

void evaluate_point(const SensitivitySpec& spec, std::uint64_t seed, const std::filesystem::path& scratch,
                    const Watch& watch, SensitivityPoint& point) {
  const std::size_t methods = spec.head.methods.size();
  point.paired_m.assign(spec.head.alignments.size() * methods * methods, kNoNumber);
  point.answered.assign(methods, kNoNumber);
  const SimulationSpec simulation = simulation_at(spec, point.position, seed);
  const Campaign campaign = simulate_campaign(simulation, scratch / "campaign", {watch.stop_requested, {}});
  point.problem = problem_of(spec.study, campaign, watch);
  if (point.problem.empty()) {
    const ResultsSummary summary =
        execute_study(spec.study, campaign, scratch / "results", {.stop_requested = watch.stop_requested});
    for (const TakeNote& note : summary.notes)
      if (note.failed && point.problem.empty()) point.problem = note.text;
    if (!summary.conditions.empty()) take_errors(scratch / "results", summary, point);
  }
  std::filesystem::remove_all(scratch);
}

Json evaluate_row(const SensitivitySpec& spec, Row row, std::uint64_t seed, const std::filesystem::path& into,
                  const Watch& watch) {
  Json points = Json::array();
  for (SensitivityPoint& point : row.points) {
    evaluate_point(spec, seed, into / "work", watch, point);
    points.push_back(json_of(point));
    watch.tell(static_cast<double>(points.size()) / static_cast<double>(row.points.size()));
  }
  return points;
}

Json work_json(const SensitivitySpec& spec) {
  Json work{{"study", resolved_json(spec.study)},
            {"simulation", spec.simulation},
            {"seed", spec.head.seed},
            {"participants", spec.head.participants},
            {"rows", spec.head.rows}};
  for (std::size_t f = 0; f < spec.head.factors.size(); ++f) {
    const SensitivityFactor& factor = spec.head.factors[f];
    work["space"].push_back({{"name", factor.name}, {"setting", factor.setting}, {"unit", factor.unit}});
    Json& entry = work["space"].back();
    if (!spec.values[f].empty())
      entry["values"] = spec.values[f];
    else
      entry.update(Json{{"low", factor.low},
                        {"high", factor.high},
                        {"logarithmic", factor.logarithmic},
                        {"whole", factor.whole}});
  }
  work["claims"] = Json::array();
  for (const SensitivityClaim& claim : spec.head.claims)
    work["claims"].push_back({{"name", claim.name},
                              {"better", claim.better},
                              {"than", claim.than},
                              {"margin_percent", claim.margin_percent}});
  for (const SpacePart& part : spec.head.parts)
    work["parts"].push_back(
        {{"name", part.name}, {"factor", part.factor}, {"low", part.low}, {"high", part.high}});
  work["slices"] = Json::array();
  for (const SensitivitySlice& slice : spec.head.slices)
    work["slices"].push_back({{"name", slice.name},
                              {"x", slice.x},
                              {"y", slice.y},
                              {"steps", slice.steps},
                              {"claims", slice.claims}});
  return work;
}

}  // namespace

// The study that was read, defaults included: what parse_sensitivity() takes.
Json resolved_json(const SensitivitySpec& spec) {
  Json work = work_json(spec), json = work.at("study");
  work.erase("study");
  json.update(work);
  json["kind"] = "sensitivity";
  return json;
}

std::size_t campaigns_of(const SensitivitySpec& spec) {
  std::size_t count = 0;
  for (const Row& row : rows_of(spec.head)) count += row.points.size();
  return count;
}

Study sensitivity_study(const SensitivitySpec& spec) {
  const auto shared = std::make_shared<const SensitivitySpec>(spec);
  const Json resolved = resolved_json(spec);
  Study study{.kind = name_of(StudyKind::sensitivity),
              .settings = resolved,
              .reduce =
                  [shared](const Outcomes& outcomes, const std::filesystem::path& results, const Watch&) {
                    SensitivitySummary summary = shared->head;
                    for (const Row& row : rows_of(summary)) {
                      const Outcome& outcome = outcomes.at(row.item);
                      for (const Json& point : outcome.json) {
                        const JsonObject object(point, outcome.place(), "");
                        summary.points.push_back(read_as<SensitivityPoint>(object));
                        summary.check(object);
                      }
                    }
                    analyse(summary);
                    write_sensitivity_summary(results, summary);
                  },
              .manifest = [resolved] { return manifest_of_generated(resolved); }};
  study.write_beside = [shared](const std::filesystem::path& folder) {
    const std::vector<double> as_it_is(shared->head.factors.size(), kNoNumber);
    write_declared_parameters(folder,
                              simulation_parameters(simulation_at(*shared, as_it_is, shared->head.seed)));
  };
  for (const Row& row : rows_of(spec.head)) {
    for (const SensitivityPoint& point : row.points) simulation_at(spec, point.position, spec.head.seed);
    study.items.push_back(
        {row.item, static_cast<double>(row.points.size()),
         [shared, row, seed = seed_of(spec, row)](const std::filesystem::path& into, const Watch& watch) {
           return evaluate_row(*shared, row, seed, into, watch);
         }});
  }
  return study;
}

}  // namespace trilat
