// SPDX-License-Identifier: MIT
#include "pipeline/twins/twins_study.h"

#include <array>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/settings.h"
#include "datasets/base/units.h"
#include "datasets/results/results_file.h"
#include "datasets/results/studies/twins_summary.h"
#include "datasets/synthetic/recorded_pairs.h"
#include "evaluators/metrics/error_statistics.h"
#include "pipeline/calibration/calibrate_bodies.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/simulate/simulate_take.h"
#include "pipeline/tracker/watched_takes.h"

namespace trilat {
namespace {

constexpr double kSimulating = 0.8;  // share of the time

std::string item_of(const RecordedPairs::Pair& pair) { return fmt::format("{:g}-degrees", pair.degrees); }

SimulationSpec simulation_of(const TwinsSpec& spec, const RecordedPairs::Pair& pair) {
  const RecordedPairs& recorded = recorded_pairs();
  SimulationSpec simulation;
  simulation.name = pair.name;
  simulation.seed = spec.seed;
  simulation.participants = spec.participants;
  simulation.body_tracker = spec.body_tracker;
  for (const RecordedPairs::Activity& activity : recorded.activities)
    simulation.activities.push_back({activity.simulated, activity.duration_s, {Joint::head}});
  simulation.rig.radius_m = recorded.distance_m;
  simulation.rig.heights_m = {recorded.height_m, recorded.height_m};
  simulation.rig.arc_rad = 2.0 * pair.degrees * kRadPerDegree;  // two halves, a sensor in the middle of each
  simulation.rig.arc_start_rad = -0.5 * pair.degrees * kRadPerDegree;
  return simulation;
}

// Sensors stand where the bodies of the participant's last activity put them.
void place_by_bodies(const std::filesystem::path& folder, Campaign& campaign, const Watch& watch) {
  std::map<std::string, std::filesystem::path> calibration;  // by participant
  for (const Take& take : campaign.takes) calibration[take.participant] = take.session;
  for (auto& [participant, path] : calibration) {
    const BodyCalibration placed = calibrate_bodies(path, {.stop_requested = watch.stop_requested});
    path = folder / (participant + ".json");
    write_calibration(path, placed.calibration);
  }
  for (Take& take : campaign.takes) {
    take.calibration = calibration.at(take.participant);
    take.mocap.clear();
    take.mapping.clear();
    take.tracker_truth.clear();
  }
}

// Distances between the joints of both sensors, by joint group.
std::map<std::string, std::vector<double>> distances_of(const WatchedTake& take) {
  std::map<std::string, std::vector<double>> distances_m;
  for (std::size_t i = 0; i < take.bodies.instants(); ++i)
    for (const JointGroup& group : joint_groups())
      for (const Joint joint : group.joints) {
        const ObservedBody &a = take.bodies.at(i, 0), &b = take.bodies.at(i, 1);
        if (a.has(joint) && b.has(joint))
          distances_m[std::string(group.name)].push_back(
              (take.world_from_sensor[0] * a.at(joint) - take.world_from_sensor[1] * b.at(joint)).norm());
      }
  return distances_m;
}

Json measure_pair(const TwinsSpec& spec, const RecordedPairs::Pair& pair, const std::filesystem::path& work,
                  const Watch& watch) {
  Campaign campaign = simulate_campaign(simulation_of(spec, pair), work,
                                        {watch.stop_requested, share_of(watch.progress, 0.0, kSimulating)});
  place_by_bodies(work, campaign, watch);
  const WatchedCampaign watched = read_watched_takes(
      campaign, {watch.stop_requested, share_of(watch.progress, kSimulating, 1.0 - kSimulating)});
  if (!watched.left_out.empty())
    throw InputError(pair.name, "has a take that cannot be measured: " + watched.left_out.front());
  // By activity and group: a quantile of every participant.
  std::map<std::pair<std::string, std::string>, std::array<std::vector<double>, 3>> quantiles_m;
  for (std::size_t t = 0; t < watched.takes.size(); ++t)
    for (auto& [group, distances_m] : distances_of(watched.takes[t])) {
      auto& cell =
          quantiles_m[{recorded_pairs().activities[t % recorded_pairs().activities.size()].name, group}];
      const std::vector<double> found_m = quantiles_of(distances_m, {0.5, 0.9, 0.99});
      for (std::size_t k = 0; k < found_m.size(); ++k) cell[k].push_back(found_m[k]);
    }
  Json rows = Json::array();
  for (auto& [where, cell] : quantiles_m) {
    const auto middle = [&](std::size_t k) { return quantiles_of(cell[k], {0.5})[0]; };
    rows.push_back(
        json_of(PairQuantiles{pair.name, where.first, where.second, middle(0), middle(1), middle(2)}));
  }
  std::filesystem::remove_all(work);
  return rows;
}

TwinsSummary summarise(const TwinsSpec& spec, const Outcomes& outcomes) {
  TwinsSummary summary{spec.name, recorded_pairs().source, spec.seed, spec.participants, {}};
  std::map<std::array<std::string, 3>, PairQuantiles> simulated;
  for (const RecordedPairs::Pair& pair : recorded_pairs().pairs) {
    const Outcome& outcome = outcomes.at(item_of(pair));
    for (const Json& json : outcome.json()) {
      const auto row = read_as<PairQuantiles>(JsonObject(json, outcome.place(), ""));
      simulated[{row.pair, row.activity, row.group}] = row;
    }
  }
  for (const RecordedPairs::Set& set : recorded_pairs().sets)
    for (const PairQuantiles& r : set.rows)
      if (const auto s = simulated.find({r.pair, r.activity, r.group}); s != simulated.end())
        summary.rows.push_back({set.name, r.pair, r.activity, r.group, r.q50_m, r.q90_m, r.q99_m,
                                s->second.q50_m, s->second.q90_m, s->second.q99_m});
  return summary;
}

}  // namespace

TwinsSpec parse_twins(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  TwinsSpec spec;
  object.format("trilat.study");
  object.choice("kind", {name_of(StudyKind::twins)});
  spec.name = object.text("name");
  setting(object, "seed", spec.seed, "of every random number");
  setting(object, "participants", spec.participants, {1, 1000}, "simulated persons of each pair");
  if (object.has("body_tracker")) {
    spec.body_tracker_json = object.value("body_tracker");
    spec.body_tracker = read_body_tracker(object);
  }
  object.about(
      {{"name", "of the study"}, {"body_tracker", "errors of the simulated tracker, as in simulation.json"}});
  object.finish();
  return spec;
}

Json resolved_json(const TwinsSpec& spec) {
  Json json{{"format", "trilat.study"}, {"version", 1},      {"kind", name_of(StudyKind::twins)},
            {"name", spec.name},        {"seed", spec.seed}, {"participants", spec.participants}};
  if (!spec.body_tracker_json.empty()) json["body_tracker"] = spec.body_tracker_json;
  return json;
}

Study twins_study(const TwinsSpec& spec) {
  const Json resolved = resolved_json(spec);
  Study study{.kind = name_of(StudyKind::twins),
              .work = resolved,
              .write_beside =
                  [spec](const std::filesystem::path& folder) {
                    write_declared_parameters(
                        folder, simulation_parameters(simulation_of(spec, recorded_pairs().pairs[0])));
                  },
              .reduce = [spec](const Outcomes& outcomes, const std::filesystem::path& results,
                               const Watch&) { write_results(results, summarise(spec, outcomes)); },
              .manifest = [resolved](const Outcomes&) { return manifest_of_generated(resolved); }};
  for (const RecordedPairs::Pair& pair : recorded_pairs().pairs)
    study.items.push_back(
        {item_of(pair), 1.0, [spec, pair](const std::filesystem::path& into, const Watch& watch) {
           return measure_pair(spec, pair, into / "work", watch);
         }});
  return study;
}

}  // namespace trilat
