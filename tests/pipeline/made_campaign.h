// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "datasets/results/paper_evidence.h"

namespace trilat {

// Errors of made participants, drawn so that every method, joint and condition has the same mean but for
// `factors`, which multiply those of all methods that are not the reference: no claim of a difference is
// true.
struct MadeCampaign {
  std::size_t participants = 16;
  double participant_spread = 0.2, method_spread = 0.1;  // of the logarithm, a row
  double factor = 1.0;
  double coverage = 1.0;

  PaperEvidence draw(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    PaperEvidence evidence;
    evidence.walking = study(
        random, {"walking"}, {"head", "shoulder", "elbow", "wrist"}, "nonlinear",
        {"nonlinear", "linear", "geometric", "mean", "single k1", "single k2", "geometric, each three a",
         "geometric, each three b", "nonlinear, each three a", "nonlinear, each three b"},
        {{"single", 1, {"single k1", "single k2"}},
         {"geometric, each three", 3, {"geometric, each three a", "geometric, each three b"}},
         {"nonlinear, each three", 3, {"nonlinear, each three a", "nonlinear, each three b"}}});
    evidence.occluded =
        study(random, {"arm_swing", "leg_crossing", "arm_swing, occluded", "leg_crossing, occluded"},
              {"elbow", "ankle"}, "nonlinear", {"nonlinear", "nonlinear, occlusion corrected"}, {});
    for (int rig = 0; rig < 2; ++rig)
      evidence.sensor_counts.push_back(
          study(random, {"walking"}, {"head", "wrist"}, "nonlinear, 8 sensors",
                {"nonlinear, 8 sensors", "nonlinear, 4 sensors a", "nonlinear, 4 sensors b"},
                {{"nonlinear, 4 sensors", 4, {"nonlinear, 4 sensors a", "nonlinear, 4 sensors b"}}}));
    return evidence;
  }

 private:
  ResultsSummary study(std::mt19937_64& random, const std::vector<std::string>& conditions,
                       const std::vector<std::string>& groups, const std::string& reference,
                       const std::vector<std::string>& methods,
                       const std::vector<MethodFamily>& families) const {
    std::normal_distribution<double> normal;
    ResultsSummary s;
    s.conditions = conditions;
    s.groups = groups;
    s.methods = methods;
    s.reference = reference;
    s.families = families;
    s.simulated = true;
    const double shift = 0.5 * (participant_spread * participant_spread + method_spread * method_spread);
    for (std::size_t p = 0; p < participants; ++p) {
      const double own = participant_spread * normal(random);
      for (const std::string& condition : conditions)
        for (const std::string& group : groups) {
          std::vector<double> error_m;
          for (const std::string& method : methods)
            error_m.push_back((method == reference ? 1.0 : factor) * 0.06 *
                              std::exp(own + method_spread * normal(random) - shift));
          for (std::size_t m = 0; m < methods.size(); ++m) {
            TakeJointRow row{"t", "p" + std::to_string(p), condition, group, group, methods[m], 100, 100};
            row.answered = static_cast<std::uint64_t>(100.0 * coverage);
            row.mae_m = error_m[m];
            row.both = {row.answered, error_m[m], error_m[0]};
            row.complete = {100, error_m[m], error_m[0]};
            s.by_take.push_back(row);
          }
        }
    }
    return s;
  }
};

}  // namespace trilat
