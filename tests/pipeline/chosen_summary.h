// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "datasets/results/summary.h"

namespace trilat {

// A simulated study of three participants, whose reference is the first method; it has no number yet.
inline ResultsSummary summary_of(std::vector<std::string> methods, std::vector<std::string> groups) {
  ResultsSummary s;
  s.study = "table3";
  s.campaign = "lab";
  s.simulated = true;
  s.takes = 4;
  s.takes_failed = 1;
  s.participants = 3;
  s.methods = std::move(methods);
  s.reference = s.methods.front();
  s.conditions = {"walking"};
  s.groups = std::move(groups);
  s.alignments = {"mean"};
  s.clusters = {{"walking", "participants"}};
  for (const std::string& method : s.methods) s.legend.push_back({method, "what " + method + " does"});
  return s;
}

// An error in centimetres, known to a tenth of it, of a hundred samples of which so many are answered.
inline void add_error(ResultsSummary& s, const std::string& method, const std::string& group, double cm,
                      std::uint64_t answered = 100, const std::string& condition = "walking") {
  const NumberKey key{
      .condition = condition, .group = group, .method = method, .alignment = s.alignments.front()};
  const double m = 0.01 * cm;
  s.numbers.add({key.with({.measure = "answered", .statistic = "share"}),
                 0.01 * static_cast<double>(answered), kNaN, kNaN, 100});
  if (answered > 0)
    s.numbers.add({key.with({.measure = "distance", .statistic = "mean"}), m, 0.9 * m, 1.1 * m, answered, 3});
}

// A difference from the reference in centimetres with its interval, and a tenth of it as a share of its
// error.
inline void add_difference(ResultsSummary& s, const std::string& method, const std::string& group, double cm,
                           double low_cm, double high_cm) {
  const NumberKey key{.condition = "walking",
                      .group = group,
                      .method = method,
                      .against = s.reference,
                      .alignment = s.alignments.front(),
                      .measure = "distance"};
  s.numbers.add({key.with({.statistic = "difference"}), 0.01 * cm, 0.01 * low_cm, 0.01 * high_cm, 90, 3});
  s.numbers.add(
      {key.with({.statistic = "relative_difference"}), 0.1 * cm, 0.1 * low_cm, 0.1 * high_cm, 90, 3});
}

// Sentences, one a line.
inline std::string all_text(const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes) text += note + "\n";
  return text;
}

}  // namespace trilat
