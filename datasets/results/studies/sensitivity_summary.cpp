// SPDX-License-Identifier: MIT
#include "datasets/results/studies/sensitivity_summary.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/csv_field.h"
#include "datasets/base/files.h"
#include "datasets/base/text_output.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

Json json_of(const Estimate& e) { return {e.value, e.low, e.high}; }

Estimate read_estimate(JsonObject& object, const std::string& key) {
  const std::vector<double> e = object.numbers_or_none(key, 3);
  return {e[0], e[1], e[2]};
}

Json json_of(const SensitivityFactor& f) {
  return {{"name", f.name}, {"unit", f.unit}, {"setting", f.setting},         {"values", f.values},
          {"low", f.low},   {"high", f.high}, {"logarithmic", f.logarithmic}, {"whole", f.whole}};
}

SensitivityFactor read_factor(JsonObject object) {
  SensitivityFactor f;
  f.name = object.text("name");
  f.unit = object.text("unit");
  f.setting = object.text("setting");
  f.values = object.texts("values");
  f.low = number_or_nan(object, "low");
  f.high = number_or_nan(object, "high");
  f.logarithmic = object.boolean("logarithmic", false);
  f.whole = object.boolean("whole", false);
  object.finish();
  return f;
}

Json json_of(const ClaimByFactor& f) {
  Json bins = Json::array();
  for (const ClaimByFactor::Bin& bin : f.bins)
    bins.push_back({{"position", bin.position},
                    {"difference_percent", json_of(bin.difference_percent)},
                    {"share", json_of(bin.share)}});
  return {{"factor", f.factor},
          {"first", json_of(f.first)},
          {"total", json_of(f.total)},
          {"break_even", json_of(f.break_even)},
          {"bins", bins}};
}

ClaimByFactor read_by_factor(JsonObject object) {
  ClaimByFactor f;
  f.factor = object.text("factor");
  f.first = read_estimate(object, "first");
  f.total = read_estimate(object, "total");
  f.break_even = read_estimate(object, "break_even");
  for (JsonObject& bin : object.objects("bins")) {
    f.bins.push_back(
        {bin.number("position"), read_estimate(bin, "difference_percent"), read_estimate(bin, "share")});
    bin.finish();
  }
  object.finish();
  return f;
}

Json json_of(const SensitivityClaim& c) {
  Json factors = Json::array();
  for (const ClaimByFactor& factor : c.factors) factors.push_back(json_of(factor));
  return {{"name", c.name},
          {"better", c.better},
          {"than", c.than},
          {"margin_percent", c.margin_percent},
          {"silent", c.silent},
          {"share", json_of(c.share)},
          {"difference_percent", json_of(c.difference_percent)},
          {"worst_percent", c.worst_percent},
          {"default_percent", json_of(c.default_percent)},
          {"factors", factors}};
}

SensitivityClaim read_claim(JsonObject object) {
  SensitivityClaim c;
  c.name = object.text("name");
  c.better = object.text("better");
  c.than = object.texts("than");
  c.margin_percent = object.number("margin_percent");
  c.silent = object.count("silent");
  c.share = read_estimate(object, "share");
  c.difference_percent = read_estimate(object, "difference_percent");
  c.worst_percent = number_or_nan(object, "worst_percent");
  c.default_percent = read_estimate(object, "default_percent");
  for (JsonObject& factor : object.objects("factors")) c.factors.push_back(read_by_factor(factor));
  object.finish();
  return c;
}

SensitivitySlice read_slice(JsonObject object) {
  SensitivitySlice slice{object.text("name"), object.text("x"), object.text("y"), object.count("steps"),
                         object.texts("claims")};
  object.finish();
  return slice;
}

void write_points(const std::filesystem::path& path, const SensitivitySummary& s) {
  TextOutput text(path);
  text.add("design,row");
  for (const SensitivityFactor& factor : s.factors) text.add(",{}", csv_field(factor.name));
  text.add(",method,mae_m,answered,problem\n");
  for (const SensitivityPoint& point : s.points)
    for (std::size_t m = 0; m < s.methods.size(); ++m) {
      text.add("{},{}", csv_field(point.design), point.row);
      for (std::size_t f = 0; f < s.factors.size(); ++f)
        text.add(",{}", std::isfinite(point.position[f]) ? csv_field(s.text_at(f, point.position[f])) : "");
      text.add(",{}", csv_field(s.methods[m]));
      for (const double number : {point.paired_m[m * s.methods.size() + m], point.answered[m]})
        if (std::isfinite(number))
          text.add(",{:.9g}", number);
        else
          text.add(",");
      text.add(",{}\n", csv_field(point.problem));
    }
  text.publish();
}

}  // namespace

