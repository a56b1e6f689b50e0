// SPDX-License-Identifier: MIT
#include "pipeline/stream_fit/stream_fit.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "evaluators/metrics/statistics.h"
#include "pipeline/stream_fit/stream_search.h"

namespace trilat {
namespace {

constexpr double kMinGain_m = 0.008;
constexpr double kMarginAlpha = 0.32;   // one standard error
constexpr double kUnexplained_m = 0.2;  // mean distance

class ChangeChoice {
 public:
  ChangeChoice(const StreamPair& pair, const TimeBlocks& blocks, const StreamFitOptions& options,
               std::vector<JudgedChange> judged)
      : pair_(pair), blocks_(blocks), options_(options), judged_(std::move(judged)) {}

  StreamFit choose(StreamFit fit) const {
    if (judged_.empty()) return fit;
    const auto best = std::ranges::min_element(judged_, {}, &JudgedChange::mean_m);
    std::size_t blocks = 0;
    for (const double m : best->errors.judged_m) blocks += std::isfinite(m) ? 1 : 0;
    if (blocks < kMinJudgedBlocks) return fit;
    std::vector<const JudgedChange*> left;
    for (const JudgedChange& judged : judged_) {
      if (&judged != &*best && !is_within_margin(judged, *best)) continue;
      const JudgedChange* const simple = simplest(&judged);
      if (std::ranges::find(left, simple) == left.end()) left.push_back(simple);
    }
    const auto count_of = [](const JudgedChange* judged) { return explanations(judged->causes); };
    const int fewest = count_of(*std::ranges::min_element(left, {}, count_of));
    std::erase_if(left, [&](const JudgedChange* judged) { return count_of(judged) > fewest; });
    std::ranges::sort(left, {}, [](const JudgedChange* judged) { return judged->mean_m; });
    const JudgedChange& chosen = *left.front();
    std::erase_if(left,
                  [&](const JudgedChange* judged) { return !chosen.is_noticed || !judged->is_noticed; });
    // explanations of another kind that this one is not clearly better than
    for (const JudgedChange& other : judged_)
      if (chosen.is_noticed && other.is_noticed && other.causes != 0 && other.causes != chosen.causes &&
          count_of(&other) <= fewest && earns(judged_.front(), other) && !earns(other, chosen) &&
          simplest(&other) == &other)
        left.push_back(&other);
    for (const JudgedChange* judged : left)
      if (std::ranges::none_of(fit.changes,
                               [&](const StreamChange& c) { return is_same(c, judged->change); }))
        fit.changes.push_back(judged->change);
    without_small_scales(fit.changes);
    for (StreamChange& change : fit.changes) change = at_known_rate(change);
    const ChangeErrors errors =
        errors_of_change(pair_, blocks_, fit.changes.empty() ? no_change(options_) : fit.changes.front());
    fit.before_m = mean_of_known(judged_.front().errors.plain_m);
    fit.after_m = mean_of_known(errors.plain_m);
    fit.of_point_m = errors.of_point_m;
    fit.of_block_m = errors.plain_m;
    if (mean_of_known(errors.judged_m) > kUnexplained_m)
      fit.status = StreamFitStatus::unexplained;
    else if (fit.changes.empty())
      fit.status = StreamFitStatus::sound;
    else
      fit.status = fit.changes.size() > 1 ? StreamFitStatus::one_of : StreamFitStatus::found;
    return fit;
  }

