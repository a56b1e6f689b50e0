// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/calibration_findings.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

std::vector<TableValue> paper_row(const PrintedCalibration& paper) {
  const auto n = [](int count) { return TableValue::of(count, 0); };
  return {TableValue::of("the paper, measured"),
          TableValue::of("laser meter"),
          n(paper.recommended_samples),
          no_cell(),
          TableValue::of(paper.recommended_mean_cm, 2),
          TableValue::of(paper.recommended_spread_cm, 2),
          no_cell(),
          no_cell(),
          no_cell(),
          no_cell(),
          no_cell(),
          no_cell(),
          n(paper.samples),
          no_cell(),
          no_cell(),
          no_cell(),
          no_cell(),
          no_cell(),
          TableValue::of(paper.near_valid_percent, 1),
          TableValue::of("not stated")};
}

// Answers that are farther off than the ball is wide: something else was taken for it.
std::uint64_t wrong_things(const CalibrationSummary& s, std::size_t row) {
  std::uint64_t count = 0;
  for (const WandSample& sample : s.wand_samples)
    count += sample.row == row && sample.error_m > 2.0 * s.ball_radius_m;
  return count;
}

std::vector<TableValue> wand_cells(const WandRow& row, std::uint64_t wrong) {
  const ErrorSpread &inside = row.recommended, &distance = row.recommended_distance, &all = row.all;
  return {TableValue::of(row.method),
          TableValue::of(row.scene),
          count_cell(inside.asked),
          count_cell(inside.answered),
          cm_cell(distance.mean_m),
          cm_cell(distance.sd_m),
          cm_cell(distance.mean_low_m),
          cm_cell(distance.mean_high_m),
          cm_cell(inside.mean_m),
          cm_cell(inside.sd_m),
          cm_cell(inside.mean_low_m),
          cm_cell(inside.mean_high_m),
          count_cell(all.asked),
          count_cell(all.answered),
          cm_cell(all.mean_m),
          cm_cell(all.median_m),
          cm_cell(all.p95_m),
          count_cell(wrong),
          percent_cell(share_of(row.near.answered, row.near.asked)),
          TableValue::of(all.asked == 0 ? std::string() : statuses_text(row.statuses, all.asked))};
}

std::vector<std::string> wand_notes(const CalibrationSummary& s, const PrintedCalibration& paper) {
  std::vector<std::string> notes{
      fmt::format(
          "\"Inside\" is the paper's recommended range, {:g} to {:g} m and below {:g} degrees from the "
          "central line; \"span\" is all samples; the intervals are 95 % of the mean, by bootstrap over "
          "units; far wall: the ball alone, the wall at 7 m; room: with floor, walls and the person who "
          "holds it.",
          paper.recommended_m[0], paper.recommended_m[1], paper.recommended_below_deg),
      fmt::format("The first row is what the paper states ({}); what its +- is, it does not say. It compared "
                  "with a laser meter, which measures the distance from the sensor to the ball: \"distance\" "
                  "is the error of that alone, \"3-D\" the whole of the ball's place.",
                  paper.source),
      "Eq. 2 keeps what is nearer than about half of the mean depth: before a far wall that is the ball, in "
      "a room the nearest things, the wand or not. This holds for every row of the paper's method but the "
      "mid-range, which keeps what is nearer than half-way between the nearest and the farthest depth, and "
      "ends at the nearest thing: the ball, or in a room the floor where that is nearer."};
  for (std::string& sentence : wand_errata_sentences(s)) notes.push_back(std::move(sentence));
  notes.push_back("Another thing: answers of the span that are off by more than the ball is wide.");
  notes.push_back(
      "Nearer than 0.5 m the simulated sensor gives no depth, and ours refuses a ball whose surface is "
      "nearer: its share there is so by construction. For the paper's method an answer only means that eq. 3 "
      "ended.");
  notes.push_back(
      "A unit's constant depth offset, which no method with a single sensor can know, is in the error of "
      "every row.");
  notes.push_back("All rows but the first are simulated; statuses are those of the span.");
  return notes;
}

constexpr std::array<double, 7> kDistances_m{0.4, 0.8, 1.5, 2.25, 3.0, 3.75, 4.5};
constexpr std::array<double, 5> kAngles_deg{0.0, 9.0, 18.0, 26.0, 35.0};

struct Bin {
  double from, to;
  bool is_last;  // the upper edge belongs to it
  std::uint64_t n = 0, answered = 0;
  double sum_m = 0.0, distance_sum_m = 0.0;

  void add(double where, const WandSample& sample) {
    if (!(where >= from && (where < to || (is_last && where == to)))) return;
    ++n;
    if (!std::isfinite(sample.error_m)) return;
    ++answered;
    sum_m += sample.error_m;
    distance_sum_m += sample.distance_error_m;
  }
  double mean_m(double sum) const { return answered == 0 ? kNoNumber : sum / static_cast<double>(answered); }
};

