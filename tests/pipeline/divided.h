// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <fmt/format.h>

#include "pipeline/accuracy/accuracy_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/scratch.h"

namespace trilat {

inline constexpr const char* kDividedMethods = R"("occluded_apart": true, "resamples": 200, "block_s": 0.2,
    "alignments": ["mean", "none", "rigid", "first", "held_out", "joint_offset"], "methods": [
    {"method": "mean"}, {"method": "nonlinear"}, {"method": "geometric"}, {"method": "rts"}])";

// What a run of all takes, or of a shard of them, came to.
struct AccuracyRun {
  ResultsSummary summary;  // of all takes
  ItemTally tally;
};

inline AccuracyRun run(const StudySpec& study, const Campaign& campaign, const std::filesystem::path& output,
                       const ExecuteOptions& options = {}) {
  AccuracyRun run{{}, run_accuracy(study, campaign, output, options)};
  if (options.shard.whole()) run.summary = read_summary(output);
  return run;
}

inline std::string item_of(const Take& take) { return "takes/" + take.id; }

// Takes of two activities; one cannot be evaluated.
struct Divided {
  ScratchFolder folder;
  Campaign campaign;
  StudySpec study = study_of(kDividedMethods);

  explicit Divided(std::uint64_t participants = 4, bool one_fails = true) {
    SimulationSpec spec = walking_spec(participants);
    spec.activities.push_back(spec.activities[0]);
    spec.activities[1].activity = Activity::arm_swing;
    spec.activities[1].duration_s = 0.7;
    campaign = simulate_into(folder / "campaign", spec);
    if (one_fails) campaign.takes[1].mocap = folder / "campaign/absent.csv";
  }
  std::filesystem::path whole(ExecuteOptions options = {}) {
    execute_study(study, campaign, folder / "whole", options);
    return folder / "whole";
  }
  ItemTally part(const Shard& shard, const std::filesystem::path& output, ExecuteOptions options = {}) const {
    options.shard = shard;
    return run_accuracy(study, campaign, output, options);
  }
  std::vector<std::filesystem::path> parts(std::uint64_t of, ExecuteOptions options = {}) {
    std::vector<std::filesystem::path> names;
    for (std::uint64_t k = 1; k <= of; ++k) {
      names.push_back(folder / fmt::format("part{}of{}", k, of));
      part({k, of}, names.back(), options);
    }
    return names;
  }
  std::filesystem::path merged(const std::vector<std::filesystem::path>& parts) {
    const std::filesystem::path output = folder / fmt::format("merged{}", parts.size());
    const std::vector<FoundPart> found = read_parts(parts);
    merge_parts(accuracy_of_parts(found[0].part.work, (parts[0] / "part.json").string()), found, output, {});
    return output;
  }
};

}  // namespace trilat