double SensitivitySummary::value_at(std::size_t factor, double position) const {
  const SensitivityFactor& f = factors[factor];
  if (!f.values.empty()) {
    const auto count = static_cast<double>(f.values.size());
    return std::min(std::floor(position * count), count - 1.0);
  }
  if (f.whole) return std::min(f.low + std::floor(position * (f.high - f.low + 1.0)), f.high);
  if (f.logarithmic) return f.low * std::pow(f.high / f.low, position);
  return f.low + position * (f.high - f.low);
}

std::string SensitivitySummary::text_at(std::size_t factor, double position) const {
  const double value = value_at(factor, position);
  if (factors[factor].values.empty()) return fmt::format("{:.4g}", value);
  return factors[factor].values[static_cast<std::size_t>(value)];
}

Json json_of(const SensitivityPoint& p) {
  return {{"design", p.design},     {"row", p.row},           {"position", p.position},
          {"paired_m", p.paired_m}, {"answered", p.answered}, {"problem", p.problem}};
}

SensitivityPoint read_sensitivity_point(JsonObject object, std::size_t factors, std::size_t methods) {
  SensitivityPoint p;
  p.design = object.text("design");
  p.row = object.count("row");
  p.position = object.numbers_or_none("position", factors);
  p.paired_m = object.numbers_or_none("paired_m", methods * methods);
  p.answered = object.numbers_or_none("answered", methods);
  p.problem = object.text("problem");
  object.finish();
  return p;
}

double difference_percent(const SensitivityClaim& claim, const std::vector<std::string>& methods,
                          const SensitivityPoint& point) {
  const auto paired_m = [&](const std::string& method, const std::string& with) {
    const auto index = [&](const std::string& name) {
      return static_cast<std::size_t>(std::ranges::find(methods, name) - methods.begin());
    };
    return point.paired_m[index(method) * methods.size() + index(with)];
  };
  double most = kNoNumber;
  for (const std::string& name : claim.than)
    most = std::fmax(most, paired_m(claim.better, name) / paired_m(name, claim.better));
  return 100.0 * (most / (1.0 + 0.01 * claim.margin_percent) - 1.0);
}

void write_sensitivity_summary(const std::filesystem::path& folder, const SensitivitySummary& s) {
  Json json = results_head(StudyKind::sensitivity);
  json.update({{"study", s.study},
               {"simulated", true},
               {"alignment", s.alignment},
               {"seed", s.seed},
               {"participants", s.participants},
               {"rows", s.rows},
               {"methods", s.methods},
               {"factors", Json::array()},
               {"slices", Json::array()},
               {"claims", Json::array()},
               {"best_share", Json::array()},
               {"points", Json::array()}});
  for (const SensitivityFactor& factor : s.factors) json["factors"].push_back(json_of(factor));
  for (const SensitivitySlice& slice : s.slices)
    json["slices"].push_back({{"name", slice.name},
                              {"x", slice.x},
                              {"y", slice.y},
                              {"steps", slice.steps},
                              {"claims", slice.claims}});
  for (const SensitivityClaim& claim : s.claims) json["claims"].push_back(json_of(claim));
  for (const Estimate& share : s.best_share) json["best_share"].push_back({{"share", json_of(share)}});
  for (const SensitivityPoint& point : s.points) json["points"].push_back(json_of(point));
  write_points(folder / "points.csv", s);
  write_file(folder / "summary.json", json_text(json, 1) + "\n");
}

SensitivitySummary read_sensitivity_summary(const std::filesystem::path& folder) {
  const Json json = read_results_json(folder);
  JsonObject object(json, (folder / "summary.json").string(), "");
  check_results_head(object, StudyKind::sensitivity);
  SensitivitySummary s;
  s.study = object.text("study");
  object.boolean("simulated", true);
  s.alignment = object.text("alignment");
  s.seed = object.count("seed");
  s.participants = object.count("participants");
  s.rows = object.count("rows");
  s.methods = object.texts("methods");
  for (JsonObject& factor : object.objects("factors")) s.factors.push_back(read_factor(factor));
  for (JsonObject& slice : object.objects("slices")) s.slices.push_back(read_slice(slice));
  for (JsonObject& claim : object.objects("claims")) s.claims.push_back(read_claim(claim));
  for (JsonObject& share : object.objects("best_share")) {
    s.best_share.push_back(read_estimate(share, "share"));
    share.finish();
  }
  for (JsonObject& point : object.objects("points"))
    s.points.push_back(read_sensitivity_point(point, s.factors.size(), s.methods.size()));
  object.finish();
  return s;
}

}  // namespace trilat
