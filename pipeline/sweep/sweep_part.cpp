// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_part.h"

#include <nlohmann/json.hpp>

#include "datasets/base/build_id.h"
#include "pipeline/sweep/sweep_runner.h"

namespace trilat {

// The study has its ranges rounded for people.
WorkPart part_of(const SweepPlan& plan, const Shard& shard) {
  Json ranges_m = Json::array();
  for (const auto& range : plan.spec.ranges) ranges_m.push_back({range.low_m, range.high_m});
  const Json work{
      {"study", resolved_json(plan.spec)}, {"ranges_m", ranges_m}, {"chunk_trials", kChunkTrials}};
  return {kSweepPart, build_id(), shard.number, shard.of, work, {}};
}

SweepPlan plan_of(const WorkPart& part, const std::string& place) {
  JsonObject object(part.work, place, "/work");
  SweepSpec spec = parse_sweep(object.value("study"), place);
  const Json& ranges_m = object.value("ranges_m");
  if (!ranges_m.is_array() || ranges_m.size() != spec.ranges.size())
    object.refuse("ranges_m", "must be one range for each of the study's");
  for (std::size_t i = 0; i < spec.ranges.size(); ++i) {
    const Json& range = ranges_m[i];
    if (!range.is_array() || range.size() != 2 || !range[0].is_number() || !range[1].is_number())
      object.refuse("ranges_m", "must be pairs of numbers");
    spec.ranges[i] = {range[0].get<double>(), range[1].get<double>()};
  }
  if (object.count("chunk_trials") != kChunkTrials)
    object.refuse("chunk_trials", "must be " + std::to_string(kChunkTrials));
  object.finish();
  return make_sweep_plan(spec, place);
}

}  // namespace trilat
