// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/base/words.h"
#include "pipeline/calibration_study/calibration_numbers.h"
#include "pipeline/calibration_study/place_samples.h"

namespace trilat {
namespace {

// One way to find the ball in one recording.
struct WandRow : NumberKey {
  const WandRecording* recording;
};

std::vector<WandRow> wand_rows(const std::vector<WandRecording>& wands) {
  std::vector<WandRow> rows;
  for (const WandRecording& recording : wands)
    for (const std::string& method : wand_method_names())
      rows.push_back({{.condition = recording.name, .method = method}, &recording});
  return rows;
}

NumberKey in_zone(const std::string& zone, const char* measure, const char* statistic) {
  return {.group = zone, .measure = measure, .statistic = statistic};
}
NumberKey answered_in(const std::string& zone) { return in_zone(zone, "answered", "share"); }

std::string truth_text(const WandRecording& recording) {
  constexpr std::array kTruths{"stated distances", "OptiTrack, places left out",
                               "other sensors, places left out"};
  return kTruths.at(static_cast<std::size_t>(recording.truth));
}

Table wand_table(const CalibrationSummary& s, const std::vector<WandRecording>& wands) {
  using R = WandRow;
  const Numbers& numbers = s.numbers;
  const NumberKey distance = in_zone(kInside, "ball_distance", "mean"),
                  position = in_zone(kInside, "ball_position", "mean"),
                  everywhere = in_zone(kAllPlaces, "ball_distance", "mean");
  const auto statuses = [&](const R& r) {
    std::vector<std::string> names;
    const auto method = wand_method(r.method);
    for (const auto& [status, count] : r.recording->statuses[method]) names.push_back(status);
    return statuses_text(numbers, r.with({.group = kAllPlaces}), names);
  };
  Table table = table_of<R>(
      "wand", {"Finding the ball, " + std::string(source_text(s.simulated)), s.campaign}, wand_rows(wands),
      {{"method", "method", as_text(&R::method)},
       {"recording", "recording", as_text(&R::condition)},
       {"truth", "truth", as_text([](const R& r) { return truth_text(*r.recording); })},
       {"inside: asked", "inside_asked", count_of(numbers, answered_in(kInside))},
       {"answered", "inside_answered", count_of(numbers, distance)},
       {"distance: mean (cm)", "inside_distance_mean_cm", interval_of(numbers, distance)},
       {"sd (cm)", "inside_distance_sd_cm", value_of(numbers, distance.with({.statistic = "sd"}))},
       {"3-D: mean (cm)", "inside_mean_cm", interval_of(numbers, position)},
       {"sd (cm)", "inside_sd_cm", value_of(numbers, position.with({.statistic = "sd"}))},
       {"all: asked", "span_asked", count_of(numbers, answered_in(kAllPlaces))},
       {"answered", "span_answered", count_of(numbers, everywhere)},
       {"distance: mean (cm)", "span_distance_mean_cm", value_of(numbers, everywhere)},
       {"median (cm)", "span_distance_median_cm",
        value_of(numbers, everywhere.with({.statistic = "median"}))},
       {"p95 (cm)", "span_distance_p95_cm", value_of(numbers, everywhere.with({.statistic = "p95"}))},
       {"another thing", "another_thing", count_of(numbers, in_zone(kAllPlaces, "status", "another_thing"))},
       {fmt::format("answered below {:g} m (%)", paper_calibration().near_m), "near_answered_percent",
        value_of(numbers, answered_in(kNear), 1)},
       {"statuses", "statuses", as_text(statuses)}});
  const auto number = [](double value, int decimals) { return TableValue::of(value, decimals); };
  table.rows.insert(
      table.rows.begin(),
      row_by_key(table, {{"method", TableValue::of("the paper, measured")},
                         {"truth", TableValue::of("laser meter")},
                         {"inside_asked", number(paper_calibration().recommended_samples, 0)},
                         {"inside_distance_mean_cm", number(paper_calibration().recommended_mean_cm, 2)},
                         {"inside_distance_sd_cm", number(paper_calibration().recommended_spread_cm, 2)},
                         {"span_asked", number(paper_calibration().samples, 0)},
                         {"near_answered_percent", number(paper_calibration().near_valid_percent, 1)},
                         {"statuses", TableValue::of("not stated")}}));
  add_notes(table, "wand",
            {{"from", fmt::format("{:g}", paper_calibration().recommended_m[0])},
             {"to", fmt::format("{:g}", paper_calibration().recommended_m[1])},
             {"angle", fmt::format("{:g}", paper_calibration().recommended_below_deg)},
             {"source", paper_calibration().source}});
  if (s.simulated) add_notes(table, "wand_simulated");
  return table;
}

Table bins_table(const CalibrationSummary& s, const std::vector<WandRecording>& wands) {
  using R = NumberKey;
  std::vector<R> rows;
  for (const char* method : kMainWandMethods)
    for (const WandRecording& recording : wands)
      for (const PlaceBin& bin : place_bins())
        rows.push_back({.condition = recording.name, .group = bin.name(), .method = method});
  const NumberKey distance = in_zone("", "ball_distance", "mean");
  Table table = table_of<R>(
      "bins",
      {"Error of one place of the ball by distance and by angle, " + std::string(source_text(s.simulated)),
       s.campaign},
      rows,
      {{"method", "method", as_text(&R::method)},
       {"recording", "recording", as_text(&R::condition)},
       {"where", "where", as_text(&R::group)},
       {"n", "n", count_of(s.numbers, answered_in(""))},
       {"answered", "answered", count_of(s.numbers, distance)},
       {"distance: mean (cm)", "distance_mean_cm", interval_of(s.numbers, distance)},
       {"3-D: mean (cm)", "mean_cm", value_of(s.numbers, in_zone("", "ball_position", "mean"))}});
  add_notes(table, "calibration_bins");
  return table;
}

Table poses_table(const CalibrationSummary& s, const std::vector<WandRecording>& wands) {
  struct R : NumberKey {
    std::string problem;
  };
  std::vector<R> rows;
  for (const WandRecording& recording : wands)
    for (const PoseDifference& pose : recording.poses)
      rows.push_back(
          {{.condition = recording.name, .group = pose.sensor, .method = pose.method}, pose.problem});
  const auto number = [&](const char* measure, const char* statistic) {
    return value_of(s.numbers, {.measure = measure, .statistic = statistic});
  };
  Table table =
      table_of<R>("poses",
                  {fmt::format("Sensors' poses by the wand, less those of the campaign's calibration, {}",
                               source_text(s.simulated)),
                   s.campaign},
                  rows,
                  {{"method", "method", as_text(&R::method)},
                   {"sensor", "sensor", as_text(&R::group)},
                   {"position (cm)", "position_cm", number("pose", "difference")},
                   {"stated sigma, an axis (cm)", "position_sigma_cm", number("pose", "sigma")},
                   {"rotation (degrees)", "rotation_deg", number("rotation", "difference")},
                   {"stated sigma, an axis (degrees)", "rotation_sigma_deg", number("rotation", "sigma")},
                   {"without a pose", "problem", as_text(&R::problem)}});
  add_notes(table, "calibration_poses");
  return table;
}

Table walls_table(const CalibrationSummary& s, const std::vector<WallRow>& walls) {
  using R = NumberKey;
  std::vector<R> rows;
  for (const WallRow& wall : walls) rows.push_back({.condition = wall.recording, .group = wall.sensor});
  const auto number = [&s](const char* measure, const char* statistic) {
    return [&s, key = in_zone("", measure, statistic)](const R& r) { return s.numbers.value(r.with(key)); };
  };
  const auto distance_m = number("wall", "distance"), stated_m = number("wall", "stated");
  const auto edge = number("residual", "edge"), middle = number("residual", "middle");
  Table table = table_of<R>(
      "distortion",
      {fmt::format("A flat wall, {}: mean absolute errors in the middle row, and noise of the depth",
                   source_text(s.simulated)),
       s.campaign},
      rows,
      {{"recording", "recording", as_text(&R::condition)},
       {"sensor", "sensor", as_text(&R::group)},
       {"frames", "frames", count_of(s.numbers, in_zone("", "wall", "distance"))},
       {"distance (m)", "distance_m", as_number(3, distance_m)},
       {"less stated (mm)", "less_stated_mm", in_mm([=](const R& r) { return distance_m(r) - stated_m(r); })},
       {"tilt (degrees)", "tilt_deg", value_of(s.numbers, in_zone("", "tilt", "mean"))},
       {"noise (mm)", "noise_mm", in_mm(number("wall", "noise"))},
       {"from the plane, 0-149 (mm)", "residual_left_mm", in_mm(number("residual", "left"))},
       {"150-350 (mm)", "residual_middle_mm", in_mm(middle)},
       {"351-511 (mm)", "residual_right_mm", in_mm(number("residual", "right"))},
       {"edge/middle", "residual_edge_to_middle",
        as_number(2, [=](const R& r) { return edge(r) / middle(r); })},
       {"eq. 4 sideways, edge (mm)", "printed_edge_mm", in_mm(number("sideways", "edge"))},
       {"middle (mm)", "printed_middle_mm", in_mm(number("sideways", "middle"))},
       {"max (mm)", "printed_max_mm", in_mm(number("sideways", "max"))},
       {"stated", "stated", as_text([](const R&) { return ""; })}});
  std::string claim;
  for (const auto& range : paper_calibration().worse_columns)
    claim += fmt::format("{}{:g} to {:g}", claim.empty() ? "columns " : " and ", range[0], range[1]);
  table.rows.insert(
      table.rows.begin(),
      row_by_key(table, {{"recording", TableValue::of("the paper")},
                         {"frames", TableValue::of(paper_calibration().wall_frames, 0)},
                         {"distance_m", TableValue::of(paper_calibration().wall_m, 3)},
                         {"stated", TableValue::of(fmt::format("{}: \"{}\" than the middle", claim,
                                                               paper_calibration().worse))}}));
  add_notes(table, "calibration_distortion");
  return table;
}

// "1.17 cm (95 % interval 0.68 to 1.69 cm)"; says so when there is no answer or no interval.
std::string mean_text(const Number* mean) {
  if (!mean) return "an unknown distance (no answer)";
  std::string text = fmt::format("{:.2f} cm", mean->value * kCentimetresPerMetre);
  if (!std::isfinite(mean->low) || !std::isfinite(mean->high))
    return text + " (too few sensors for an interval)";
  return text + fmt::format(" (95 % interval {:.2f} to {:.2f} cm)", mean->low * kCentimetresPerMetre,
                            mean->high * kCentimetresPerMetre);
}

// "2.41 cm, 38 of 40 answered", inside the recommended range.
std::string inside_text(const CalibrationSummary& s, const std::string& recording, const char* method) {
  const NumberKey row{.condition = recording, .method = method};
  const Number* mean = s.numbers.find(row.with(in_zone(kInside, "ball_distance", "mean")));
  return fmt::format("{}, {} of {} answered", mean_text(mean), mean ? mean->n : 0,
                     s.numbers.n(row.with(answered_in(kInside))));
}

// Effects of the errors in equations 1 to 5, each in the first recording, alone against all corrected.
void add_errata(const CalibrationSummary& s, const std::vector<WandRecording>& wands, StoredTables& shown) {
  constexpr std::array<std::array<const char*, 2>, 4> kErrata{{{"E17", "corrected, but eq. 1 as printed"},
                                                               {"E1", "corrected, but E1 as printed"},
                                                               {"E2", "corrected, but E2 as printed"},
                                                               {"E3", "corrected, but E3 as printed"}}};
  if (!wands.empty())
    for (const auto& [id, method] : kErrata)
      shown.errata.emplace(
          id, fmt::format("error of the distance inside the recommended range, {}: {} (corrected: {})",
                          wands.front().name, inside_text(s, wands.front().name, method),
                          inside_text(s, wands.front().name, "corrected")));
  if (std::ranges::all_of(wands, [](const WandRecording& wand) { return wand.poses.empty(); })) return;
  const auto mean_of = [&](const char* method) {
    return mean_text(s.numbers.find({.method = method, .measure = "pose", .statistic = "mean_difference"}));
  };
  for (const char* id : {"E4", "E5", "E19"})
    shown.errata.emplace(
        id, fmt::format("E4 and E5 together: sensors off by {} against {} corrected",
                        mean_of("two positions as printed"), mean_of("two positions, corrected")));
}

std::vector<std::string> sentences_of(const CalibrationSummary& s, const CalibrationRecordings& made) {
  std::vector<std::string> sentences{fmt::format(
      "The paper states, of real sensors and a laser meter: {} samples; recommended are {:g} to {:g} m and "
      "below {:g} degrees; {} samples inside give {:g} +- {:g} cm; nearer than {:g} m only {:g} % of "
      "calibrations are valid.",
      paper_calibration().samples, paper_calibration().recommended_m[0], paper_calibration().recommended_m[1],
      paper_calibration().recommended_below_deg, paper_calibration().recommended_samples,
      paper_calibration().recommended_mean_cm, paper_calibration().recommended_spread_cm,
      paper_calibration().near_m, paper_calibration().near_valid_percent)};
  for (const WandRecording& recording : made.wands)
    sentences.push_back(
        fmt::format("{}, {} ({}), error of the distance inside the recommended range: ours {}; the paper's "
                    "way as printed {}.",
                    recording.name, source_text(recording.simulated), truth_text(recording),
                    inside_text(s, recording.name, "ours"), inside_text(s, recording.name, "as printed")));
  if (s.simulated && !made.wands.empty())
    sentences.push_back(
        "Every simulated sensor adds a constant of its own to all depths, which a method that looks through "
        "one sensor cannot know, and it is in these errors; what the paper's sensors and its laser meter "
        "added is not known.");
  std::vector<double> ratios;
  for (const WallRow& wall : made.walls) {
    const NumberKey row{.condition = wall.recording, .group = wall.sensor};
    const double ratio = s.numbers.value(row.with(in_zone("", "residual", "edge"))) /
                         s.numbers.value(row.with(in_zone("", "residual", "middle")));
    if (std::isfinite(ratio)) ratios.push_back(ratio);
  }
  if (!ratios.empty())
    sentences.push_back(fmt::format(
        "The paper finds a flat wall's error at the left and right of the image \"{}\" than in "
        "the middle; here the depth lies {:.2f} to {:.2f} times as far from the fitted plane there.",
        paper_calibration().worse, std::ranges::min(ratios), std::ranges::max(ratios)));
  return sentences;
}

}  // namespace

StoredTables calibration_tables(const CalibrationSummary& s, const CalibrationRecordings& made) {
  StoredTables shown;
  shown.title = s.study == s.campaign ? s.study : s.study + " on " + s.campaign;
  shown.asked = "How exactly is the wand found, and how flat is a flat wall?";
  shown.about =
      fmt::format("Calibration by {} of a ball and {}, {}.", counted(made.wands.size(), "recording"),
                  counted(made.walls.size(), "wall"), s.simulated ? "**simulated**" : "recorded");
  shown.sentences = sentences_of(s, made);
  for (const std::string& text : s.failed) shown.warnings.push_back("Left out: " + text);
  for (const WandRecording& recording : made.wands)
    for (const std::string& note : recording.notes) shown.warnings.push_back(recording.name + ": " + note);
  add_errata(s, made.wands, shown);
  if (!made.wands.empty()) {
    shown.tables = {wand_table(s, made.wands), bins_table(s, made.wands)};
    shown.tables.front().printed = "calibration";
  }
  if (!made.walls.empty()) shown.tables.push_back(walls_table(s, made.walls));
  for (const WandRecording& recording : made.wands)
    if (!recording.poses.empty()) {
      shown.tables.push_back(poses_table(s, made.wands));
      break;
    }
  for (std::size_t t = 0; t < 2 && t < shown.tables.size(); ++t)
    shown.tables[t].shown = Table::Placement::first;
  return shown;
}

}  // namespace trilat
