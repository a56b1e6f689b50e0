// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "reports/claim_evidence.h"
#include "reports/table_cells.h"

namespace trilat {
namespace {

constexpr const char* kAlignment = "mean";  // the paper's relative movement
constexpr const char* kWalking = "walking";
constexpr const char* kOurs = "nonlinear";
constexpr double kSimilar_percent = 10.0;

const SummaryCell* average_of(const ResultsSummary& s, const std::string& method) {
  return find_cell(s, method, kWalking, kAverageGroup, kAlignment);
}
const DifferenceCell* against_ours(const ResultsSummary& s, const std::string& method,
                                   const std::string& group = kAverageGroup) {
  return find_difference(s, method, kWalking, group, kAlignment);
}

// Of a method that should be worse than ours.
std::string worse_verdict(const DifferenceCell* d) {
  if (!d || !std::isfinite(d->low_m)) return kUndecided;
  return !d->significant() ? kUndecided : d->difference_m > 0.0 ? kHolds : kDoesNotHold;
}

ClaimVerdict better_than(const ResultsSummary& s, const std::string& method) {
  const DifferenceCell* d = against_ours(s, method);
  if (!d || !average_of(s, method)) return not_run("a study with " + method);
  ClaimVerdict v{fmt::format("{} against {}; {} is {}", cell_text(average_of(s, kOurs)),
                             cell_text(average_of(s, method)), method, worse_text(d)),
                 worse_verdict(d),
                 fmt::format("paired: {} on the {:.0f} % of samples that {} answers", paired_text(d),
                             100.0 * average_of(s, method)->coverage(), method)};
  if (const SummaryCell* printed = average_of(s, "nonlinear as printed"); printed && method == "linear")
    v.reason +=
        "; with equations 17 and 19 as printed it stops at the first step that lowers F, near the linear "
        "start: " +
        cell_text(printed);
  return v;
}

ClaimVerdict better_than_single(const ResultsSummary& s) {
  const DifferenceCell* best = nullptr;
  for (const DifferenceCell& d : s.differences)
    if (d.method.starts_with("single ") && d.condition == kWalking && d.group == kAverageGroup &&
        d.alignment == kAlignment && (!best || d.difference_m < best->difference_m))
      best = &d;
  if (!best) return not_run("a study with single sensors");
  const DifferenceCell* mean = against_ours(s, "mean");
  return {
      fmt::format("nonlinear {}; {} alone {}; plain mean of the sensors' positions {}",
                  cell_text(average_of(s, kOurs)), best->method.substr(7),
                  cell_text(average_of(s, best->method)), cell_text(average_of(s, "mean"))),
      worse_verdict(best),
      fmt::format(
          "against nonlinear trilateration one sensor is {}; the mean, a row the paper leaves out, is {}: "
          "ranges throw two of three coordinates away",
          worse_text(best), worse_text(mean))};
}

ClaimVerdict percentages(const ResultsSummary* s) {
  const PrintedTable3 printed = printed_table3();
  const std::vector<double>& a = printed.rows.back().mae_cm;  // the averages
  ClaimVerdict v{
      "–", kContradicts,
      fmt::format("24.1 % is {:.1f} % of nonlinear's error and 38.3 % is {:.1f} % of geometric's: by one "
                  "convention they are {:.1f} and {:.1f} % (of the other's error) or {:.1f} and {:.1f} % "
                  "(of nonlinear's)",
                  100.0 * (a[0] - a[2]) / a[2], 100.0 * (a[1] - a[2]) / a[1], 100.0 * (a[0] - a[2]) / a[0],
                  100.0 * (a[1] - a[2]) / a[1], 100.0 * (a[0] - a[2]) / a[2], 100.0 * (a[1] - a[2]) / a[2])};
  if (!s) return v;
  const DifferenceCell *linear = against_ours(*s, "linear"), *geometric = against_ours(*s, "geometric");
  if (linear && geometric)
    v.ours = fmt::format("{:.1f} and {:.1f} % of the other's error; {:.1f} and {:.1f} % of nonlinear's",
                         linear->percent_of_method, geometric->percent_of_method,
                         linear->percent_of_reference, geometric->percent_of_reference);
  return v;
}

ClaimVerdict head_similar(const ResultsSummary& s) {
  const DifferenceCell *linear = against_ours(s, "linear", "head"),
                       *geometric = against_ours(s, "geometric", "head");
  if (!linear || !geometric) return not_run("a study with linear and geometric at the head");
  const auto inside = [](const DifferenceCell* d) {
    return d->percent_low > -kSimilar_percent && d->percent_high < kSimilar_percent;
  };
  const auto outside = [](const DifferenceCell* d) {
    return d->percent_low > kSimilar_percent || d->percent_high < -kSimilar_percent;
  };
  const auto text = [](const DifferenceCell* d) {
    return fmt::format("{:.1f} % ({:.1f} to {:.1f})", d->percent_of_reference, d->percent_low,
                       d->percent_high);
  };
  return {fmt::format("linear {} and geometric {} against nonlinear", text(linear), text(geometric)),
          inside(linear) && inside(geometric)     ? kHolds
          : outside(linear) || outside(geometric) ? kDoesNotHold
                                                  : kUndecided,
          fmt::format("\"about the same\" is taken as within {:g} %", kSimilar_percent)};
}

ClaimVerdict wrist_worst(const ResultsSummary& s) {
  const SummaryCell* wrist = find_cell(s, kOurs, kWalking, "wrist", kAlignment);
  const SummaryCell* next = nullptr;
  for (const char* group : {"head", "shoulder", "elbow"}) {
    const SummaryCell* cell = find_cell(s, kOurs, kWalking, group, kAlignment);
    if (cell && (!next || cell->mae_m > next->mae_m)) next = cell;
  }
  if (!wrist || !next) return not_run("a study with wrists");
  return {fmt::format("wrist {}; next the {} {}", cell_text(wrist), next->group, cell_text(next)),
          wrist->mae_low_m > next->mae_high_m   ? kHolds
          : wrist->mae_high_m < next->mae_low_m ? kDoesNotHold
                                                : kUndecided,
          "it moves fastest, so a tracker that lags is farthest behind there"};
}

ClaimVerdict wrist_deviation(const ResultsSummary* s) {
  ClaimVerdict v{"–", kContradicts, "a mean cannot be larger than the largest"};
  const SummaryCell* wrist = s ? find_cell(*s, kOurs, kWalking, "wrist", kAlignment) : nullptr;
  if (wrist)
    v.ours = fmt::format("mean {:.1f}, median {:.1f}, 95 % below {:.1f}, largest {:.1f} cm",
                         wrist->mae_m * kCentimetresPerMetre, wrist->median_m * kCentimetresPerMetre,
                         wrist->p95_m * kCentimetresPerMetre, wrist->max_m * kCentimetresPerMetre);
  return v;
}

// On the same three sensors geometric and nonlinear are the same point wherever both answer (a law of the
// solvers' tests), so what is left of their difference is which samples they answer.
ClaimVerdict three_sensors(const ResultsSummary& s) {
  const char* kSame = "nonlinear, 3 sensors";
  const DifferenceCell* same = against_ours(s, kSame);
  if (!average_of(s, "geometric") || !average_of(s, kSame) || !same || !std::isfinite(same->difference_m))
    return not_run("a study with three sensors");
  const SummaryCell *mine = average_of(s, kSame), *theirs = average_of(s, "geometric");
  const auto clamped = theirs->statuses.find("clamped");
  return {fmt::format("without the fourth sensor nonlinear is {}", worse_text(same)), worse_verdict(same),
          fmt::format(
              "with the same three sensors geometric and nonlinear give the same point wherever both answer; "
              "{} and {} differ because geometric answers {:.0f} % of the samples, {:.0f} % of them "
              "clamped where the spheres do not meet, and nonlinear {:.0f} %",
              cell_text(theirs), cell_text(mine), 100.0 * theirs->coverage(),
              clamped == theirs->statuses.end() ? 0.0 : 100.0 * share_of(clamped->second, theirs->answered),
              100.0 * mine->coverage())};
}

ClaimVerdict more_sensors(const std::vector<ResultsSummary>& studies) {
  if (studies.empty()) return not_run("the studies of two to eight sensors");
  ClaimVerdict v{"", kHolds, "eight sensors against four of them, by rig; "};
  for (const ResultsSummary& s : studies) {
    if (s.reference != "nonlinear, 4 sensors") return not_run("studies that compare with four sensors");
    const DifferenceCell* d = find_difference(s, "nonlinear, 8 sensors", kWalking, kAverageGroup, kAlignment);
    v.ours += fmt::format("{}{}: 4 sensors {}, 8 sensors {}", v.ours.empty() ? "" : "; ", s.campaign,
                          cell_text(average_of(s, "nonlinear, 4 sensors")),
                          cell_text(average_of(s, "nonlinear, 8 sensors")));
    if (d && d->significant() && d->difference_m > 0.0)
      v.verdict = kDoesNotHold;
    else if ((!d || !d->significant()) && v.verdict == kHolds)
      v.verdict = kUndecided;
    const SummaryCell* mean = average_of(s, "mean, 4 sensors");
    v.reason += fmt::format("the mean of four on {}: {}; ", s.campaign, cell_text(mean));
  }
  v.reason.resize(v.reason.size() - 2);
  return v;
}

}  // namespace

ClaimVerdict verdict_on_methods(const std::string& claim, const ClaimEvidence& e) {
  if (claim == "more_sensors") return more_sensors(e.sensor_counts);
  if (claim == "percentages") return percentages(e.walking ? &*e.walking : nullptr);
  if (claim == "wrist_deviation") return wrist_deviation(e.walking ? &*e.walking : nullptr);
  if (!e.walking || e.walking->reference != kOurs) return not_run("Table III");
  if (claim == "better_than_single") return better_than_single(*e.walking);
  if (claim == "better_than_linear") return better_than(*e.walking, "linear");
  if (claim == "better_than_geometric") return better_than(*e.walking, "geometric");
  if (claim == "head_similar") return head_similar(*e.walking);
  if (claim == "wrist_worst") return wrist_worst(*e.walking);
  return three_sensors(*e.walking);
}

}  // namespace trilat