template <std::size_t N>
std::vector<Bin> bins_of(const std::array<double, N>& edges) {
  std::vector<Bin> bins;
  for (std::size_t i = 0; i + 1 < N; ++i) bins.push_back({edges[i], edges[i + 1], i + 2 == N});
  return bins;
}

// A study may ask for samples beyond the usual edges.
void widen(std::vector<Bin>& bins, double where) {
  bins.front().from = std::min(bins.front().from, where);
  bins.back().to = std::max(bins.back().to, where);
}

void add_bins(Table& table, const WandRow& row, const std::string& of, const std::vector<Bin>& bins) {
  for (const Bin& bin : bins)
    table.rows.push_back({TableValue::of(row.method), TableValue::of(row.scene), TableValue::of(of),
                          TableValue::of(bin.from, -1), TableValue::of(bin.to, -1), count_cell(bin.n),
                          count_cell(bin.answered), cm_cell(bin.mean_m(bin.distance_sum_m)),
                          cm_cell(bin.mean_m(bin.sum_m))});
}

}  // namespace

Table calibration_wand_table(const CalibrationSummary& s) {
  const PrintedCalibration paper = printed_calibration();
  Table table;
  table.id = "calibration_wand";
  table.title = fmt::format(
      "Finding the wand, simulated: {} units with {} samples each, the mean of {} frames a sample, ball of "
      "{:g} cm radius, seed {}",
      s.units, s.samples, s.frames, s.ball_radius_m * kCentimetresPerMetre, s.seed);
  table.columns = {{"method", "method", true},
                   {"scene", "scene", true},
                   {"inside: asked", "inside_asked"},
                   {"answered", "inside_answered"},
                   {"distance: mean (cm)", "inside_distance_mean_cm"},
                   {"sd (cm)", "inside_distance_sd_cm"},
                   {"95 % from (cm)", "inside_distance_mean_low_cm"},
                   {"to (cm)", "inside_distance_mean_high_cm"},
                   {"3-D: mean (cm)", "inside_mean_cm"},
                   {"sd (cm)", "inside_sd_cm"},
                   {"95 % from (cm)", "inside_mean_low_cm"},
                   {"to (cm)", "inside_mean_high_cm"},
                   {"span: asked", "span_asked"},
                   {"answered", "span_answered"},
                   {"3-D: mean (cm)", "span_mean_cm"},
                   {"median (cm)", "span_median_cm"},
                   {"p95 (cm)", "span_p95_cm"},
                   {"another thing", "another_thing"},
                   {fmt::format("valid below {:g} m (%)", paper.near_m), "near_valid_percent"},
                   {"statuses", "statuses", true}};
  table.rows.push_back(paper_row(paper));
  for (std::size_t row = 0; row < s.wand.size(); ++row)
    table.rows.push_back(wand_cells(s.wand[row], wrong_things(s, row)));
  table.notes = wand_notes(s, paper);
  return table;
}

Table calibration_bins_table(const CalibrationSummary& s) {
  Table table;
  table.id = "calibration_bins";
  table.title = fmt::format(
      "Error of one wand position by distance and by angle, simulated: {} units with {} samples each, seed "
      "{}",
      s.units, s.samples, s.seed);
  table.columns = {{"method", "method", true},   {"scene", "scene", true},
                   {"by", "by", true},           {"from", "from", false, true},
                   {"to", "to", false, true},    {"n", "n"},
                   {"answered", "answered"},     {"distance: mean (cm)", "distance_mean_cm"},
                   {"3-D: mean (cm)", "mean_cm"}};
  for (const char* method : kMainWandMethods)
    for (std::size_t r = 0; r < s.wand.size(); ++r) {
      if (s.wand[r].method != method) continue;
      std::vector<Bin> distances = bins_of(kDistances_m), angles = bins_of(kAngles_deg);
      for (const WandSample& sample : s.wand_samples) {
        widen(distances, sample.distance_m);
        widen(angles, sample.angle_rad * kDegreesPerRad);
      }
      for (const WandSample& sample : s.wand_samples) {
        if (sample.row != r) continue;
        for (Bin& bin : distances) bin.add(sample.distance_m, sample);
        for (Bin& bin : angles) bin.add(sample.angle_rad * kDegreesPerRad, sample);
      }
      add_bins(table, s.wand[r], "distance (m)", distances);
      add_bins(table, s.wand[r], "angle (degrees)", angles);
    }
  table.notes = {
      "Bins of distance hold every angle and bins of angle every distance; a sample on an edge counts in the "
      "bin above it, on the last in the last; n includes samples without an answer, the mean does not."};
  return table;
}

}  // namespace trilat