 private:
  struct Difference {
    double mean_m = 0.0, sigma_m = 0.0, of_one_m = 0.0, of_other_m = 0.0;
    std::size_t blocks = 0;
  };
  // Error of one less that of the other, on blocks that at least one of both answers.
  static Difference difference(const JudgedChange& one, const JudgedChange& other,
                               std::size_t first_block = 0, std::size_t end_block = SIZE_MAX) {
    Difference d;
    double squares = 0.0;
    for (std::size_t b = first_block; b < std::min(end_block, one.errors.judged_m.size()); ++b) {
      const double a = one.errors.judged_m[b], c = other.errors.judged_m[b];
      if (!std::isfinite(a + c) || one.errors.pairs[b] + other.errors.pairs[b] == 0.0) continue;
      ++d.blocks;
      d.of_one_m += a;
      d.of_other_m += c;
      squares += (a - c) * (a - c);
    }
    if (d.blocks < 2) return d;
    const auto n = static_cast<double>(d.blocks);
    d.of_one_m /= n;
    d.of_other_m /= n;
    d.mean_m = d.of_one_m - d.of_other_m;
    d.sigma_m = std::sqrt(std::max(0.0, squares / n - d.mean_m * d.mean_m) / (n - 1.0));
    return d;
  }

  // The blocks in which numbers have another size, where that is the difference; else all.
  std::pair<std::size_t, std::size_t> touched(const JudgedChange& one, const JudgedChange& other) const {
    const unsigned sizes = other.causes & ~one.causes & (kLaterSizeCause | kSizeCause);
    if (sizes != kLaterSizeCause) return {0, SIZE_MAX};
    const SizeChange& size = other.change.sizes.back();
    const double since_s = *size.at_s - pair_.subject.first_s;
    const double at_s = pair_.subject.first_s + other.change.start_s + other.change.stretch * since_s;
    const double block = std::clamp((at_s - pair_.reference.first_s) / blocks_.length_s, 0.0,
                                    static_cast<double>(blocks_.count));
    if (size.until) return {0, static_cast<std::size_t>(std::ceil(block))};
    return {static_cast<std::size_t>(block), SIZE_MAX};
  }

  // Whether what `complex` has beyond `simple` is worth it.
  bool earns(const JudgedChange& simple, const JudgedChange& complex) const {
    const auto [first, end] = touched(simple, complex);
    const Difference d = difference(simple, complex, first, end);
    return d.blocks >= kMinJudgedBlocks && d.of_other_m < kEarnedShare * d.of_one_m &&
           d.mean_m > kMinGain_m && d.mean_m > student_quantile(d.blocks - 1, options_.alpha) * d.sigma_m;
  }
  static bool is_within_margin(const JudgedChange& judged, const JudgedChange& best) {
    const Difference d = difference(judged, best);
    return d.blocks >= 2 && d.mean_m <= student_quantile(d.blocks - 1, kMarginAlpha) * d.sigma_m;
  }
  static bool is_simpler(const JudgedChange& simple, const JudgedChange& complex) {
    return (simple.causes & ~complex.causes) == 0 && simple.parameters < complex.parameters;
  }

  // Takes away what is not earned.
  const JudgedChange* simplest(const JudgedChange* judged) const {
    while (true) {
      const JudgedChange* better = nullptr;
      for (const JudgedChange& simple : judged_) {
        if (!is_simpler(simple, *judged) || earns(simple, *judged)) continue;
        if (simple.causes != 0 && !earns(judged_.front(), simple)) continue;
        if (!better || simple.mean_m < better->mean_m) better = &simple;
      }
      if (!better) return judged;
      judged = better;
    }
  }

  // Explanations that count as one: a shift and a turn are one frame.
  static int explanations(unsigned causes) {
    if ((causes & (kTurnCause | kMirrorCause | kRootCause)) != 0) causes &= ~kShiftCause;
    if ((causes & (kMirrorCause | kRootCause)) != 0) causes &= ~kTurnCause;
    return std::popcount(causes);
  }

  static bool is_same(const StreamChange& a, const StreamChange& b) {
    constexpr double kSameStart_s = 0.1;
    return causes_of(a) == causes_of(b) && a.order == b.order &&
           std::abs(a.start_s - b.start_s) < kSameStart_s && std::abs(a.stretch - b.stretch) < 0.01 &&
           a.sizes.size() == b.sizes.size();
  }

