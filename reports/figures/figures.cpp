// SPDX-License-Identifier: MIT
#include "reports/figures/figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/base/words.h"
#include "datasets/results/item_store.h"
#include "datasets/results/table.h"

namespace trilat {
namespace {

constexpr double kShown_s = 10.0;
constexpr std::size_t kMaxMethods = 4;
// The paper draws a wrist when walking, an elbow when swinging arms and an ankle when crossing legs.
const char* drawn_joint(const std::string& condition) {
  return condition == "arm_swing"      ? "elbow_right"
         : condition == "leg_crossing" ? "ankle_right"
                                       : "wrist_right";
}

// Methods that the paper draws, in the order of interest; the first ones that the study has are shown.
constexpr std::array kMethods{"nonlinear as printed",           "linear", "geometric", "nonlinear",
                              "nonlinear, occlusion corrected", "mean"};

struct Path {
  std::vector<double> time_s, truth_m;          // height
  std::vector<std::vector<double>> estimate_m;  // by method
};

// Status numbers that are answers.
std::set<std::uint8_t> usable_statuses(const TakeHead& header) {
  std::set<std::uint8_t> usable;
  for (std::size_t k = 0; k < header.status_names.size(); ++k)
    if (is_answer(header.status_names[k])) usable.insert(static_cast<std::uint8_t>(k));
  return usable;
}

Path read_path(const StoredTake& samples, std::size_t joint) {
  constexpr std::uint64_t kBlock = 1024;
  const TakeHead& header = samples.head();
  const std::size_t joints = header.joints.size(), methods = header.methods.size();
  const std::set<std::uint8_t> usable = usable_statuses(header);
  Path path;
  path.estimate_m.resize(methods);
  const std::uint64_t instants = header.instants;
  std::int64_t start_ns = 0;
  for (std::uint64_t first = 0; first < instants; first += kBlock) {
    const SampleBlock block =
        samples.read(0, first, std::min(kBlock, instants - first), SampleColumns::errors);
    if (first == 0 && block.instants > 0) start_ns = block.time_ns.front();
    for (std::uint64_t i = 0; i < block.instants; ++i) {
      path.time_s.push_back(static_cast<double>(block.time_ns[i] - start_ns) * 1e-9);
      path.truth_m.push_back(block.truth_m[(i * joints + joint) * 3 + 1]);
      for (std::size_t m = 0; m < methods; ++m) {
        const std::size_t slot = (i * joints + joint) * methods + m;
        path.estimate_m[m].push_back(
            usable.contains(block.status[slot]) ? static_cast<double>(block.estimate_m[slot * 3 + 1]) : kNaN);
      }
    }
  }
  return path;
}

std::vector<std::size_t> shown_methods(const TakeHead& header) {
  std::vector<std::size_t> shown;
  const auto show = [&](std::size_t m) {
    if (shown.size() < kMaxMethods && std::ranges::find(shown, m) == shown.end()) shown.push_back(m);
  };
  for (const char* name : kMethods)
    for (std::size_t m = 0; m < header.methods.size(); ++m)
      if (header.methods[m] == name) show(m);
  for (std::size_t m = 0; m < header.methods.size(); ++m) show(m);
  return shown;
}

// Adds `shift` and turns metres into centimetres.
FigureSeries series_of(const std::string& name, const Path& path, const std::vector<double>& height_m,
                       double shift_m) {
  FigureSeries series{name, FigureSeries::Style::line, {}, {}, name};
  for (std::size_t i = 0; i < path.time_s.size() && path.time_s[i] <= kShown_s; ++i)
    series.points.push_back({path.time_s[i], (height_m[i] + shift_m) * kCentimetresPerMetre});
  return series;
}

// Shift that makes the means over all instants that both have the same.
double shift_to_truth_m(const Path& path, const std::vector<double>& height_m) {
  double sum_m = 0.0, count = 0.0;
  for (std::size_t i = 0; i < height_m.size(); ++i) {
    const double off_m = path.truth_m[i] - height_m[i];
    if (!std::isfinite(off_m)) continue;
    sum_m += off_m;
    count += 1.0;
  }
  return sum_m / count;
}

// The joint to be shown, of those with any truth.
std::optional<std::size_t> shown_joint(const StoredTake& samples, Path& path) {
  const TakeHead& header = samples.head();
  std::vector<std::size_t> order;
  for (std::size_t j = 0; j < header.joints.size(); ++j)
    if (header.joints[j] == drawn_joint(header.condition)) order.push_back(j);
  for (std::size_t j = 0; j < header.joints.size(); ++j) order.push_back(j);
  for (const std::size_t j : order) {
    path = read_path(samples, j);
    if (std::ranges::any_of(path.truth_m, [](double y) { return std::isfinite(y); })) return j;
  }
  return std::nullopt;
}

Figure figure_of(const ResultsSummary& summary, const TakeHead& header, const Path& path,
                 const std::string& joint) {
  const std::vector<std::size_t> shown = shown_methods(header);
  Figure figure;
  figure.id = file_name_from(fmt::format("trajectory-{}-{}", header.condition, joint));
  const auto spaced = [](std::string name) {
    std::ranges::replace(name, '_', ' ');
    return name;
  };
  figure.title = fmt::format("Height of {}, {}, take {}{}", spaced(joint), spaced(header.condition),
                             header.id, summary.simulated ? ", simulated" : "");
  figure.caption = fmt::format(
      "{}The first {:g} s of the take; each method is moved by a constant so that its mean over the take is "
      "that of the truth, as in the paper's \"relative movement\". {} of the study's {} methods are drawn.",
      summary.simulated ? "Simulated. " : "", kShown_s, shown.size(), header.methods.size());
  figure.x_label = "time (s)";
  figure.y_label = "height (cm)";
  figure.series.push_back(series_of("truth", path, path.truth_m, 0.0));
  for (const std::size_t m : shown)
    figure.series.push_back(
        series_of(header.methods[m], path, path.estimate_m[m], shift_to_truth_m(path, path.estimate_m[m])));
  return figure;
}

}  // namespace

std::vector<Figure> trajectory_figures(const std::filesystem::path& results, const ResultsSummary& summary) {
  std::vector<Figure> figures;
  std::set<std::string> shown;
  for (const ResultTake& take : result_takes(results)) {
    if (take.folder.empty() || shown.contains(take.condition)) continue;
    const StoredTake samples = open_take(take);
    Path path;
    const auto joint = shown_joint(samples, path);
    if (!joint) continue;
    shown.insert(take.condition);
    figures.push_back(figure_of(summary, samples.head(), path, samples.head().joints[*joint]));
  }
  return figures;
}

namespace {

constexpr std::size_t kMaxCurves = 7, kMaxNights = 60;

// The columns whose error moved most from the first to the last night.
std::vector<std::string> moved_most(const std::vector<Night>& nights) {
  std::vector<std::pair<double, std::string>> columns;
  for (const auto& [column, last_m] : nights.back().mean_error_m) {
    const auto first = nights.front().mean_error_m.find(column);
    const bool was_there = first != nights.front().mean_error_m.end();
    columns.emplace_back(was_there ? -std::abs(last_m / first->second - 1.0) : 0.0, column);
  }
  std::ranges::stable_sort(columns, {}, &std::pair<double, std::string>::first);
  std::vector<std::string> names;
  for (const auto& [moved, column] : columns)
    if (names.size() < kMaxCurves) names.push_back(column);
  return names;
}

// "table3: nonlinear, walking", without the unit, which is not that of the figure.
std::string curve_name(const std::string& column) { return column.substr(0, column.rfind(" (")); }

}  // namespace

std::optional<Figure> history_figure(const std::vector<Night>& history) {
  std::vector<Night> nights(history.end() - static_cast<std::ptrdiff_t>(std::min(history.size(), kMaxNights)),
                            history.end());
  std::erase_if(nights, [](const Night& night) { return night.mean_error_m.empty(); });
  if (nights.empty()) return std::nullopt;
  Figure figure;
  figure.id = "history";
  figure.title = "Mean error by night";
  figure.caption = fmt::format(
      "Of {} nights, the averages over the joint groups that moved most; shaded: nights whose change was "
      "accepted as the new baseline. No intervals: the gate judges night by night.",
      nights.size());
  figure.y_label = "mean error (cm)";
  for (const Night& night : nights) figure.x_names.push_back(night.time.substr(0, 10));
  for (const std::string& column : moved_most(nights)) {
    FigureSeries series{curve_name(column), FigureSeries::Style::line_and_dots, {}};
    for (std::size_t n = 0; n < nights.size(); ++n)
      if (const auto error = nights[n].mean_error_m.find(column); error != nights[n].mean_error_m.end())
        series.points.push_back({static_cast<double>(n), error->second * kCentimetresPerMetre});
    figure.series.push_back(std::move(series));
  }
  for (std::size_t n = 0; n < nights.size(); ++n)
    if (nights[n].verdict == NightVerdict::accepted)
      figure.bands.push_back({static_cast<double>(n) - 0.4, static_cast<double>(n) + 0.4, "accepted"});
  return figure;
}

std::vector<std::string> history_sentences(const std::vector<Night>& history) {
  if (history.empty()) return {};
  const Night& last = history.back();
  std::vector<std::string> sentences;
  const std::string night = last.time.substr(0, 10);
  if (last.verdict == NightVerdict::accepted)
    sentences.push_back(
        fmt::format("**Night {}**: its results became the baseline: {}.", night, last.reason));
  else if (!last.alarms.empty())
    sentences.push_back(fmt::format("**Night {}: {}**, the first: {}.", night,
                                    counted(last.alarms.size(), "alarm"), last.alarms.front()));
  else if (!last.not_judged.empty())
    sentences.push_back(fmt::format("**Night {}: not judged**: {}.", night, last.not_judged.front()));
  else
    sentences.push_back(fmt::format("**Night {}: quiet**, nothing is worse than the baseline.", night));
  const auto accepted = std::find_if(history.rbegin(), history.rend(),
                                     [](const Night& one) { return one.verdict == NightVerdict::accepted; });
  if (accepted != history.rend() && accepted != history.rbegin())
    sentences.push_back(
        fmt::format("The baseline is that of {}: {}.", accepted->time.substr(0, 10), accepted->reason));
  return sentences;
}

}  // namespace trilat
