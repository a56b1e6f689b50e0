// SPDX-License-Identifier: MIT
// `trilat run`.
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/study_spec.h"

namespace trilat {

int run(const RunArguments& arguments) {
  const Json json = read_json(arguments.study);
  switch (study_kind(json, arguments.study.string())) {
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
