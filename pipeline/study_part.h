// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/results/work_part.h"
#include "pipeline/execute.h"
#include "pipeline/items/shard.h"
#include "pipeline/plan.h"

namespace trilat {

// Whose each take of the plan is, as items of a part: the cost of a take is its instants.
std::vector<PartItem> part_items(const Plan& plan, std::uint64_t shards);

struct StudyPart {
  std::size_t takes = 0, failed = 0;  // of this shard
  std::size_t of = 0;                 // all takes of the study
  ItemTally tally;
  std::vector<TakeNote> notes;  // why takes failed, those of other shards that cannot be read too
};

// Computes one shard of a study into a part folder: part.json, items.json, takes/ID with
// samples.h5 and summary.bin, and, beside them, what the results take over as it is. Written aside, put in
// place and gone on with like results.
StudyPart run_study_part(const StudySpec& study, const Campaign& campaign, const Shard& shard,
                         const std::filesystem::path& output, const ExecuteOptions& options);

// The results that one run would have given, to the byte, but for run.json and hashes.json. Needs the
// parts only, not the campaign.
ResultsSummary merge_study(const std::vector<FoundPart>& parts, const std::filesystem::path& output,
                           const ExecuteOptions& options);

}  // namespace trilat
