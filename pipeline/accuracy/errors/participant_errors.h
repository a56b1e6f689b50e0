// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/summary.h"
#include "evaluators/metrics/cluster_ratios.h"

namespace trilat {

// Which samples a comparison of two methods is over.
enum class ComparedSamples { both, complete };

// The errors of an accuracy study by participant, for comparisons that its tables do not hold: between
// joints, conditions and families of methods. A name that is looked for is that of a method, of a family (the
// mean over its methods), or "best of FAMILY": for each participant the method of it that does best on all
// the others, so that nobody is judged by whom they helped to choose.
class ParticipantErrors {
 public:
  // `summary` must outlive it.
  explicit ParticipantErrors(const ResultsSummary& summary);

  const ResultsSummary& summary() const { return summary_; }
  // Of the condition, in the study's order.
  std::vector<std::string> groups_of(const std::string& condition) const;
  bool knows(const std::string& name) const { return !methods_of(name).empty(); }
  std::vector<std::string> methods_of(const std::string& name) const;

  // The mean error of a name over what it answers, or also over what the reference alone answers, with the
  // reference's error; empty sums where there are no such samples.
  WeightedRatio error_m(const std::string& name, const std::string& condition,
                        const std::string& group) const;
  WeightedRatio complete_error_m(const std::string& name, const std::string& condition,
                                 const std::string& group) const;

  // The method's mean error in the faster (or the slower) half of each joint's samples.
  WeightedRatio speed_error_m(const std::string& name, const std::string& condition, const std::string& group,
                              bool fast) const;

  // (of - against) / against, each the plain mean over the groups. Over the samples that `both` answer one of
  // the two has to be the study's reference; else the result is empty.
  Contrast difference(const std::string& of, const std::string& against, const std::string& condition,
                      const std::vector<std::string>& groups, ComparedSamples samples) const;

 private:
  // Sums over one participant's takes and joints.
  struct Sums {
    double answered = 0.0, error_m = 0.0, slow = 0.0, slow_m = 0.0, fast = 0.0, fast_m = 0.0;
    struct Paired {
      double n = 0.0, method_m = 0.0, reference_m = 0.0;
      void add(const PairedErrors& paired);
    } both, complete;
  };
  using ByParticipant = std::vector<Sums>;

  ByParticipant sums_of(const std::string& name, const std::string& condition,
                        const std::string& group) const;
  // By participant, which of the methods does best on the others; empty without others.
  std::vector<std::string> best_on_others(const std::vector<std::string>& methods,
                                          const std::string& condition) const;

  const ResultsSummary& summary_;
  std::vector<std::string> participants_;
  std::map<std::string, std::map<std::string, std::map<std::string, ByParticipant>>>
      sums_;  // condition, group, method
};

// What changed from one accuracy result to another, for the conditions, methods and groups of both and the
// average of the groups, under their first alignment: Student's t between participants, of the differences of
// each where both have the same. Nothing where alignment or truth differ: those are two measures.
std::optional<ErrorChanges> changes_between(const ResultsSummary& before, const ResultsSummary& after);

// The same of two results folders, on average over the groups. Nothing for other kinds, for more or fewer
// than two, or where alignment or truth differ: those are two measures.
std::optional<ErrorChanges> changes_between(const std::vector<std::filesystem::path>& results);

}  // namespace trilat
