// SPDX-License-Identifier: MIT
#include "pipeline/variations/variations_results.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"
#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/metrics/first_order_index.h"
#include "evaluators/metrics/share.h"

namespace trilat {
namespace {

constexpr double kPercent = 100.0;

std::uint64_t points_with_errors(const VariationsSummary& s) { return s.points.size() - s.failed(); }

Estimate share_of_points(const std::vector<bool>& holds) {
  const auto count = static_cast<double>(std::ranges::count(holds, true));
  const ShareEstimate share = estimate_share(count, static_cast<double>(holds.size()));
  return {share.value, share.low, share.high};
}

ContrastEstimate mean_of(const std::vector<double>& values) {
  return solve_contrast({{{values, std::vector<double>(values.size(), 1.0)}}, {}});
}

double percent_of_log(double log_ratio) { return kPercent * std::expm1(log_ratio); }

std::vector<DecidingRange> deciding_ranges(const VariationsSummary& s,
                                           const std::vector<double>& log_ratios) {
  std::vector<DecidingRange> list;
  for (std::size_t r = 0; r < s.ranges.size(); ++r) {
    std::vector<double> positions;
    for (const VariationPoint& point : s.points) positions.push_back(point.position[r]);
    const VarianceShare share = first_order_index(positions, log_ratios);
    list.push_back({s.ranges[r].name, {share.value, share.low, share.high}});
  }
  std::ranges::stable_sort(list, [](const DecidingRange& a, const DecidingRange& b) {
    return a.first_order.value > b.first_order.value;
  });
  return list;
}

ComparisonShare compare(const VariationsSummary& s, const MethodComparison& comparison,
                        std::size_t alignment) {
  ComparisonShare result{.alignment = s.alignments[alignment]};
  std::vector<double> by_point, compared;
  std::vector<bool> holds;
  for (const VariationPoint& point : s.points) {
    const double percent = comparison.difference_percent(s.methods, point, alignment);
    by_point.push_back(std::log1p(percent / kPercent));
    if (!std::isfinite(by_point.back())) continue;
    compared.push_back(by_point.back());
    holds.push_back(percent < 0.0);
    result.worst_percent = std::fmax(result.worst_percent, percent);
  }
  result.compared = compared.size();
  if (compared.empty()) return result;
  result.share = share_of_points(holds);
  const ContrastEstimate mean = mean_of(compared);
  result.difference_percent = {percent_of_log(mean.value), percent_of_log(mean.low()),
                               percent_of_log(mean.high())};
  result.decided_by = deciding_ranges(s, by_point);
  return result;
}

// Whether a method errs less than every other on the samples that both answer.
bool is_best(const VariationsSummary& s, const VariationPoint& point, std::size_t m) {
  const std::size_t methods = s.methods.size();
  if (!std::isfinite(point.paired_m[m * methods + m])) return false;
  for (std::size_t other = 0; other < methods; ++other)
    if (m != other && point.paired_m[m * methods + other] > point.paired_m[other * methods + m]) return false;
  return true;
}

std::vector<BestShare> best_shares(const VariationsSummary& s) {
  std::vector<BestShare> shares;
  for (std::size_t m = 0; m < s.methods.size(); ++m) {
    std::vector<bool> best;
    for (const VariationPoint& point : s.points)
      if (point.problem.empty()) best.push_back(is_best(s, point, m));
    shares.push_back({s.methods[m], share_of_points(best)});
  }
  return shares;
}

std::string percent_text(const Estimate& share) {
  return fmt::format("{:.0f} % ({:.0f} to {:.0f})", kPercent * share.value, kPercent * share.low,
                     kPercent * share.high);
}

// The ranges whose share of the variance is surely above zero.
std::string decided_text(const ComparisonShare& in) {
  constexpr std::size_t kMost = 3;
  std::vector<std::string> names;
  for (const DecidingRange& range : in.decided_by)
    if (range.first_order.low > 0.0 && names.size() < kMost)
      names.push_back(fmt::format("{} {}", range.range, percent_text(range.first_order)));
  return fmt::format("{}", fmt::join(names, ", "));
}

// Empty where nothing was compared.
std::string sentence_of(const VariationsSummary& s, const MethodComparison& comparison) {
  if (s.ranges.empty() || comparison.by_alignment.front().compared == 0) return {};
  const ComparisonShare& first = comparison.by_alignment.front();
  std::string text =
      fmt::format("**{}** holds in {} of {} simulated campaigns all over the ranges, aligned `{}`",
                  comparison.name, percent_text(first.share), first.compared, first.alignment);
  for (const ComparisonShare& in : std::span(comparison.by_alignment).subspan(1))
    if (in.compared > 0) text += fmt::format("; `{}` {}", in.alignment, percent_text(in.share));
  if (const std::string decided = decided_text(first); !decided.empty())
    text += fmt::format("; what decides it: {} of the variance", decided);
  return text + '.';
}

std::vector<std::string> sentences_of(const VariationsSummary& s) {
  std::vector<std::string> sentences;
  for (const MethodComparison& comparison : s.comparisons)
    if (const std::string sentence = sentence_of(s, comparison); !sentence.empty())
      sentences.push_back(sentence);
  if (s.failed() > 0)
    sentences.push_back(
        fmt::format("{} of {} campaigns have no errors: points.csv says why.", s.failed(), s.points.size()));
  return sentences;
}

std::string campaigns_text(const VariationsSummary& s) {
  return fmt::format("{} simulated campaigns of {} participant{} each", points_with_errors(s), s.participants,
                     s.participants == 1 ? "" : "s");
}

Table shares_table(const VariationsSummary& s) {
  struct Row {
    std::string name, decided;
    ComparisonShare in;
  };
  std::vector<Row> rows;
  for (std::size_t a = 0; a < s.alignments.size(); ++a)
    for (const MethodComparison& comparison : s.comparisons) {
      const ComparisonShare& in = comparison.by_alignment[a];
      rows.push_back({comparison.name, decided_text(in), in});
    }
  using C = ComparisonShare;
  Table table = table_of<Row>(
      "comparisons",
      fmt::format("In which share of the ranges each comparison holds ({})", campaigns_text(s)), rows,
      {{"comparison", "comparison", as_text(&Row::name)},
       {"alignment", "alignment", of(&Row::in, as_text(&C::alignment))},
       {"compared in", "compared", of(&Row::in, as_count(&C::compared))},
       {"holds in (%)", "share_percent", of(&Row::in, as_number(1, kPercent, &C::share))},
       {"mean difference (%)", "difference_percent", of(&Row::in, as_number(1, 1.0, &C::difference_percent))},
       {"at worst (%)", "worst_percent", of(&Row::in, as_number(1, &C::worst_percent))},
       {"decided by", "decided_by", as_text(&Row::decided)}});
  table.first_rows = s.comparisons.size();
  table.notes = {
      "Each campaign is one independent point of the ranges, with persons of its own. Intervals are of 95 %: "
      "of shares Clopper and Pearson's, of the mean difference Student's t between points.",
      "The difference is the error of the first method over that of the others, on the samples that both "
      "answer, the largest of these ratios, less the margin; below 0 the comparison holds. Its mean is "
      "geometric.",
      "Decided by: the ranges that explain by themselves a share of how the logarithm of the ratio varies "
      "which is surely above zero (first-order index, 95 % interval by a jackknife over the points)."};
  return table;
}

Table deciding_table(const VariationsSummary& s) {
  struct Row {
    std::string name, alignment;
    DecidingRange range;
  };
  std::vector<Row> rows;
  for (const MethodComparison& comparison : s.comparisons)
    for (const ComparisonShare& in : comparison.by_alignment)
      for (const DecidingRange& range : in.decided_by) rows.push_back({comparison.name, in.alignment, range});
  using D = DecidingRange;
  return table_of<Row>(
      "decided_by", fmt::format("What decides each difference: first-order indices ({})", campaigns_text(s)),
      rows,
      {{"comparison", "comparison", as_text(&Row::name)},
       {"alignment", "alignment", as_text(&Row::alignment)},
       {"range", "range", of(&Row::range, as_text(&D::range))},
       {"share of the variance (%)", "first_order_percent",
        of(&Row::range, as_number(1, kPercent, &D::first_order))}});
}

Table best_table(const VariationsSummary& s) {
  return table_of<BestShare>(
      "best_methods", fmt::format("Which method errs least: share of the ranges ({})", campaigns_text(s)),
      s.best,
      {{"method", "method", as_text(&BestShare::method)},
       {"best in (%)", "share_percent", as_number(1, kPercent, &BestShare::share)}});
}

std::string values_text(const VariedRange& r) {
  if (!r.values.empty()) return fmt::format("{}", fmt::join(r.values, ", "));
  return fmt::format("{:g} to {:g}{}{}", r.low, r.high, r.unit.empty() ? "" : ' ' + r.unit,
                     r.logarithmic ? ", logarithmic"
                     : r.whole     ? ", whole"
                                   : "");
}

Table ranges_table(const VariationsSummary& s) {
  using R = VariedRange;
  return table_of<R>("ranges", "The ranges that were simulated", s.ranges,
                     {{"name", "name", as_text(&R::name)},
                      {"setting", "setting", as_text(&R::setting)},
                      {"values", "values", as_text(values_text)}});
}

// Between participants.
TableValue error_cell(const std::vector<double>& person_m) {
  const ContrastEstimate mean = mean_of(person_m);
  return cm_cell(mean.value, mean.low_of_size(), mean.high());
}

TableValue change_cell(const std::vector<double>& person_m, const std::vector<double>& first_m) {
  if (person_m.size() != first_m.size()) return no_cell();
  std::vector<double> changes_m;
  for (std::size_t p = 0; p < person_m.size(); ++p) changes_m.push_back(person_m[p] - first_m[p]);
  const ContrastEstimate mean = mean_of(changes_m);
  return cm_cell(mean.value, mean.low(), mean.high());
}

Table patches_table(const VariationsSummary& s) {
  Table table;
  table.id = "patches";
  table.title =
      fmt::format("Mean error in cm of each variation, simulated ({} participants, seed {}; alignment: {})",
                  s.participants, s.seed, s.alignments.front());
  table.columns = {{"variation", "variation", true}};
  for (const std::string& method : s.methods) {
    table.columns.push_back(interval_column(method, method + "_mae_cm"));
    table.columns.push_back(interval_column("change", method + "_change_cm"));
  }
  table.columns.push_back({"answered at least (%)", "answered_percent"});
  const VariationPoint& first = s.points.front();
  for (const VariationPoint& point : s.points) {
    std::vector<TableValue>& row = table.rows.emplace_back();
    row.push_back(TableValue::of(point.name));
    for (std::size_t m = 0; m < s.methods.size(); ++m) {
      const bool is_there = point.problem.empty();
      row.push_back(is_there ? error_cell(point.person_m[m]) : no_cell());
      row.push_back(is_there && first.problem.empty() && &point != &first
                        ? change_cell(point.person_m[m], first.person_m[m])
                        : no_cell());
    }
    row.push_back(point.problem.empty() ? percent_cell(*std::ranges::min_element(point.answered))
                                        : no_cell());
  }
  table.notes = {
      fmt::format("Change: against \"{}\", paired by participant: all variations are of the same persons and "
                  "movements. Intervals are of 95 %, by Student's t between participants.",
                  first.name),
      "Errors are the mean of the joint groups; answered: of the method that answers least."};
  return table;
}

Figure shares_figure(const VariationsSummary& s) {
  Figure figure;
  figure.id = "comparisons";
  figure.title = "In which share of the ranges each comparison holds (simulated)";
  figure.caption =
      fmt::format("{}, each at one point of {} ranges of settings; exact 95 % intervals of the share.",
                  campaigns_text(s), s.ranges.size());
  figure.x_label = "campaigns in which it holds (%)";
  figure.panels = {fmt::format("{} campaigns", points_with_errors(s))};
  for (std::size_t a = 0; a < s.alignments.size(); ++a) {
    FigureSeries series{"aligned " + s.alignments[a], FigureSeries::Style::dots, {}};
    for (std::size_t c = 0; c < s.comparisons.size(); ++c) {
      const Estimate& share = s.comparisons[c].by_alignment[a].share;
      const double place =
          static_cast<double>(c) +
          0.2 * (static_cast<double>(a) - 0.5 * static_cast<double>(s.alignments.size() - 1));
      series.points.push_back({kPercent * share.value, place, kPercent * share.low, kPercent * share.high});
    }
    figure.series.push_back(std::move(series));
  }
  for (const MethodComparison& comparison : s.comparisons) figure.y_names.push_back(comparison.name);
  return figure;
}

Figure patches_figure(const VariationsSummary& s) {
  Figure figure;
  figure.id = "patches";
  figure.title = "Mean error of each variation (simulated)";
  figure.caption = fmt::format("Simulated: {} participants, aligned {}; 95 % intervals between them.",
                               s.participants, s.alignments.front());
  figure.x_label = "mean error (cm)";
  figure.panels = {"aligned " + s.alignments.front()};
  for (std::size_t m = 0; m < s.methods.size(); ++m) {
    FigureSeries series{s.methods[m], FigureSeries::Style::dots, {}, {}, s.methods[m]};
    for (std::size_t p = 0; p < s.points.size(); ++p) {
      if (!s.points[p].problem.empty()) continue;
      const ContrastEstimate mean = mean_of(s.points[p].person_m[m]);
      series.points.push_back({kCentimetresPerMetre * mean.value, static_cast<double>(p),
                               kCentimetresPerMetre * mean.low_of_size(),
                               kCentimetresPerMetre * mean.high()});
    }
    figure.series.push_back(std::move(series));
  }
  for (const VariationPoint& point : s.points) figure.y_names.push_back(point.name);
  return figure;
}

}  // namespace

void analyse(VariationsSummary& summary) {
  for (MethodComparison& comparison : summary.comparisons) {
    comparison.by_alignment.clear();
    for (std::size_t a = 0; a < summary.alignments.size(); ++a)
      comparison.by_alignment.push_back(compare(summary, comparison, a));
  }
  if (!summary.ranges.empty()) summary.best = best_shares(summary);
  summary.sentences = sentences_of(summary);
}

StoredTables variation_tables(const VariationsSummary& s) {
  StoredTables shown;
  shown.title = s.study;
  shown.asked = s.ranges.empty() ? "What does each change of the simulation do to the errors?"
                                 : "Where in the ranges do the conclusions hold, and what decides?";
  shown.about = fmt::format(
      "Variations of a simulation, **simulated**: {} campaigns of {} participant{} each, seed {}.",
      s.points.size(), s.participants, s.participants == 1 ? "" : "s", s.seed);
  shown.findings = s.sentences;
  // the paper's method against the simplest one
  for (const MethodComparison& comparison : s.comparisons)
    if (comparison.better == "nonlinear" && comparison.than == std::vector<std::string>{"mean"})
      if (const std::string sentence = sentence_of(s, comparison); !sentence.empty())
        shown.on_the_paper.push_back(sentence);
  if (s.ranges.empty())
    shown.tables = {patches_table(s)};
  else
    shown.tables = {shares_table(s), best_table(s), deciding_table(s), ranges_table(s)};
  shown.tables.front().shown = Table::Shown::first;
  return shown;
}

std::vector<Figure> variation_figures(const VariationsSummary& s) {
  if (!s.ranges.empty() && s.comparisons.empty()) return {};
  Figure figure = s.ranges.empty() ? patches_figure(s) : shares_figure(s);
  figure.is_first = true;
  return {std::move(figure)};
}

}  // namespace trilat
