// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "pipeline/claims/error_measures.h"
#include "pipeline/claims/judge_claims.h"
#include "pipeline/errors/condition_errors.h"

namespace trilat {

// A study with made errors: of each participant one take of each activity, all methods under one alignment.
struct MadeStudy {
  static constexpr std::uint32_t kSamples = 100;  // of a joint
  ResultsSummary names;
  std::vector<std::string> joints;
  std::vector<TakeTable> takes;
  double abrupt = 1.0;  // errors of the half with the larger acceleration, in those of the other

  MadeStudy(const std::string& study, std::vector<std::string> joints_, std::vector<std::string> methods)
      : joints(std::move(joints_)) {
    names.study = study;
    names.paper = study.starts_with("sensors") ? "sensors" : study;
    names.simulated = true;
    names.methods = std::move(methods);
    names.alignments = {"mean"};
    names.groups = groups_of(joints);
  }

  // A mean error (m) by joint and method, for all samples and the subsets.
  using ErrorOf = std::function<double(std::uint32_t joint, std::uint32_t method, Subset subset)>;
  // The numbers of samples that a method answers; all where it is not given.
  using AnswersOf = std::function<std::uint32_t(std::uint32_t method)>;

  void add(
      const std::string& participant, const std::string& activity, const ErrorOf& error_m,
      const AnswersOf& answers = [](std::uint32_t) { return kSamples; }) {
    TakeTable& take = takes.emplace_back(TakeTable{participant + "-" + activity, participant, activity, {}});
    take.errors.alignments = names.alignments;
    take.errors.quantities = joints;
    for (std::uint32_t j = 0; j < joints.size(); ++j) {
      for (std::uint32_t m = 0; m < names.methods.size(); ++m)
        for (const Subset subset : {Subset::all, Subset::occluded})
          add_errors(take.errors, j, m, subset, answers(m), error_m(j, m, subset));
      for (std::uint32_t b = 0; b < names.methods.size(); ++b)
        for (std::uint32_t a = 0; a < b; ++a)
          for (const Subset subset : {Subset::all, Subset::occluded})
            add_pair(take.pairs, j, a, b, subset, std::min(answers(a), answers(b)), error_m);
      const double nonlinear_m = error_m(j, 0, Subset::all);  // the first method
      constexpr std::uint32_t kHalf = kSamples / 2;
      const double of_take = takes.size() % 2 == 0 ? 0.99 : 1.01;  // people differ
      take.movement.push_back({j, 0, kSamples, kHalf, kHalf, 0.5 * kSamples,
                               kHalf * nonlinear_m * abrupt * of_take, kHalf * nonlinear_m});
    }
    if (std::ranges::find(names.conditions, activity) == names.conditions.end())
      names.conditions.push_back(activity);
    std::vector<std::string> people;
    for (const TakeTable& other : takes)
      if (std::ranges::find(people, other.participant) == people.end()) people.push_back(other.participant);
    names.participants = people.size();
  }

  // The study's numbers, of which claims and errata need errors and answers.
  ResultsSummary summary() const {
    ResultsSummary made = names;
    const StudyErrors errors(takes, joints, names);
    made.numbers = claimed_numbers(errors);
    for (const std::string& condition : names.conditions) {
      const ConditionErrors in = errors.in(condition);
      made.clusters[condition] = made.clusters[occluded_condition(condition)] = in.clusters();
      for (const std::size_t g : in.groups())
        for (std::size_t m = 0; m < names.methods.size(); ++m) {
          const CellSums& cell = in.cell(g, m, 0);
          made.numbers.add({{.condition = condition,
                             .group = names.groups[g],
                             .method = names.methods[m],
                             .alignment = names.alignments.front(),
                             .measure = "answered",
                             .statistic = "share"},
                            static_cast<double>(cell.answered) / static_cast<double>(cell.asked),
                            kNaN,
                            kNaN,
                            cell.asked});
        }
    }
    return made;
  }
  std::vector<ClaimNumber> claims() const { return claim_numbers(summary()); }