  // Change at the ratio of two frame rates, where one is near and fits as well; whole rates first.
  StreamChange at_known_rate(const StreamChange& change) const {
    if (!change.has_stretch) return change;
    constexpr double kNearRate = 0.004, kAsWell = 1.05;
    constexpr std::array kWithStart{0.5, 0.25, 0.75, 0.0}, kWithoutStart{0.0, 0.5, 0.25, 0.75};
    const auto is_whole = [](double rate_hz) { return rate_hz == std::round(rate_hz); };
    std::vector<std::pair<int, double>> near;  // rates that are not whole, and the ratio
    for (const double stated : kFrameRates_hz)
      for (const double true_hz : kFrameRates_hz)
        if (stated != true_hz && std::abs(stated / true_hz / change.stretch - 1.0) < kNearRate)
          near.emplace_back((is_whole(stated) ? 0 : 1) + (is_whole(true_hz) ? 0 : 1), stated / true_hz);
    std::ranges::sort(near);
    const auto left_m = [&](const StreamChange& of) {
      return mean_of_known(errors_of_change(pair_, blocks_, of).judged_m);
    };
    // A lag too small to be named as a start is in the fitted rate; the other rate holds in the middle of
    // what both have in common, wherever that is.
    for (const auto& [rank, stretch] : near)
      for (const double middle : change.has_start ? kWithStart : kWithoutStart) {
        StreamChange rounded = change;
        rounded.start_s += middle * (change.stretch - stretch) * pair_.subject.duration_s();
        rounded.stretch = stretch;
        rounded = fitted(pair_, blocks_, rounded);
        if (left_m(rounded) <= kAsWell * left_m(change)) return rounded;
      }
    return change;
  }

  // Takes away scales that sound systems have, too; clears the list where nothing is left of a change.
  // `min_scale` is above what sound systems differ by: up to 9.3 %.
  void without_small_scales(std::vector<StreamChange>& changes) const {
    for (StreamChange& change : changes) {
      std::erase_if(change.sizes, [this](const SizeChange& size) {
        return !size.is_unit && !size.point && !size.at_s &&
               std::abs(std::log(size.factor)) < std::log1p(options_.min_scale);
      });
      change = fitted(pair_, blocks_, change);
    }
    if (std::ranges::any_of(changes,
                            [&](const StreamChange& change) { return named_causes(change, options_) == 0; }))
      changes.clear();
  }

  const StreamPair& pair_;
  TimeBlocks blocks_;
  StreamFitOptions options_;
  std::vector<JudgedChange> judged_;  // no change comes first
};

}  // namespace

StreamChange no_change(const StreamFitOptions& options) {
  return {.frame = options.any_frame ? FrameChange::turned : FrameChange::none};
}

unsigned named_causes(const StreamChange& change, const StreamFitOptions& options) {
  return causes_of(change) & ~(options.any_frame ? unsigned{kShiftCause | kTurnCause} : 0U);
}

StreamFit fit_streams(const StreamPair& pair, const std::vector<std::size_t>& mirrored,
                      const StreamFitOptions& options) {
  StreamFit fit;
  const PointStream &reference = pair.reference, &subject = pair.subject;
  if (reference.instants() < 2 || subject.instants() < 2) return fit;
  fit.overlap_s = std::max(
      0.0, std::min(reference.first_s + reference.duration_s(), subject.first_s + subject.duration_s()) -
               std::max(reference.first_s, subject.first_s));
  if (const auto axis = flat_axis(pair)) {
    fit.status = StreamFitStatus::flat;
    fit.flat_axis = *axis;
    return fit;
  }
  const TimeBlocks blocks = blocks_of(pair);
  const ChangeErrors unchanged = errors_of_change(pair, blocks, no_change(options));
  if (mean_of_known(unchanged.judged_m) < kMinGain_m) {  // no change can earn its place
    fit.status = StreamFitStatus::sound;
    fit.before_m = fit.after_m = mean_of_known(unchanged.plain_m);
    fit.of_point_m = unchanged.of_point_m;
    fit.of_block_m = unchanged.plain_m;
    return fit;
  }
  return ChangeChoice(pair, blocks, options, search_changes(pair, blocks, mirrored, options)).choose(fit);
}

}  // namespace trilat
