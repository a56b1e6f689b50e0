// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/shown/accuracy_words.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"
#include "datasets/results/stored_take.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"

namespace trilat {

std::string about(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  return fmt::format("{}, {}{}; {}{}{} of {}, {}", s.campaign, condition.empty() ? "" : condition + ", ",
                     s.simulated ? "simulated sensors" : "recorded sensors",
                     s.left_out() ? "against the sensor left out; " : "",
                     alignment.empty() ? "" : "alignment: " + alignment + "; ", s.takes - s.takes_failed,
                     counted(s.takes, "take"), counted(s.participants, "participant"));
}

std::string truth_note(const ResultsSummary& s) {
  if (!s.left_out()) return {};
  return "There is no ground truth. Each sensor in turn is left out, and its tracked joints are held against "
         "what the others say. What all sensors have in common, such as a bias of the body model, cannot be "
         "seen. The sensor's own error is in every number: compare methods by these numbers, and do not "
         "quote them as their error. A method has one sensor fewer here than the rig.";
}

std::string interval_note(const ResultsSummary& s) {
  const std::string beside = "Each number is followed by its 95 % interval: Student's t between ";
  if (s.participants >= 3) return beside + "participants.";
  return beside +
         "takes or, of a single take, between its blocks of five seconds. It says how well these takes were "
         "measured, and nothing of other people.";
}

namespace {

// Each method with its share, and the most frequent status of what it does not answer.
void add_coverage_note(const ResultsSummary& s, const std::string& condition, const std::string& alignment,
                       Table& table) {
  std::string methods;
  const std::vector<std::string> groups = groups_in(s, condition);
  if (groups.empty()) return;
  for (const std::string& method : s.methods) {
    const Number* coverage = find_coverage(s, method, condition, groups.back(), alignment);
    if (!coverage || !(coverage->value < kMinCoverage)) continue;
    std::string reason;
    double share = 0.0;
    for (int k = 0; k < kSolveStatusCount; ++k) {
      const std::string status(name_of(static_cast<SolveStatus>(k)));
      const Number* ended = s.numbers.find(coverage->with({.measure = "status", .statistic = status}));
      if (!ended || is_answer(status) || ended->value <= share) continue;
      reason = status;
      share = ended->value;
    }
    if (reason.empty()) continue;
    methods += fmt::format("{}{} {:.0f} % ({} {:.0f} %)", methods.empty() ? "" : ", ", method,
                           100.0 * coverage->value, reason, 100.0 * share);
  }
  if (!methods.empty())
    table.notes.push_back(
        "Answered less than 80 %, so that errors by themselves flatter these methods: " + methods +
        ". Compare them by the differences, which are of samples that both answer.");
}

}  // namespace

void add_error_notes(const ResultsSummary& s, const std::string& condition, const std::string& alignment,
                     const std::string& key, Table& table) {
  if (s.left_out()) table.notes.push_back(truth_note(s));
  add_notes(table, key);
  table.notes.push_back(interval_note(s));
  add_coverage_note(s, condition, alignment, table);
  add_take_notes(s, table);
}

namespace {

// A text of a check may be a question.
std::string sentence_of(const TakeNote& note) {
  const std::string text = note.place + ": " + note.text;
  return text.ends_with('?') || text.ends_with('.') ? text : text + ".";
}

}  // namespace

void add_take_notes(const ResultsSummary& summary, Table& table) {
  for (const TakeNote& note : summary.notes)
    table.notes.push_back(
        (note.take.empty() ? "" : fmt::format("Take {}{}: ", note.take, note.failed ? " failed" : "")) +
        sentence_of(note));
}

std::string error_text(const Number& error) {
  std::string text = fmt::format("{:.1f} cm", error.value * kCentimetresPerMetre);
  if (!std::isnan(error.low))
    text += fmt::format(" ({:.1f} to {:.1f})", error.low * kCentimetresPerMetre,
                        error.high * kCentimetresPerMetre);
  return text;
}

std::string body_alignment(const ResultsSummary& s) {
  return std::ranges::find(s.alignments, "none") != s.alignments.end() ? "none" : s.alignments.front();
}

std::string difference_text(const ResultsSummary& s, const std::string& condition,
                            const std::string& alignment, const std::string& method) {
  const std::string group = average_group(s);
  const Number *d = find_difference(s, method, condition, group, alignment),
               *share = find_difference(s, method, condition, group, alignment, "relative_difference");
  if (!d || !share || std::isnan(share->low)) return {};
  if (!is_significant(*d)) return fmt::format("not to be distinguished from `{}`", s.reference);
  return fmt::format("{:.0f} % ({:.0f} to {:.0f}) {} than `{}`", 100.0 * std::abs(share->value),
                     100.0 * std::min(std::abs(share->low), std::abs(share->high)),
                     100.0 * std::max(std::abs(share->low), std::abs(share->high)),
                     share->value < 0.0 ? "less" : "more", s.reference);
}

std::vector<std::string> method_legend(const ResultsSummary& s) {
  std::vector<std::string> methods, lines;
  for (const std::string& condition : s.conditions)
    for (const std::string& method : leading_methods(s, condition))
      if (std::ranges::find(methods, method) == methods.end()) methods.push_back(method);
  for (const std::string& method : methods)
    if (const auto note = std::ranges::find(s.legend, method, &MethodNote::method); note != s.legend.end())
      lines.push_back(fmt::format("`{}`: {}", row_name(s, method), note->what));
  return lines;
}

namespace {

// " From files: …": each external method with its error and its rank.
std::string external_text(const ResultsSummary& s, const std::string& condition, const std::string& best) {
  const std::vector<std::string> ranked = by_error(s, condition, s.methods);
  std::string text;
  for (const MethodNote& note : s.legend) {
    const Number* error = find_error(s, note.method, condition, average_group(s), s.alignments.front());
    if (!note.is_external || note.method == best || !error) continue;
    const auto rank = std::ranges::find(ranked, note.method) - ranked.begin() + 1;
    text += fmt::format("{}`{}` {}, {} of {}", text.empty() ? " From files: " : "; ", note.method,
                        error_text(*error), rank, ranked.size());
  }
  return text.empty() ? text : text + ".";
}

// "; 2 others cannot be distinguished from it (…)": the methods that may be as good as the best one, the
// nearest first.
std::string alike_text(const ResultsSummary& s, const std::vector<std::string>& alike) {
  constexpr std::size_t kMaxNamed = 4;
  constexpr std::uint64_t kFewParticipants = 5;
  if (alike.empty()) return {};
  const std::vector<std::string> named(alike.begin(), alike.begin() + std::min(alike.size(), kMaxNamed));
  const std::string names =
      fmt::format("{}`{}`", alike.size() > kMaxNamed ? "among them " : "", fmt::join(named, "`, `"));
  if (s.participants < kFewParticipants)
    return fmt::format("; {} {} too few to rule out {}, the nearest first ({})",
                       counted(s.participants, "participant"), s.participants == 1 ? "is" : "are",
                       counted(alike.size(), "other"), names);
  return fmt::format("; {} cannot be distinguished from it ({})", counted(alike.size(), "other"), names);
}

}  // namespace

// For each condition: the method that errs least on average over the joint groups, how many cannot be
// distinguished from it, and its difference from the reference.
std::vector<std::string> accuracy_findings(const ResultsSummary& s) {
  std::vector<std::string> findings;
  for (const std::string& condition : s.conditions) {
    const BestMethod* best = find_best(s, condition, average_group(s));
    const std::vector<std::string> groups = groups_in(s, condition);
    const bool is_answered = std::ranges::any_of(s.methods, [&](const std::string& method) {
      return !groups.empty() && coverage_of(s, method, condition, groups.back(), s.alignments.front()) > 0.0;
    });
    if (!best && s.methods.size() > 1 && is_answered)
      findings.push_back(fmt::format("**{}**, {}: too short for an interval, so no method is called best.",
                                     condition, s.simulated ? "simulated" : "recorded"));
    const std::string& alignment = s.alignments.front();
    const Number* error =
        best ? find_error(s, best->method, condition, average_group(s), alignment) : nullptr;
    if (!error) continue;
    std::string text = fmt::format("**{}**, {}: `{}` has the smallest {} of {} methods, {}", condition,
                                   s.simulated ? "simulated" : "recorded", best->method,
                                   s.left_out() ? "difference from the sensor left out" : "error",
                                   s.methods.size(), error_text(*error));
    if (s.methods.size() == 1)
      text = fmt::format("**{}**, {}: `{}` has a mean {} of {}", condition,
                         s.simulated ? "simulated" : "recorded", best->method,
                         s.left_out() ? "difference from the sensor left out" : "error", error_text(*error));
    if (const double coverage = coverage_of(s, best->method, condition, average_group(s), alignment);
        coverage < kWhole)
      text += fmt::format(" on the {:.1f} % that it answers", 100.0 * coverage);
    if (const std::string against = difference_text(s, condition, alignment, best->method);
        !against.empty() &&
        std::ranges::find(best->not_distinguished, s.reference) == best->not_distinguished.end())
      text += ", " + against;
    text += alike_text(s, best->not_distinguished);
    findings.push_back(text + "." + external_text(s, condition, best->method));
  }
  return findings;
}

// The warnings that a reader needs before believing a number: what Ceres contradicts, failed takes, notes of
// the checks, silent methods.
std::vector<std::string> accuracy_warnings(const ResultsSummary& s, bool with_notes) {
  std::vector<std::string> warnings;
  for (const CrossCheck& check : s.cross_checks)
    if (!check.passed())
      warnings.push_back(
          check.samples == 0
              ? fmt::format("`{}` was not compared with Ceres: no sample has an answer of both.",
                            check.method)
              : fmt::format("`{}` disagrees with Ceres by up to {:.3g} m.", check.method, check.worst_m));
  const auto notes = std::ranges::count(s.notes, false, &TakeNote::failed);
  for (const TakeNote& note : s.notes)
    if (note.failed && with_notes)
      warnings.push_back(fmt::format("Take {} failed: {}", note.take, sentence_of(note)));
  const auto noted = std::ranges::find(s.notes, false, &TakeNote::failed);
  if (notes > 0 && with_notes)
    warnings.push_back(fmt::format("The checks noted {}, {}: take {}: {}",
                                   counted(static_cast<std::size_t>(notes), "thing"),
                                   notes == 1 ? "namely" : "the first", noted->take, sentence_of(*noted)));
  if (s.participants < 6)
    warnings.push_back(fmt::format("Only {}: {}.", counted(s.participants, "participant"),
                                   s.participants < 3
                                       ? "intervals are between takes, or between five seconds of a single "
                                         "take, and say nothing of other people"
                                       : "intervals are wide, and hold for people like these alone"));
  for (const std::string& condition : s.conditions)
    for (const std::string& method : leading_methods(s, condition)) {
      const std::string where = condition.empty() ? "" : " in " + condition;
      const double coverage = coverage_of(s, method, condition, average_group(s), s.alignments.front());
      if (coverage < kMinCoverage)
        warnings.push_back(coverage == 0.0
                               ? fmt::format("`{}` answers nothing{}.", method, where)
                               : fmt::format("`{}` answers only {:.0f} %{}: its error is of these alone.",
                                             method, 100.0 * coverage, where));
    }
  return warnings;
}

}  // namespace trilat
