// SPDX-License-Identifier: MIT
// `trilat run`.
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/items/shard.h"
#include "pipeline/study_spec.h"

namespace trilat {

int run(const RunArguments& arguments) {
  const Json json = read_json(arguments.study);
  if (!arguments.shard.empty()) parse_shard(arguments.shard, "--shard");
  const StudyKind kind = study_kind(json, arguments.study.string());
  if (arguments.memory_mb && kind != StudyKind::accuracy && kind != StudyKind::error_budget)
    throw InputError("--memory-mb", "is for studies of kind accuracy and error_budget; others need little");
  switch (kind) {
    case StudyKind::threshold_sweep:
      return run_sweep_study(arguments, json);
    case StudyKind::calibration:
      return run_calibration_study(arguments, json);
    case StudyKind::error_budget:
      return run_budget_study(arguments, json);
    case StudyKind::recording:
      return run_recording_study(arguments, json);
    case StudyKind::accuracy:
      break;
  }
  return run_accuracy_study(arguments, json);
}

}  // namespace trilat
