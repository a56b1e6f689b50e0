// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_totals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "pipeline/sweep/sweep_spec.h"

namespace trilat {

namespace {

void describe_digits(const SweepTotals& totals, SweepCell& cell) {
  const SweepCounts& counts = totals.counts;
  cell.digits_trials = counts.digit_bins.all();
  cell.mean_digits = totals.sum[SweepSums::digits].value() / static_cast<double>(cell.digits_trials);
  cell.p50_digits = std::clamp(bin_digits(counts.digit_bins.quantile(0.5)), counts.min_digits, kMostDigits);
  cell.min_digits = counts.min_digits;
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// JSON has no numbers that are not finite.
Json json_of(double number) {
  if (std::isfinite(number)) return number;
  return std::isnan(number) ? "nan" : number > 0.0 ? "inf" : "-inf";
}

double read_any_number(const Json& json, const JsonObject& object, const char* key) {
  if (json.is_number()) return json.get<double>();
  if (json == "nan") return std::nan("");
  if (json == "inf") return kInfinity;
  if (json == "-inf") return -kInfinity;
  object.refuse(key, "must be a number");
}

// Of each value that came: how far it is from the one before, and how often it came.
Json json_of(const Counts& counts) {
  Json json = Json::array();
  std::size_t before = 0;
  const std::vector<std::uint64_t>& of = counts.of_value();
  for (std::size_t value = 0; value < of.size(); ++value) {
    if (of[value] == 0) continue;
    json.push_back(value - before);
    json.push_back(of[value]);
    before = value;
  }
  return json;
}

const Json& read_list(JsonObject& object, const char* key) {
  const Json& list = object.value(key);
  if (!list.is_array()) object.refuse(key, "must be a list");
  return list;
}

Counts read_some_counts(JsonObject& object, const char* key, std::uint64_t values) {
  const Json& list = read_list(object, key);
  Counts counts;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < list.size(); i += 2) {
    if (i + 1 == list.size() || !list[i].is_number_unsigned() || !list[i + 1].is_number_unsigned())
      object.refuse(key, "must hold pairs of counts");
    const auto gap = list[i].get<std::uint64_t>();
    if (gap >= values - value) object.refuse(key, "has a value that is too large");
    value += gap;
    counts.add(value, list[i + 1].get<std::uint64_t>());
  }
  return counts;
}

ExactSum read_sum(const Json& parts, const JsonObject& object) {
  if (!parts.is_array()) object.refuse("sums", "must be lists of numbers");
  ExactSum sum;
  for (const Json& part : parts) sum.add(read_any_number(part, object, "sums"));
  return sum;
}

void read_statuses(JsonObject& object, SweepCounts& counts) {
  const Json& statuses = read_list(object, "statuses");
  if (statuses.size() != counts.statuses.size()) object.refuse("statuses", "must be one count a status");
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < counts.statuses.size(); ++i) {
    if (!statuses[i].is_number_unsigned()) object.refuse("statuses", "must be counts");
    all += counts.statuses[i] = statuses[i].get<std::uint64_t>();
  }
  if (all != counts.asked) object.refuse("statuses", "must sum to the trials asked");
}

}  // namespace

void SweepTotals::add(const SweepSums& chunk) {
  counts.add(chunk.counts);
  for (std::size_t term = 0; term < sum.size(); ++term) sum[term].add(chunk.sum[term]);
}

void SweepTotals::add(const SweepTotals& other) {
  counts.add(other.counts);
  for (std::size_t term = 0; term < sum.size(); ++term) sum[term].add(other.sum[term]);
}

SweepCell SweepTotals::cell() const {
  SweepCell cell;
  cell.asked = counts.asked;
  for (std::size_t i = 0; i < counts.statuses.size(); ++i) {
    if (counts.statuses[i] == 0) continue;
    cell.statuses[std::string(name_of(static_cast<SolveStatus>(i)))] = counts.statuses[i];
    if (is_usable(static_cast<SolveStatus>(i))) cell.answered += counts.statuses[i];
  }
  const auto mean = [&](SweepSums::Term term, std::uint64_t n) {
    return sum[term].value() / static_cast<double>(n);
  };
  if (counts.starts > 0) cell.start_mae_m = mean(SweepSums::start, counts.starts);
  if (cell.asked > 0) {
    cell.mean_iterations = mean(SweepSums::iterations, cell.asked);
    cell.p50_iterations = static_cast<double>(counts.iteration_counts.quantile(0.5));
    cell.p99_iterations = static_cast<double>(counts.iteration_counts.quantile(0.99));
    cell.max_iterations = static_cast<double>(counts.iteration_counts.quantile(1.0));
  }
  const std::uint64_t n = cell.answered;
  if (n == 0) return cell;
  cell.mae_m = mean(SweepSums::distance, n);
  cell.axis_mae_m = {mean(SweepSums::x, n), mean(SweepSums::y, n), mean(SweepSums::z, n)};
  const double mean_square_m2 = mean(SweepSums::square, n);
  cell.rmse_m = std::sqrt(mean_square_m2);
  if (n > 1)
    cell.mae_standard_error_m =
        std::sqrt(std::max(0.0, mean_square_m2 - cell.mae_m * cell.mae_m) / (static_cast<double>(n) - 1.0));
  cell.p50_m = std::min(counts.max_m, bin_distance_m(counts.distance_bins.quantile(0.5)));
  cell.p95_m = std::min(counts.max_m, bin_distance_m(counts.distance_bins.quantile(0.95)));
  cell.max_m = counts.max_m;
  if (counts.digit_bins.all() > 0) describe_digits(*this, cell);
  return cell;
}

Json json_of(const SweepTotals& totals) {
  const SweepCounts& counts = totals.counts;
  Json sums = Json::array();
  for (const ExactSum& sum : totals.sum) {
    sums.push_back(Json::array());
    for (const double part : sum.parts()) sums.back().push_back(json_of(part));
  }
  return {{"asked", counts.asked},
          {"statuses", counts.statuses},
          {"starts", counts.starts},
          {"max_m", json_of(counts.max_m)},
          {"min_digits", counts.min_digits},
          {"sums", sums},
          {"distance_bins", json_of(counts.distance_bins)},
          {"iterations", json_of(counts.iteration_counts)},
          {"digit_bins", json_of(counts.digit_bins)}};
}

SweepTotals read_sweep_totals(JsonObject object) {
  SweepTotals totals;
  SweepCounts& counts = totals.counts;
  counts.asked = object.count("asked");
  read_statuses(object, counts);
  counts.starts = object.count("starts");
  counts.max_m = read_any_number(object.value("max_m"), object, "max_m");
  counts.min_digits = object.number("min_digits");
  const Json& sums = read_list(object, "sums");
  if (sums.size() != totals.sum.size()) object.refuse("sums", "must be one list a term");
  for (std::size_t term = 0; term < totals.sum.size(); ++term)
    totals.sum[term] = read_sum(sums[term], object);
  counts.distance_bins = read_some_counts(object, "distance_bins", kDistanceBins);
  counts.iteration_counts = read_some_counts(object, "iterations", kMostSweepIterations + 1);
  counts.digit_bins = read_some_counts(object, "digit_bins", kDigitBins);
  object.finish();
  return totals;
}

}  // namespace trilat
