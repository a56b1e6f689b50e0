// SPDX-License-Identifier: MIT
#include "datasets/results/studies/budget_summary.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"

namespace trilat {

BudgetRow read_budget_row(JsonObject object) {
  BudgetRow row;
  row.source = object.text("source");
  row.method = object.text("method");
  row.condition = object.text("condition");
  row.group = object.text("group");
  row.alignment = object.text("alignment");
  row.n = object.count("n");
  row.rmse_m = number_or_nan(object, "rmse_m");
  row.mae_m = number_or_nan(object, "mae_m");
  object.finish();
  return row;
}

Json json_of(const BudgetRow& row) {
  return {{"source", row.source}, {"method", row.method},       {"condition", row.condition},
          {"group", row.group},   {"alignment", row.alignment}, {"n", row.n},
          {"rmse_m", row.rmse_m}, {"mae_m", row.mae_m}};
}

void write_budget_summary(const std::filesystem::path& folder, const BudgetSummary& s) {
  Json json = results_head(StudyKind::error_budget);
  json.update({{"study", s.study},
               {"campaign", s.campaign},
               {"simulated", true},
               {"seed", s.seed},
               {"participants", s.participants},
               {"calibration_sigma_m", s.calibration_sigma_m},
               {"calibration_sigma_rad", s.calibration_sigma_rad},
               {"sources", s.sources},
               {"descriptions", s.descriptions},
               {"rows", Json::array()}});
  for (const BudgetRow& row : s.rows) json["rows"].push_back(json_of(row));
  write_file(folder / "summary.json", json_text(json, 1) + "\n");
}

BudgetSummary read_budget_summary(const std::filesystem::path& folder) {
  const Json json = read_results_json(folder);
  JsonObject object(json, (folder / "summary.json").string(), "");
  check_results_head(object, StudyKind::error_budget);
  BudgetSummary s;
  s.study = object.text("study");
  s.campaign = object.text("campaign");
  object.boolean("simulated", true);
  s.seed = object.count("seed");
  s.participants = object.count("participants");
  s.calibration_sigma_m = object.number("calibration_sigma_m");
  s.calibration_sigma_rad = object.number("calibration_sigma_rad");
  s.sources = object.texts("sources");
  s.descriptions = object.texts("descriptions");
  if (s.descriptions.size() != s.sources.size())
    object.refuse("descriptions", "must be as many as the sources");
  for (JsonObject& row : object.objects("rows")) {
    s.rows.push_back(read_budget_row(row));
    const std::string& source = s.rows.back().source;
    if (std::find(s.sources.begin(), s.sources.end(), source) == s.sources.end())
      row.refuse("source", "is \"" + source + "\", which is none of the sources");
  }
  object.finish();
  return s;
}

}  // namespace trilat
