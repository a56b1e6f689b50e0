// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_tables.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "pipeline/calibration_study/error_spread.h"
#include "pipeline/calibration_study/place_samples.h"

namespace trilat {
namespace {

// One way to find the ball in one recording.
struct WandRow {
  const WandRecording* recording;
  std::size_t method;

  std::uint64_t another_thing() const {
    return static_cast<std::uint64_t>(std::ranges::count_if(recording->samples, [&](const WandSample& s) {
      const double off_m = std::isfinite(s.error_m) ? s.error_m : s.distance_error_m;
      return s.method == method && off_m > 2.0 * recording->ball_radius_m;
    }));
  }
};

using Zone = bool (*)(const WandSample&);
bool is_inside(const WandSample& s) {
  return s.distance_m >= paper_calibration().recommended_m[0] &&
         s.distance_m <= paper_calibration().recommended_m[1] &&
         s.angle_rad < paper_calibration().recommended_below_deg * kRadPerDegree;
}
bool is_near(const WandSample& s) { return s.distance_m < paper_calibration().near_m; }
bool is_anywhere(const WandSample&) { return true; }

ErrorSpread spread_in(const WandRow& row, Zone zone, double WandSample::*error) {
  std::vector<ClusteredError> errors;
  for (const WandSample& sample : row.recording->samples)
    if (sample.method == row.method && zone(sample)) errors.push_back({sample.sensor, sample.*error});
  return spread_of(errors);
}
auto in_zone(Zone zone, double WandSample::*error) {
  return [=](const WandRow& row) { return spread_in(row, zone, error); };
}

std::string truth_text(const WandRecording& recording) {
  constexpr std::array kTruths{"stated distances", "OptiTrack, places left out",
                               "other sensors, places left out"};
  return kTruths.at(static_cast<std::size_t>(recording.truth));
}

Table wand_table(const CalibrationSummary& s) {
  using R = WandRow;
  using E = ErrorSpread;
  std::vector<R> rows;
  for (const WandRecording& recording : s.wands)
    for (std::size_t m = 0; m < wand_method_names().size(); ++m) rows.push_back({&recording, m});
  const auto inside_distance = in_zone(is_inside, &WandSample::distance_error_m);
  const auto inside = in_zone(is_inside, &WandSample::error_m);
  const auto span = in_zone(is_anywhere, &WandSample::distance_error_m);
  const auto near = in_zone(is_near, &WandSample::distance_error_m);
  Table table = table_of<R>(
      "wand", {"Finding the ball, " + std::string(source_text(s.simulated)), s.campaign}, rows,
      {{"method", "method", as_text([](const R& r) { return wand_method_names()[r.method]; })},
       {"recording", "recording", as_text([](const R& r) { return r.recording->name; })},
       {"truth", "truth", as_text([](const R& r) { return truth_text(*r.recording); })},
       {"inside: asked", "inside_asked", of(inside_distance, as_count(&E::asked))},
       {"answered", "inside_answered", of(inside_distance, as_count(&E::answered))},
       {"distance: mean (cm)", "inside_distance_mean_cm",
        of(inside_distance, in_cm(&E::mean_m, &E::mean_low_m, &E::mean_high_m))},
       {"sd (cm)", "inside_distance_sd_cm", of(inside_distance, in_cm(&E::sd_m))},
       {"3-D: mean (cm)", "inside_mean_cm", of(inside, in_cm(&E::mean_m, &E::mean_low_m, &E::mean_high_m))},
       {"sd (cm)", "inside_sd_cm", of(inside, in_cm(&E::sd_m))},
       {"all: asked", "span_asked", of(span, as_count(&E::asked))},
       {"answered", "span_answered", of(span, as_count(&E::answered))},
       {"distance: mean (cm)", "span_distance_mean_cm", of(span, in_cm(&E::mean_m))},
       {"median (cm)", "span_distance_median_cm", of(span, in_cm(&E::median_m))},
       {"p95 (cm)", "span_distance_p95_cm", of(span, in_cm(&E::p95_m))},
       {"another thing", "another_thing", as_count(&R::another_thing)},
       {fmt::format("answered below {:g} m (%)", paper_calibration().near_m), "near_answered_percent",
        of(near, in_percent([](const E& e) { return share_of(e.answered, e.asked); }))},
       {"statuses", "statuses", as_text([](const R& r) {
          std::uint64_t asked = 0;
          for (const auto& [status, count] : r.recording->statuses[r.method]) asked += count;
          return asked == 0 ? std::string() : statuses_text(r.recording->statuses[r.method], asked);
        })}});
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

struct Bin {
  const WandRow* row;
  const char* by;
  double from, to;
  bool is_last;  // the upper edge belongs to it
  std::vector<ClusteredError> distance_errors = {}, errors = {};

  bool holds(double where) const { return where >= from && (where < to || (is_last && where <= to)); }
  ErrorSpread of_distance() const { return spread_of(distance_errors); }
  ErrorSpread of_place() const { return spread_of(errors); }
};

// Bins between edges; the outer ones reach as far as the samples do.
std::vector<Bin> bins_between(const WandRow& row, const char* by, std::vector<double> edges,
                              double (*where)(const WandSample&)) {
  for (const WandSample& sample : row.recording->samples) {
    if (!std::isfinite(where(sample))) continue;
    edges.front() = std::min(edges.front(), where(sample));
    edges.back() = std::max(edges.back(), where(sample));
  }
  std::vector<Bin> bins;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i)
    bins.push_back({&row, by, edges[i], edges[i + 1], i + 2 == edges.size()});
  for (const WandSample& sample : row.recording->samples)
    for (Bin& bin : bins)
      if (sample.method == row.method && bin.holds(where(sample))) {
        bin.distance_errors.push_back({sample.sensor, sample.distance_error_m});
        bin.errors.push_back({sample.sensor, sample.error_m});
      }
  return bins;
}

Table bins_table(const CalibrationSummary& s) {
  using E = ErrorSpread;
  std::vector<WandRow> rows;
  for (const char* method : kMainWandMethods)
    for (const WandRecording& recording : s.wands) rows.push_back({&recording, wand_method(method)});
  std::vector<Bin> bins;
  for (const WandRow& row : rows)
    for (const auto& some :
         {bins_between(row, "distance (m)", {0.3, 0.5, 0.8, 1.5, 2.25, 3.0, 3.75, 4.5},
                       [](const WandSample& sample) { return sample.distance_m; }),
          bins_between(row, "angle (degrees)", {0.0, 9.0, 18.0, 26.0, 35.0},
                       [](const WandSample& sample) { return sample.angle_rad * kDegreesPerRad; })})
      bins.insert(bins.end(), some.begin(), some.end());
  Table table = table_of<Bin>(
      "bins",
      {"Error of one place of the ball by distance and by angle, " + std::string(source_text(s.simulated)),
       s.campaign},
      bins,
      {{"method", "method", as_text([](const Bin& b) { return wand_method_names()[b.row->method]; })},
       {"recording", "recording", as_text([](const Bin& b) { return b.row->recording->name; })},
       {"by", "by", as_text(&Bin::by)},
       {"from", "from", as_number(-1, &Bin::from)},
       {"to", "to", as_number(-1, &Bin::to)},
       {"n", "n", of(&Bin::of_distance, as_count(&E::asked))},
       {"answered", "answered", of(&Bin::of_distance, as_count(&E::answered))},
       {"distance: mean (cm)", "distance_mean_cm",
        of(&Bin::of_distance, in_cm(&E::mean_m, &E::mean_low_m, &E::mean_high_m))},
       {"3-D: mean (cm)", "mean_cm", of(&Bin::of_place, in_cm(&E::mean_m))}});
  add_notes(table, "calibration_bins");
  return table;
}

Table poses_table(const CalibrationSummary& s) {
  using R = PoseDifference;
  std::vector<R> rows;
  for (const WandRecording& recording : s.wands)
    rows.insert(rows.end(), recording.poses.begin(), recording.poses.end());
  Table table = table_of<R>(
      "poses",
      {fmt::format("Sensors' poses by the wand, less those of the campaign's calibration, {}",
                   source_text(s.simulated)),
       s.campaign},
      rows,
      {{"method", "method", as_text(&R::method)},
       {"sensor", "sensor", as_text(&R::sensor)},
       {"position (cm)", "position_cm", in_cm(&R::position_m)},
       {"stated sigma, an axis (cm)", "position_sigma_cm", in_cm(&R::position_sigma_m)},
       {"rotation (degrees)", "rotation_deg", in_degrees(&R::rotation_rad)},
       {"stated sigma, an axis (degrees)", "rotation_sigma_deg", in_degrees(&R::rotation_sigma_rad)},
       {"without a pose", "problem", as_text(&R::problem)}});
  add_notes(table, "calibration_poses");
  return table;
}

Table walls_table(const CalibrationSummary& s) {
  using R = WallRow;
  using M = ColumnMeans;
  const auto residual = [](const R& r) { return column_means(r.residual_m); };
  const auto printed = [](const R& r) { return column_means(r.printed_error_m); };
  const auto max_of = [](const R& r) {
    double max_m = kNotMeasured;
    for (const double error_m : r.printed_error_m) max_m = std::fmax(max_m, error_m);
    return max_m;
  };
  Table table = table_of<R>(
      "distortion",
      {fmt::format("A flat wall, {}: mean absolute errors in the middle row, and noise of the depth",
                   source_text(s.simulated)),
       s.campaign},
      s.walls,
      {{"recording", "recording", as_text(&R::recording)},
       {"sensor", "sensor", as_text(&R::sensor)},
       {"frames", "frames", as_count(&R::frames)},
       {"distance (m)", "distance_m", as_number(3, &R::distance_m)},
       {"less stated (mm)", "less_stated_mm", in_mm([](const R& r) { return r.distance_m - r.stated_m; })},
       {"tilt (degrees)", "tilt_deg", in_degrees(&R::tilt_rad)},
       {"noise (mm)", "noise_mm", in_mm(&R::noise_m)},
       {"from the plane, 0-149 (mm)", "residual_left_mm", of(residual, in_mm(&M::left))},
       {"150-350 (mm)", "residual_middle_mm", of(residual, in_mm(&M::middle))},
       {"351-511 (mm)", "residual_right_mm", of(residual, in_mm(&M::right))},
       {"edge/middle", "residual_edge_to_middle", of(residual, as_number(2, &M::edge_to_middle))},
       {"eq. 4 sideways, edge (mm)", "printed_edge_mm", of(printed, in_mm(&M::edge))},
       {"middle (mm)", "printed_middle_mm", of(printed, in_mm(&M::middle))},
       {"max (mm)", "printed_max_mm", in_mm(max_of)},
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

// "2.41 cm, 38 of 40 answered", inside the recommended range.
std::string inside_text(const WandRow& row) {
  const ErrorSpread inside = spread_in(row, is_inside, &WandSample::distance_error_m);
  return fmt::format("{}, {} of {} answered", mean_text(inside), inside.answered, inside.asked);
}

// Effects of the errors in equations 1 to 5, each in the first recording, alone against all corrected.
void add_errata(const CalibrationSummary& s, StoredTables& shown) {
  constexpr std::array<std::array<const char*, 2>, 4> kErrata{{{"E17", "corrected, but eq. 1 as printed"},
                                                               {"E1", "corrected, but E1 as printed"},
                                                               {"E2", "corrected, but E2 as printed"},
                                                               {"E3", "corrected, but E3 as printed"}}};
  if (!s.wands.empty())
    for (const auto& [id, method] : kErrata)
      shown.errata.emplace(
          id, fmt::format("error of the distance inside the recommended range, {}: {} (corrected: {})",
                          s.wands.front().name, inside_text({&s.wands.front(), wand_method(method)}),
                          inside_text({&s.wands.front(), wand_method("corrected")})));
  const auto mean_of = [&](const char* method) {
    std::vector<ClusteredError> errors;
    for (const WandRecording& recording : s.wands)
      for (const PoseDifference& pose : recording.poses)
        if (pose.method == method) errors.push_back({errors.size(), pose.position_m});
    return spread_of(errors);
  };
  const ErrorSpread printed = mean_of("two positions as printed"),
                    corrected = mean_of("two positions, corrected");
  if (printed.asked + corrected.asked == 0) return;
  for (const char* id : {"E4", "E5", "E19"})
    shown.errata.emplace(id, fmt::format("E4 and E5 together: sensors off by {} against {} corrected",
                                         mean_text(printed), mean_text(corrected)));
}

std::vector<std::string> sentences_of(const CalibrationSummary& s) {
  std::vector<std::string> sentences{fmt::format(
      "The paper states, of real sensors and a laser meter: {} samples; recommended are {:g} to {:g} m and "
      "below {:g} degrees; {} samples inside give {:g} +- {:g} cm; nearer than {:g} m only {:g} % of "
      "calibrations are valid.",
      paper_calibration().samples, paper_calibration().recommended_m[0], paper_calibration().recommended_m[1],
      paper_calibration().recommended_below_deg, paper_calibration().recommended_samples,
      paper_calibration().recommended_mean_cm, paper_calibration().recommended_spread_cm,
      paper_calibration().near_m, paper_calibration().near_valid_percent)};
  for (const WandRecording& recording : s.wands)
    sentences.push_back(
        fmt::format("{}, {} ({}), error of the distance inside the recommended range: ours {}; the paper's "
                    "way as printed {}.",
                    recording.name, source_text(recording.simulated), truth_text(recording),
                    inside_text({&recording, wand_method("ours")}),
                    inside_text({&recording, wand_method("as printed")})));
  if (s.simulated && !s.wands.empty())
    sentences.push_back(
        "Every simulated sensor adds a constant of its own to all depths, which a method that looks through "
        "one sensor cannot know, and it is in these errors; what the paper's sensors and its laser meter "
        "added is not known.");
  std::vector<double> ratios;
  for (const WallRow& row : s.walls)
    if (const double ratio = column_means(row.residual_m).edge_to_middle(); std::isfinite(ratio))
      ratios.push_back(ratio);
  if (!ratios.empty())
    sentences.push_back(fmt::format(
        "The paper finds a flat wall's error at the left and right of the image \"{}\" than in "
        "the middle; here the depth lies {:.2f} to {:.2f} times as far from the fitted plane there.",
        paper_calibration().worse, std::ranges::min(ratios), std::ranges::max(ratios)));
  return sentences;
}

}  // namespace

StoredTables calibration_tables(const CalibrationSummary& s) {
  StoredTables shown;
  shown.title = s.study == s.campaign ? s.study : s.study + " on " + s.campaign;
  shown.asked = "How exactly is the wand found, and how flat is a flat wall?";
  shown.about = fmt::format("Calibration by {} recording{} of a ball and {} wall{}, {}.", s.wands.size(),
                            s.wands.size() == 1 ? "" : "s", s.walls.size(), s.walls.size() == 1 ? "" : "s",
                            s.simulated ? "**simulated**" : "recorded");
  shown.sentences = sentences_of(s);
  for (const std::string& text : s.failed) shown.warnings.push_back("Left out: " + text);
  for (const WandRecording& recording : s.wands)
    for (const std::string& note : recording.notes) shown.warnings.push_back(recording.name + ": " + note);
  add_errata(s, shown);
  if (!s.wands.empty()) {
    shown.tables = {wand_table(s), bins_table(s)};
    shown.tables.front().printed = "calibration";
  }
  if (!s.walls.empty()) shown.tables.push_back(walls_table(s));
  for (const WandRecording& recording : s.wands)
    if (!recording.poses.empty()) {
      shown.tables.push_back(poses_table(s));
      break;
    }
  for (std::size_t t = 0; t < 2 && t < shown.tables.size(); ++t) shown.tables[t].shown = Table::Shown::first;
  return shown;
}

}  // namespace trilat
