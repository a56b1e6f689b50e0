// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/wand_samples.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "datasets/session/session_types.h"
#include "datasets/synthetic/depth/room_scene.h"
#include "datasets/synthetic/generated_person.h"
#include "evaluators/calibration/wand_positions.h"
#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/metrics/quantiles.h"
#include "evaluators/wand/find_wand.h"
#include "evaluators/wand/printed_wand.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr double kNearest_m = 0.3;
constexpr double kNearDensity = 3.0;
constexpr double kSensorHeight_m = 1.2;
constexpr double kPersonBehind_m = 1.2;
constexpr double kFarWall_m = 7.0;

const PrintedCalibration& paper() {
  static const PrintedCalibration printed = printed_calibration();
  return printed;
}

struct Variant {
  const char* name;
  bool printed_method = true;
  PrintedWandOptions printed = {};
};

std::vector<Variant> variants(double ball_radius_m) {
  PrintedWandOptions corrected{Reading::corrected, Binarisation::corrected, Reading::corrected,
                               Reading::corrected};
  corrected.ball_radius_m = ball_radius_m;
  PrintedWandOptions printed;
  printed.ball_radius_m = ball_radius_m;
  PrintedWandOptions clamped = corrected, e1 = corrected, e2 = corrected, e3 = corrected,
                     mid_range = corrected;
  clamped.invalid_pixels = Reading::printed;
  e1.binarisation = Binarisation::printed;
  e2.projection = Reading::printed;
  e3.centre = Reading::printed;
  mid_range.binarisation = Binarisation::mid_range;
  return {{"as printed", true, printed},
          {"corrected, but eq. 1 as printed", true, clamped},
          {"corrected, but E1 as printed", true, e1},
          {"corrected, but E2 as printed", true, e2},
          {"corrected, but E3 as printed", true, e3},
          {"corrected", true, corrected},
          {"corrected by the mid-range", true, mid_range},
          {"ours", false, {}}};
}

// Before a far wall the ball hangs alone, which is where the paper's way can work at all: eq. 2 keeps what is
// nearer than half of the mean depth.
enum class Scene { far_wall, room };

struct Sample {
  double distance_m, angle_rad;
  Eigen::Vector3d ball_in_sensor_m;
  bool near;
};

// Below which distance a share (0 to 1) of the samples lies. The part of the span that is nearer than the
// recommended range is short, so its places are drawn kNearDensity times as densely.
double span_distance_m(const CalibrationSpec& spec, double share) {
  const double from_m = spec.distances_m[0], to_m = spec.distances_m[1];
  const double knee_m = std::clamp(paper().recommended_m[0], from_m, to_m);
  const double near = kNearDensity * (knee_m - from_m), near_share = near / (near + to_m - knee_m);
  return share < near_share ? from_m + share / near_share * (knee_m - from_m)
                            : knee_m + (share - near_share) / (1.0 - near_share) * (to_m - knee_m);
}

// Each sample of a unit has its own part of the span, so that no unit leaves one out. Directions lie within
// 15 degrees of the horizontal plane through the lens, to both sides.
Sample draw_sample(const CalibrationSpec& spec, std::uint64_t unit, std::uint64_t index, bool near) {
  const RandomStream random{spec.seed, Purpose::wand_sample, random_item(near ? 1 : 0, unit, 0, index)};
  Sample sample;
  sample.near = near;
  sample.distance_m = near ? random.uniform(0, kNearest_m, paper().near_m)
                           : span_distance_m(spec, (static_cast<double>(index) + random.uniform(0)) /
                                                       static_cast<double>(spec.samples));
  sample.angle_rad = random.uniform(
      1, 0.0, near ? paper().recommended_below_deg * kRadPerDegree : spec.largest_angle_deg * kRadPerDegree);
  const double tilt_rad =
      random.uniform(2, -15.0, 15.0) * kRadPerDegree + (random.uniform(3) < 0.5 ? std::numbers::pi : 0.0);
  const double sine = std::sin(sample.angle_rad);
  sample.ball_in_sensor_m =
      sample.distance_m *
      Eigen::Vector3d(sine * std::cos(tilt_rad), sine * std::sin(tilt_rad), std::cos(sample.angle_rad));
  return sample;
}

// The sensor looks along the world's z from the height of a table.
RigidTransform world_from_sensor() { return {Eigen::Quaterniond::Identity(), {0.0, kSensorHeight_m, 0.0}}; }

DepthScene scene_of(Scene kind, const Eigen::Vector3d& ball_in_world_m, double ball_radius_m) {
  DepthScene scene;
  if (kind == Scene::far_wall) {
    scene.spheres.push_back({ball_in_world_m, ball_radius_m});
    scene.planes.push_back({-Eigen::Vector3d::UnitZ(), -kFarWall_m});
    return scene;
  }
  // The stick comes from behind, from the right hand of somebody who stands there.
  SkeletonPose person = generated_motion(Person{}, Activity::standing)(0.0);
  const Eigen::Vector3d away(ball_in_world_m.x(), 0.0, ball_in_world_m.z());
  const Eigen::Vector3d stand_m = away + kPersonBehind_m * away.normalized() - person.at(Joint::spine_base);
  for (Eigen::Vector3d& joint : person.joint_in_world_m)
    joint += Eigen::Vector3d(stand_m.x(), 0.0, stand_m.z());
  append_wand(scene, ball_in_world_m, (person.at(Joint::hand_right) - ball_in_world_m).normalized(),
              {.ball_radius_m = ball_radius_m});
  append_person(scene, person);
  append_room(scene, RoomSpec{}, {0.0, 0.0, 2.5});
  return scene;
}

