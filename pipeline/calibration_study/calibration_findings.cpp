// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_findings.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"

namespace trilat {
namespace {

std::string answers_text(const ErrorSpread& spread) {
  if (spread.answered == 0) return fmt::format("0 of {} answered", spread.asked);
  return fmt::format("{} of {} answered, mean error {:.2f} cm", spread.answered, spread.asked,
                     spread.mean_m * kCentimetresPerMetre);
}

std::string scene_text(const std::string& scene) {
  return (scene == "room" ? "in the " : "before a ") + scene;
}

std::vector<std::string> scenes_of(const CalibrationSummary& s) {
  std::vector<std::string> scenes;
  for (const WandRow& row : s.wand)
    if (std::ranges::find(scenes, row.scene) == scenes.end()) scenes.push_back(row.scene);
  return scenes;
}

// "before a far wall: 0 of 173 answered, corrected …; in the room …"; empty without such rows.
std::string beside_corrected(const CalibrationSummary& s, const std::string& method) {
  std::string text;
  for (const std::string& scene : scenes_of(s)) {
    const WandRow *row = wand_row(s, method, scene), *corrected = wand_row(s, "corrected", scene);
    if (!row || !corrected) continue;
    text += fmt::format("{}{}: {} (corrected: {})", text.empty() ? "" : "; ", scene_text(scene),
                        answers_text(row->recommended), answers_text(corrected->recommended));
  }
  return text;
}

double worst_printed_m(const CalibrationSummary& s) {
  double worst_m = -1.0;
  for (const DistortionCurve& curve : s.distortion)
    for (double error_m : curve.printed_error_m)
      if (std::isfinite(error_m)) worst_m = std::max(worst_m, error_m);
  return worst_m < 0.0 ? ErrorSpread::kNone : worst_m;
}

std::string paper_sentence() {
  const PrintedCalibration paper = printed_calibration();
  return fmt::format(
      "The paper states, of real sensors and a laser meter: {} samples; recommended are {:g} to {:g} m and "
      "below {:g} degrees; {} samples inside give {:g} +- {:g} cm; nearer than {:g} m only {:g} % of "
      "calibrations are valid.",
      paper.samples, paper.recommended_m[0], paper.recommended_m[1], paper.recommended_below_deg,
      paper.recommended_samples, paper.recommended_mean_cm, paper.recommended_spread_cm, paper.near_m,
      paper.near_valid_percent);
}

std::string wand_sentence(const CalibrationSummary& s) {
  std::string ours, printed;
  for (const std::string& scene : scenes_of(s)) {
    if (const WandRow* row = wand_row(s, "ours", scene))
      ours += fmt::format("{} {}, {} of the distance and {} in three dimensions, {} of {} answered",
                          ours.empty() ? "" : ";", scene_text(scene), mean_text(row->recommended_distance),
                          mean_text(row->recommended), row->recommended.answered, row->recommended.asked);
    if (const WandRow* row = wand_row(s, "as printed", scene))
      printed += fmt::format("{} {}, {}", printed.empty() ? "" : ";", scene_text(scene),
                             answers_text(row->recommended));
  }
  std::string text;
  if (!ours.empty())
    text = fmt::format(
        "Simulated, inside the recommended range, the mean error of our way of finding the wand is:{}; the "
        "intervals are over {} units.",
        ours, s.units);
  if (!printed.empty())
    text += fmt::format("{}The paper's method as printed:{}.", text.empty() ? "Simulated: " : " ", printed);
  return text;
}

std::string offset_sentence(const CalibrationSummary& s) {
  std::string text =
      "Why the two numbers may differ: every simulated unit adds a constant of its own to all depths, which "
      "a method that looks through one sensor cannot know, and it is in our error";
  if (!s.distortion.empty()) {
    const auto [low, high] =
        std::minmax_element(s.distortion.begin(), s.distortion.end(),
                            [](const auto& a, const auto& b) { return a.unit_offset_m < b.unit_offset_m; });
    text += fmt::format(" ({:+.1f} to {:+.1f} mm in the {} units that looked at the wall)",
                        low->unit_offset_m / kMetresPerMillimetre, high->unit_offset_m / kMetresPerMillimetre,
                        s.distortion.size());
  }
  return text + "; what the paper's sensors and its laser meter added is not known.";
}

std::string rigs_sentence(const CalibrationSummary& s) {
  const RigRow* wand = rig_row(s, "wand");
  const RigRow* printed = rig_row(s, "two positions, eq. 6 and 7 as printed");
  std::string text;
  if (wand)
    text = fmt::format("Sensors of whole rigs, calibrated from {} wand positions, are off by {}", s.positions,
                       mean_text(wand->position));
  if (printed)
    text += fmt::format(
        "{} two positions with eq. 6 and 7 as printed leave {} of {} sensors without a pose and the others "
        "off by {}",
        text.empty() ? "Of whole rigs," : ";", printed->position.asked - printed->position.answered,
        printed->position.asked, mean_text(printed->position));
  return text.empty() ? text : text + ".";
}

std::string distortion_sentence(const CalibrationSummary& s) {
  if (s.distortion.empty()) return {};
  std::vector<double> depth, residual, printed;
  for (const DistortionCurve& curve : s.distortion) {
    depth.push_back(column_means(curve.depth_error_m).edge_to_middle());
    residual.push_back(column_means(curve.depth_residual_m).edge_to_middle());
    printed.push_back(column_means(curve.printed_error_m).edge_to_middle());
  }
  const auto range = [](std::vector<double> values) -> std::string {
    std::erase_if(values, [](double v) { return !std::isfinite(v); });
    if (values.empty()) return "an unknown number of";
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    const std::string from = fmt::format("{:.2f}", *low), to = fmt::format("{:.2f}", *high);
    return from == to ? from : from + " to " + to;
  };
  std::string text = fmt::format(
      "The paper finds a flat wall's error at the left and right of the image \"{}\" than in the middle; "
      "simulated, by unit, the depth there is off by {} times the middle's error, {} times without the "
      "unit's constant offset.",
      printed_calibration().worse, range(depth), range(residual));
  if (const double worst_m = worst_printed_m(s); std::isfinite(worst_m))
    text += fmt::format(
        " The sideways error of eq. 4 as printed (E2) is there {} times the middle's, up to {:.2f} cm.",
        range(printed), worst_m * kCentimetresPerMetre);
  return text;
}

}  // namespace

std::string mean_text(const ErrorSpread& spread) {
  if (spread.answered == 0 || !std::isfinite(spread.mean_m)) return "an unknown distance (no answer)";
  std::string text = fmt::format("{:.2f} cm", spread.mean_m * kCentimetresPerMetre);
  if (!std::isfinite(spread.mean_low_m) || !std::isfinite(spread.mean_high_m))
    return text + " (too few units or runs for an interval)";
  return text + fmt::format(" (95 % interval {:.2f} to {:.2f} cm)", spread.mean_low_m * kCentimetresPerMetre,
                            spread.mean_high_m * kCentimetresPerMetre);
}

std::vector<WandErratum> wand_errata(const CalibrationSummary& s) {
  const double worst_m = worst_printed_m(s);
  const std::string worst = std::isfinite(worst_m) ? fmt::format(", up to {:.2f} cm sideways at the wall",
                                                                 worst_m * kCentimetresPerMetre)
                                                   : std::string();
  const std::array<std::array<std::string, 2>, 5> errata{
      {{"corrected, but eq. 1 as printed",
        "E17: eq. 1 as printed lifts pixels without a depth to the nearest depth of all, where the wand is "
        "looked for"},
       {"corrected, but E1 as printed",
        "E1: eq. 3 as printed stops when the smallest depth, made smaller still, reaches the largest, which "
        "never happens"},
       {"corrected by the mid-range",
        "E1, read otherwise: half of the sum of smallest and largest depth, times 1.005, is the threshold of "
        "eq. 2, and it ends where all that is left lies below the next"},
       {"corrected, but E2 as printed",
        "E2: eq. 4 as printed is linear in the angle where a lens is linear in the tangent" + worst},
       {"corrected, but E3 as printed",
        "E3: eq. 5 as printed adds a width in pixels to centimetres, and a width where a radius is meant"}}};
  std::vector<WandErratum> found;
  for (const auto& [method, problem] : errata)
    if (const std::string measured = beside_corrected(s, method); !measured.empty())
      found.push_back({problem.substr(0, problem.find_first_of(":,")), problem,
                       "inside the recommended range, " + measured});
  return found;
}

std::vector<std::string> calibration_sentences(const CalibrationSummary& s) {
  std::vector<std::string> sentences{paper_sentence()};
  const std::string wand = wand_sentence(s);
  for (const std::string& sentence :
       {wand, wand.empty() ? wand : offset_sentence(s), rigs_sentence(s), distortion_sentence(s)})
    if (!sentence.empty()) sentences.push_back(sentence);
  return sentences;
}

namespace {

// Where the paper sees the error grow: columns 0 to 149 and 351 to the last.
constexpr std::size_t kMiddleFrom = 150, kMiddleTo = 350;

struct Mean {
  double sum = 0.0, n = 0.0;
  void add(double value) {
    if (!std::isfinite(value)) return;
    sum += value;
    n += 1.0;
  }
  double value() const { return n > 0.0 ? sum / n : ErrorSpread::kNone; }
};

}  // namespace

const WandRow* wand_row(const CalibrationSummary& summary, const std::string& method,
                        const std::string& scene) {
  for (const WandRow& row : summary.wand)
    if (row.method == method && row.scene == scene) return &row;
  return nullptr;
}

const RigRow* rig_row(const CalibrationSummary& summary, const std::string& method) {
  for (const RigRow& row : summary.rigs)
    if (row.method == method) return &row;
  return nullptr;
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

}  // namespace trilat
