// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_numbers.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "evaluators/metrics/statistics.h"
#include "pipeline/calibration_study/place_samples.h"

namespace trilat {
namespace {

// Columns in which the paper sees the error grow: 0 to 149 and 351 to the last.
constexpr std::size_t kMiddleFrom = 150, kMiddleTo = 350;

struct Mean {
  double sum = 0.0, n = 0.0;
  void add(double value) {
    if (!std::isfinite(value)) return;
    sum += value;
    n += 1.0;
  }
  double value() const { return n > 0.0 ? sum / n : kNaN; }
};

}  // namespace

ErrorStatistics statistics_of(const std::vector<ClusteredError>& errors) {
  ErrorStatistics spread;
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
  spread.clusters = clusters.size();
  std::vector<double> sums, counts;
  for (const auto& [cluster, s] : clusters) {
    sums.push_back(s.first);
    counts.push_back(s.second);
  }
  std::tie(spread.mean_low_m, spread.mean_high_m) = mean_interval(sums, counts);
  return spread;
}

ColumnMeans column_means(const std::vector<double>& by_column) {
  Mean left, middle, right, edge;
  for (std::size_t c = 0; c < by_column.size(); ++c) {
    const bool is_left = c<kMiddleFrom, is_right = c> kMiddleTo;
    (is_left ? left : is_right ? right : middle).add(by_column[c]);
    if (is_left || is_right) edge.add(by_column[c]);
  }
  return {left.value(), middle.value(), right.value(), edge.value()};
}

const std::vector<PlaceBin>& place_bins() {
  static const std::vector<PlaceBin> bins = [] {
    std::vector<PlaceBin> all;
    const auto add = [&](const char* of, const std::vector<double>& edges) {
      for (std::size_t i = 0; i + 1 < edges.size(); ++i)
        all.push_back({of, edges[i], edges[i + 1], i == 0, i + 2 == edges.size()});
    };
    add("distance", {0.3, 0.5, 0.8, 1.5, 2.25, 3.0, 3.75, 4.5});
    add("angle", {0.0, 9.0, 18.0, 26.0, 35.0});
    return all;
  }();
  return bins;
}

std::string PlaceBin::name() const {
  const char* unit = of == std::string("distance") ? "m" : "degrees";
  if (is_first) return fmt::format("{} below {:g} {}", of, to, unit);
  if (is_last) return fmt::format("{} from {:g} {}", of, from, unit);
  return fmt::format("{} {:g} to {:g} {}", of, from, to, unit);
}

namespace {

bool holds(const PlaceBin& bin, const WandSample& sample) {
  const double where =
      bin.of == std::string("distance") ? sample.distance_m : sample.angle_rad * kDegreesPerRad;
  return std::isfinite(where) && (bin.is_first || where >= bin.from) && (bin.is_last || where < bin.to);
}

// Adds how the errors of the samples are spread that `wanted` holds for.
void add_spreads(const NumberKey& key, const WandRecording& recording, std::size_t method, const auto& wanted,
                 Numbers& numbers) {
  std::vector<ClusteredError> distances, positions;
  for (const WandSample& sample : recording.samples) {
    if (sample.method != method || !wanted(sample)) continue;
    distances.push_back({sample.sensor, sample.distance_error_m});
    positions.push_back({sample.sensor, sample.error_m});
  }
  for (const auto& [measure, errors] :
       {std::pair{"ball_distance", &distances}, {"ball_position", &positions}}) {
    const ErrorStatistics spread = statistics_of(*errors);
    numbers.add({key.with({.measure = measure, .statistic = "mean"}), spread.mean_m, spread.mean_low_m,
                 spread.mean_high_m, spread.answered, spread.clusters});
    for (const auto& [statistic, value_m] : {std::pair{"sd", spread.sd_m},
                                             {"median", spread.median_m},
                                             {"p95", spread.p95_m},
                                             {"max", spread.max_m}})
      numbers.add(
          {key.with({.measure = measure, .statistic = statistic}), value_m, kNaN, kNaN, spread.answered});
  }
  const auto answered = static_cast<double>(statistics_of(distances).answered);
  numbers.add({key.with({.measure = "answered", .statistic = "share"}),
               answered / static_cast<double>(distances.size()), kNaN, kNaN, distances.size()});
}

// Sums of the ball's distance errors (m) and their counts, by sensor, over the samples that `wanted` holds
// for.
WeightedRatio distance_errors(const WandRecording& recording, std::size_t method, const auto& wanted) {
  const std::size_t sensors = recording.sensors.size();
  WeightedRatio mean{std::vector<double>(sensors, 0.0), std::vector<double>(sensors, 0.0), 1.0};
  for (const WandSample& sample : recording.samples) {
    if (sample.method != method || !std::isfinite(sample.distance_error_m) || !wanted(sample)) continue;
    mean.numerator.at(sample.sensor) += sample.distance_error_m;
    mean.denominator.at(sample.sensor) += 1.0;
  }
  return mean;
}

// Adds how much more the distance errs in a zone than in the recommended range, whose errors are `inside`.
void add_beside(const NumberKey& key, const WeightedRatio& beside, const WeightedRatio& inside,
                Numbers& numbers) {
  Contrast contrast{{beside, inside}, {inside}};
  contrast.value[1].weight = -1.0;
  const Estimate more = solve_contrast(contrast);
  const double n = std::accumulate(beside.denominator.begin(), beside.denominator.end(), 0.0);
  numbers.add({key.with({.against = kInside, .measure = "ball_distance", .statistic = "relative_difference"}),
               more.value, more.low(), more.high(), static_cast<std::uint64_t>(n), more.clusters,
               more.p_value()});
}

void add_wand(const WandRecording& recording, std::size_t method, Numbers& numbers) {
  const PrintedCalibration paper = printed_calibration();
  const std::string& name = wand_method_names()[method];
  const NumberKey key{.condition = recording.name, .method = name};
  const double angle_rad = paper.recommended_below_deg * kRadPerDegree;
  const auto is_as_far = [&](const WandSample& s) {
    return s.distance_m >= paper.recommended_m[0] && s.distance_m <= paper.recommended_m[1];
  };
  const auto is_inside = [&](const WandSample& s) { return is_as_far(s) && s.angle_rad < angle_rad; };
  const auto add = [&](const std::string& group, const auto& wanted) {
    add_spreads(key.with({.group = group}), recording, method, wanted, numbers);
  };
  add(kInside, is_inside);
  const WeightedRatio inside = distance_errors(recording, method, is_inside);
  const auto add_zone = [&](const char* zone, const auto& wanted) {
    add_beside(key.with({.group = zone}), distance_errors(recording, method, wanted), inside, numbers);
  };
  add_zone("nearer", [&](const WandSample& s) {
    return s.distance_m >= paper.near_m && s.distance_m < paper.recommended_m[0] && s.angle_rad < angle_rad;
  });
  add_zone("farther", [&](const WandSample& s) {
    return s.distance_m > paper.recommended_m[1] && s.angle_rad < angle_rad;
  });
  add_zone("aside", [&](const WandSample& s) { return is_as_far(s) && s.angle_rad >= angle_rad; });
  add(kAllPlaces, [](const WandSample&) { return true; });
  add(kNear, [&](const WandSample& s) { return s.distance_m < paper.near_m; });
  if (std::ranges::find(kMainWandMethods, name) != kMainWandMethods.end())
    for (const PlaceBin& bin : place_bins())
      add(bin.name(), [&](const WandSample& s) { return holds(bin, s); });
  std::uint64_t asked = 0, another = 0;
  for (const WandSample& s : recording.samples) {
    const double off_m = std::isfinite(s.error_m) ? s.error_m : s.distance_error_m;
    asked += s.method == method;
    another += s.method == method && off_m > 2.0 * recording.ball_radius_m;
  }
  const auto add_status = [&](const std::string& status, std::uint64_t count) {
    numbers.add({key.with({.group = kAllPlaces, .measure = "status", .statistic = status}),
                 static_cast<double>(count) / static_cast<double>(asked), kNaN, kNaN, count});
  };
  if (asked == 0) return;
  add_status("another_thing", another);
  for (const auto& [status, count] : recording.statuses[method]) add_status(status, count);
}

void add_poses(const std::vector<WandRecording>& wands, Numbers& numbers) {
  std::map<std::string, std::vector<ClusteredError>> by_method;
  for (const WandRecording& recording : wands)
    for (const PoseDifference& pose : recording.poses) {
      const NumberKey key{.condition = recording.name, .group = pose.sensor, .method = pose.method};
      const auto add = [&](const char* measure, const char* statistic, double value) {
        numbers.add({key.with({.measure = measure, .statistic = statistic}), value});
      };
      add("pose", "difference", pose.position_m);
      add("pose", "sigma", pose.position_sigma_m);
      add("rotation", "difference", pose.rotation_rad);
      add("rotation", "sigma", pose.rotation_sigma_rad);
      std::vector<ClusteredError>& all = by_method[pose.method];
      all.push_back({all.size(), pose.position_m});
    }
  for (const auto& [method, errors] : by_method) {
    const ErrorStatistics spread = statistics_of(errors);
    numbers.add({{.method = method, .measure = "pose", .statistic = "mean_difference"},
                 spread.mean_m,
                 spread.mean_low_m,
                 spread.mean_high_m,
                 spread.answered,
                 spread.clusters});
  }
}

void add_wall(const WallRow& wall, Numbers& numbers) {
  const NumberKey key{.condition = wall.recording, .group = wall.sensor};
  const auto add = [&](const char* measure, const char* statistic, double value) {
    numbers.add({key.with({.measure = measure, .statistic = statistic}), value, kNaN, kNaN, wall.frames});
  };
  add("wall", "distance", wall.distance_m);
  add("wall", "stated", wall.stated_m);
  add("wall", "noise", wall.noise_m);
  add("tilt", "mean", wall.tilt_rad);
  for (const auto& [measure, columns] :
       {std::pair{"residual", &wall.residual_m}, {"sideways", &wall.printed_error_m}}) {
    const ColumnMeans means = column_means(*columns);
    double max_m = kNaN;
    for (const double error_m : *columns) max_m = std::fmax(max_m, error_m);
    for (const auto& [statistic, value] : {std::pair{"left", means.left},
                                           {"middle", means.middle},
                                           {"right", means.right},
                                           {"edge", means.edge},
                                           {"max", max_m}})
      add(measure, statistic, value);
  }
}

}  // namespace

Numbers calibration_numbers(const CalibrationRecordings& recordings) {
  Numbers numbers;
  for (const WandRecording& recording : recordings.wands)
    for (std::size_t m = 0; m < wand_method_names().size(); ++m) add_wand(recording, m, numbers);
  add_poses(recordings.wands, numbers);
  for (const WallRow& wall : recordings.walls) add_wall(wall, numbers);
  return numbers;
}

}  // namespace trilat
