// SPDX-License-Identifier: MIT
#include "datasets/results/sweep_search_json.h"

#include <nlohmann/json.hpp>

#include "datasets/results/results_file.h"

namespace trilat {
namespace {

Json json_of(const SweepFit& fit) {
  return {{"interpretation", fit.interpretation},
          {"reported", fit.reported},
          {"rms_log_ratio", fit.rms_log_ratio},
          {"worst_factor", fit.worst_factor},
          {"us_per_iteration", fit.us_per_iteration}};
}

Json json_of(const SweepRanking& ranking) {
  Json json{{"ranked", ranking.ranked},
            {"best_rms", ranking.best_rms},
            {"median_rms", ranking.median_rms},
            {"worst_rms", ranking.worst_rms},
            {"best", Json::array()}};
  for (const SweepFit& fit : ranking.best) json["best"].push_back(json_of(fit));
  return json;
}

Json json_of(const SweepCompromise& c) {
  return {{"best_for", c.best_for},
          {"printed", c.printed},
          {"corrected", c.corrected},
          {"printed_iterations_factor", c.printed_iterations_factor},
          {"corrected_iterations_factor", c.corrected_iterations_factor},
          {"printed_error_factor", c.printed_error_factor},
          {"corrected_error_factor", c.corrected_error_factor},
          {"printed_coverage", c.printed_coverage},
          {"corrected_coverage", c.corrected_coverage}};
}

std::size_t read_index(JsonObject& object, const std::string& key, std::size_t interpretations) {
  const std::uint64_t index = object.count(key);
  if (index >= interpretations) object.refuse(key, "is the number of no interpretation");
  return index;
}

SweepFit read_fit(JsonObject& object, std::size_t interpretations) {
  SweepFit fit;
  fit.interpretation = read_index(object, "interpretation", interpretations);
  fit.reported = object.text("reported");
  fit.rms_log_ratio = object.number("rms_log_ratio");
  fit.worst_factor = object.number("worst_factor");
  fit.us_per_iteration = number_or_nan(object, "us_per_iteration");
  object.finish();
  return fit;
}

SweepRanking read_ranking(JsonObject object, std::size_t interpretations) {
  SweepRanking ranking;
  ranking.ranked = object.count("ranked");
  ranking.best_rms = number_or_nan(object, "best_rms");
  ranking.median_rms = number_or_nan(object, "median_rms");
  ranking.worst_rms = number_or_nan(object, "worst_rms");
  for (JsonObject& fit : object.objects("best")) ranking.best.push_back(read_fit(fit, interpretations));
  object.finish();
  return ranking;
}

std::vector<double> read_factors(JsonObject& object, const std::string& key, std::size_t ranges) {
  const Json& values = object.value(key);
  if (!values.is_array() || values.empty() || values.size() != ranges)
    object.refuse(key, "must be an array of a number for each range");
  std::vector<double> factors;
  for (const Json& value : values)
    factors.push_back(value.is_number() ? value.get<double>() : SweepCell::kNone);
  return factors;
}

SweepCompromise read_compromise(JsonObject& object, std::size_t interpretations, std::size_t ranges) {
  SweepCompromise c;
  c.best_for = object.text("best_for");
  c.printed = read_index(object, "printed", interpretations);
  c.corrected = read_index(object, "corrected", interpretations);
  c.printed_iterations_factor = read_factors(object, "printed_iterations_factor", ranges);
  c.corrected_iterations_factor = read_factors(object, "corrected_iterations_factor", ranges);
  c.printed_error_factor = read_factors(object, "printed_error_factor", ranges);
  c.corrected_error_factor = read_factors(object, "corrected_error_factor", ranges);
  c.printed_coverage = number_or_nan(object, "printed_coverage");
  c.corrected_coverage = number_or_nan(object, "corrected_coverage");
  object.finish();
  return c;
}

}  // namespace

Json json_of(const SweepSearch& search) {
  Json json{{"tried", search.tried},
            {"errors", json_of(search.errors)},
            {"times", json_of(search.times)},
            {"compromises", Json::array()}};
  for (const SweepCompromise& c : search.compromises) json["compromises"].push_back(json_of(c));
  return json;
}

SweepSearch read_search(JsonObject object, std::size_t interpretations, std::size_t ranges) {
  SweepSearch search;
  search.tried = object.count("tried");
  search.errors = read_ranking(object.object("errors"), interpretations);
  search.times = read_ranking(object.object("times"), interpretations);
  for (JsonObject& c : object.objects("compromises"))
    search.compromises.push_back(read_compromise(c, interpretations, ranges));
  object.finish();
  return search;
}

}  // namespace trilat