struct SampleOutcome {
  // by variant; errors are NaN without an answer
  std::vector<double> error_m;
  std::vector<double> distance_error_m;
  std::vector<std::string> status;
  TRILAT_FIELDS(error_m, distance_error_m, status)
};

// Outcomes of one unit: sample by sample, in each the far wall first.
struct UnitOutcomes {
  std::vector<SampleOutcome> images;
  TRILAT_FIELDS(images)
};

// The mean of the frames in which the ball was found, when it was in at least half of them.
void conclude(const std::vector<std::vector<WandSighting>>& sightings, const Sample& sample,
              SampleOutcome& outcome) {
  for (const std::vector<WandSighting>& frames : sightings) {
    std::vector<TimedSighting> found;
    WandStatus failure = WandStatus::no_wand;
    for (const WandSighting& sighting : frames)
      if (sighting.status == WandStatus::found)
        found.push_back({HostTime{static_cast<std::int64_t>(found.size())}, sighting});
      else
        failure = sighting.status;
    const bool answered = 2 * found.size() >= frames.size();
    outcome.status.push_back(name_of(answered ? WandStatus::found : failure));
    const Eigen::Vector3d centre_m =
        answered ? mean_of_rest(found, 0, WandPositionOptions{}.deviation).centre_in_sensor_m
                 : Eigen::Vector3d::Constant(ErrorSpread::kNone);
    outcome.error_m.push_back((centre_m - sample.ball_in_sensor_m).norm());
    outcome.distance_error_m.push_back(std::abs(centre_m.norm() - sample.ball_in_sensor_m.norm()));
  }
}

SampleOutcome measure(const CalibrationSpec& spec, const StudyUnit& unit, std::uint64_t unit_number,
                      const Sample& sample, std::uint64_t index, Scene kind,
                      const std::vector<Variant>& methods) {
  const DepthScene scene = scene_of(kind, world_from_sensor() * sample.ball_in_sensor_m, spec.ball_radius_m);
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  std::vector<std::vector<WandSighting>> sightings(methods.size());
  FindWandOptions ours;
  ours.ball_radius_m = spec.ball_radius_m;
  for (std::uint64_t frame = 0; frame < spec.frames; ++frame) {
    const auto part = static_cast<std::uint64_t>(kind) * 2 + (sample.near ? 1 : 0);
    const RandomStream key{spec.seed, Purpose::depth_pixel,
                           random_item(2, unit_number, part, index * spec.frames + frame)};
    unit.renderer.render(scene, world_from_sensor(), key, depth_mm);
    const DepthImageView image{kDepthWidth, kDepthHeight, depth_mm};
    for (std::size_t m = 0; m < methods.size(); ++m)
      sightings[m].push_back(methods[m].printed_method
                                 ? find_wand_as_printed(image, unit.rays, methods[m].printed)
                                 : find_wand(image, unit.rays, ours));
  }
  SampleOutcome outcome;
  conclude(sightings, sample, outcome);
  return outcome;
}

bool is_recommended(const Sample& sample) {
  return !sample.near && sample.distance_m >= paper().recommended_m[0] &&
         sample.distance_m <= paper().recommended_m[1] &&
         sample.angle_rad < paper().recommended_below_deg * kRadPerDegree;
}

std::string wand_item(std::uint64_t unit) { return fmt::format("wand/unit-{}", unit); }

std::vector<Sample> draw_samples(const CalibrationSpec& spec, std::uint64_t unit) {
  std::vector<Sample> samples;
  for (std::uint64_t i = 0; i < spec.samples + spec.near_samples; ++i)
    samples.push_back(draw_sample(spec, unit, i, i >= spec.samples));
  return samples;
}

std::vector<SampleOutcome> measure_samples(const CalibrationSpec& spec, std::uint64_t number,
                                           const Watch& watch) {
  const std::vector<Variant> methods = variants(spec.ball_radius_m);
  const StudyUnit unit = draw_study_unit(spec.seed, number);
  const std::vector<Sample> samples = draw_samples(spec, number);
  std::vector<SampleOutcome> outcomes(2 * samples.size());
  std::atomic<std::size_t> done{0};
  parallel_for_index(outcomes.size(), 1, [&](std::size_t k) {
    watch.check();
    const std::uint64_t i = k / 2;
    outcomes[k] =
        measure(spec, unit, number, samples[i], i, k % 2 == 0 ? Scene::far_wall : Scene::room, methods);
    watch.tell(static_cast<double>(++done) / static_cast<double>(outcomes.size()));
  });
  return outcomes;
}