 private:
  static void add_errors(TakeErrors& table, std::uint32_t j, std::uint32_t m, Subset subset, std::uint32_t n,
                         double error_m) {
    const auto of = static_cast<std::uint32_t>(subset);
    EndedRow ended{j, m, of, 1};
    ended.statuses = {n, kSamples - n};
    table.ended.push_back(ended);
    if (n == 0) return;
    ErrorSums sums{0, j, m, 0, of, static_cast<std::uint32_t>(Measure::distance), n};
    sums.sum = sums.sum_abs = n * error_m;
    sums.largest = error_m;
    table.sums.push_back(sums);
    sums.measure = static_cast<std::uint32_t>(Measure::y);
    sums.sum_abs = n * 0.5 * error_m;
    table.sums.push_back(sums);
    if (subset != Subset::all || n == 0) return;
    table.histograms.push_back({j, m, 0, 0, 1});
    table.bins.push_back({static_cast<std::uint32_t>(error_m / kBin_m), n});
  }
  static void add_pair(PairErrors& pairs, std::uint32_t j, std::uint32_t a, std::uint32_t b, Subset subset,
                       std::uint32_t n, const ErrorOf& error_m) {
    std::vector<PairRow>& rows = pairs[{a, b}];
    if (n > 0)
      rows.push_back({0, j, 0, static_cast<std::uint32_t>(subset), n, n * error_m(j, a, subset),
                      n * error_m(j, b, subset)});
  }
};

// Studies of made participants, in which every method, joint and condition has the same mean error but for
// `factor`, which multiplies those of all methods that are not the first: at 1 no claim of a difference is
// true.
struct MadeCampaign {
  std::size_t participants = 16;
  double participant_spread = 0.2, method_spread = 0.1;  // of the logarithm
  double factor = 1.0;

  // The numbers that the studies store for the paper's claims.
  std::vector<ClaimNumber> draw(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::vector<ClaimNumber> numbers;
    const auto add = [&](MadeStudy study, const std::vector<std::string>& activities) {
      fill(study, activities, random);
      for (ClaimNumber& number : study.claims()) numbers.push_back(std::move(number));
    };
    MadeStudy table3("table3", {"head", "shoulder_left", "elbow_left", "wrist_right"},
                     {"nonlinear", "linear", "geometric", "mean", "single k1", "single k2", "geometric a",
                      "geometric b", "nonlinear a", "nonlinear b"});
    table3.names.families = {{"single", 1, {"single k1", "single k2"}},
                             {"geometric, each three", 3, {"geometric a", "geometric b"}},
                             {"nonlinear, each three", 3, {"nonlinear a", "nonlinear b"}}};
    add(std::move(table3), {"walking"});
    add(MadeStudy("table2",
                  {"shoulder_left", "elbow_left", "wrist_left", "hip_left", "knee_left", "ankle_left"},
                  {"nonlinear", "nonlinear, occlusion corrected"}),
        {"arm_swing", "leg_crossing"});
    for (const char* rig : {"sensors_different_heights", "sensors_equal_heights"}) {
      MadeStudy sensors(rig, {"head", "shoulder_left", "elbow_left", "wrist_left"},
                        {"nonlinear, 8 sensors", "nonlinear, 4 sensors a", "nonlinear, 4 sensors b"});
      sensors.names.families = {
          {"nonlinear, 4 sensors", 4, {"nonlinear, 4 sensors a", "nonlinear, 4 sensors b"}}};
      add(std::move(sensors), {"walking"});
    }
    return numbers;
  }

 private:
  void fill(MadeStudy& study, const std::vector<std::string>& activities, std::mt19937_64& random) const {
    std::normal_distribution<double> normal;
    const double shift = 0.5 * (participant_spread * participant_spread + method_spread * method_spread);
    for (std::size_t p = 0; p < participants; ++p) {
      const double own = participant_spread * normal(random);
      for (const std::string& activity : activities) {
        std::vector<double> drawn_m(study.joints.size() * study.names.methods.size() * kSubsetNames.size());
        for (std::size_t k = 0; k < drawn_m.size(); ++k) {
          const bool is_first = k / kSubsetNames.size() % study.names.methods.size() == 0;
          drawn_m[k] =
              (is_first ? 1.0 : factor) * 0.06 * std::exp(own + method_spread * normal(random) - shift);
        }
        study.add("p" + std::to_string(p), activity, [&](std::uint32_t j, std::uint32_t m, Subset subset) {
          return drawn_m[(j * study.names.methods.size() + m) * kSubsetNames.size() +
                         static_cast<std::size_t>(subset)];
        });
      }
    }
  }
};

}  // namespace trilat
