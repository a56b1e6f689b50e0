// SPDX-License-Identifier: MIT
// `trilat merge`.
#include "datasets/base/build_id.h"
#include "datasets/base/error.h"
#include "datasets/results/results_file.h"
#include "datasets/results/work_part.h"
#include "pipeline/calibration/wand_part.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/generated_studies.h"
#include "pipeline/cli/merge_kinds.h"
#include "pipeline/cli/simulate_part.h"
#include "pipeline/cli/verbs.h"

namespace trilat {

namespace {

OutputKind merged_output(const std::string& part_kind) {
  if (part_kind == kWandPart) return OutputKind::calibration;
  return part_kind == kCampaignPart ? OutputKind::merged_campaign : OutputKind::results;
}

}  // namespace

int merge(const MergeArguments& arguments) {
  const std::vector<FoundPart> parts = read_parts(arguments.parts);
  const FoundPart& first = parts.front();
  if (first.part.build != build_id())
    throw InputError(first.folder.string(), "was made by another build of the program; merge with that one");
  if (arguments.memory_mb && first.part.kind != name_of(StudyKind::accuracy))
    throw InputError("--memory-mb", "is for parts of kind accuracy; others need little");
  check_output({arguments.output, merged_output(first.part.kind), arguments.parts, arguments.force});
  if (first.part.kind == kWandPart) return merge_wand_calibration(arguments, parts);
  if (first.part.kind == kCampaignPart) return merge_simulated_campaign(arguments, parts);
  if (first.part.kind == name_of(StudyKind::accuracy)) return merge_accuracy(arguments, parts);
  if (first.part.kind == name_of(StudyKind::threshold_sweep)) return merge_threshold_sweep(arguments, parts);
  if (const GeneratedKind* kind = generated_kind(first.part.kind))
    return merge_generated(*kind, arguments, parts);
  throw InputError(first.folder.string(),
                   "is a part of kind " + first.part.kind + ", which cannot be merged");
}

}  // namespace trilat