std::vector<SampleOutcome> read_outcomes(const Outcome& outcome, std::size_t images, std::size_t methods) {
  const Json json = outcome.json;
  std::vector<SampleOutcome> outcomes = read_as<UnitOutcomes>(JsonObject(json, outcome.place(), "")).images;
  const auto whole = [&](const SampleOutcome& o) {
    return o.error_m.size() == methods && o.distance_error_m.size() == methods && o.status.size() == methods;
  };
  if (outcomes.size() != images || !std::ranges::all_of(outcomes, whole))
    throw InputError(outcome.place(), fmt::format("must have {} images with {} methods", images, methods));
  return outcomes;
}

struct RowErrors {
  std::vector<ClusteredError> all, recommended, recommended_distance, near;
};

void add_unit(std::uint64_t unit, const std::vector<Sample>& samples,
              const std::vector<SampleOutcome>& outcomes, WandSampleResults& results,
              std::vector<RowErrors>& errors) {
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    const Sample& sample = samples[k / 2];
    const std::size_t methods = outcomes[k].error_m.size();
    for (std::size_t m = 0; m < methods; ++m) {
      const std::size_t row = (k % 2) * methods + m;
      const ClusteredError error{unit, outcomes[k].error_m[m]},
          distance{unit, outcomes[k].distance_error_m[m]};
      (sample.near ? errors[row].near : errors[row].all).push_back(error);
      if (is_recommended(sample)) {
        errors[row].recommended.push_back(error);
        errors[row].recommended_distance.push_back(distance);
      }
      if (sample.near) continue;
      ++results.rows[row].statuses[outcomes[k].status[m]];
      results.samples.push_back(
          {row, unit, sample.distance_m, sample.angle_rad, error.error_m, distance.error_m});
    }
  }
}

}  // namespace

std::vector<Item> wand_items(const CalibrationSpec& spec) {
  const std::uint64_t images = 2 * (spec.samples + spec.near_samples) * spec.frames;
  std::vector<Item> items;
  for (std::uint64_t u = 0; u < spec.units && images > 0; ++u)
    items.push_back({wand_item(u), static_cast<double>(images),
                     [spec, u](const std::filesystem::path&, const Watch& watch) {
                       return json_of(UnitOutcomes{measure_samples(spec, u, watch)});
                     }});
  return items;
}

WandSampleResults read_wand(const CalibrationSpec& spec, const Outcomes& outcomes) {
  WandSampleResults results;
  if (spec.samples + spec.near_samples == 0) return results;
  const std::uint64_t images = 2 * (spec.samples + spec.near_samples);
  const std::vector<Variant> methods = variants(spec.ball_radius_m);
  for (Scene kind : {Scene::far_wall, Scene::room})
    for (const Variant& variant : methods)
      results.rows.push_back({variant.name, kind == Scene::far_wall ? "far wall" : "room", {}, {}, {}, {}});
  std::vector<RowErrors> errors(results.rows.size());
  for (std::uint64_t u = 0; u < spec.units; ++u) {
    add_unit(u, draw_samples(spec, u), read_outcomes(outcomes.at(wand_item(u)), images, methods.size()),
             results, errors);
  }
  for (std::size_t row = 0; row < results.rows.size(); ++row) {
    results.rows[row].all = spread_of(errors[row].all);
    results.rows[row].recommended = spread_of(errors[row].recommended);
    results.rows[row].recommended_distance = spread_of(errors[row].recommended_distance);
    results.rows[row].near = spread_of(errors[row].near);
  }
  return results;
}

ErrorSpread spread_of(const std::vector<ClusteredError>& errors) {
  ErrorSpread spread;
  std::map<std::size_t, std::pair<double, double>> clusters;  // sum, count
  std::vector<double> answered;
  double sum = 0.0, squares = 0.0;
  for (const ClusteredError& e : errors) {
    ++spread.asked;
    if (!std::isfinite(e.error_m)) continue;
    answered.push_back(e.error_m);
    sum += e.error_m;
    clusters[e.cluster].first += e.error_m;
    clusters[e.cluster].second += 1.0;
  }
  spread.answered = answered.size();
  if (answered.empty()) return spread;
  const double n = static_cast<double>(answered.size());
  spread.mean_m = sum / n;
  for (double error : answered) squares += (error - spread.mean_m) * (error - spread.mean_m);
  if (answered.size() > 1) spread.sd_m = std::sqrt(squares / (n - 1.0));
  const auto q = quantiles_of(answered, {0.5, 0.95, 1.0});
  spread.median_m = q[0];
  spread.p95_m = q[1];
  spread.max_m = q[2];
  std::vector<double> sums, counts;
  for (const auto& [cluster, s] : clusters) {
    sums.push_back(s.first);
    counts.push_back(s.second);
  }
  std::tie(spread.mean_low_m, spread.mean_high_m) = mean_interval(sums, counts);
  return spread;
}

}  // namespace trilat
