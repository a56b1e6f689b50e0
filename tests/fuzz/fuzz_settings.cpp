// SPDX-License-Identifier: MIT
// What a person writes or a campaign brings: the first byte chooses the reader, JSON follows.
#include <array>
#include <string_view>

#include <nlohmann/json.hpp>

#include "datasets/calibration/calibration.h"
#include "datasets/results/results_file.h"
#include "datasets/synthetic/simulation_spec.h"
#include "datasets/take/campaign.h"
#include "pipeline/accuracy/methods/study_spec.h"
#include "pipeline/budget/budget_study.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/sensitivity/sensitivity_study.h"
#include "pipeline/sweep/sweep_plan.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/tolerate_bad_input.h"

namespace trilat {
namespace {

constexpr const char* kPlace = "fuzz.json";

void read_study_of_any_kind(const Json& json) {
  switch (study_kind(json, kPlace)) {
    case StudyKind::accuracy:
      resolved_json(parse_study(json, kPlace, {}));
      return;
    case StudyKind::threshold_sweep: {
      const SweepPlan plan = make_sweep_plan(parse_sweep(json, kPlace), kPlace);
      for (std::size_t cell = 0; cell < std::min<std::size_t>(plan.cells(), 64); ++cell)
        options_of(plan, place_of(plan, cell));
      return;
    }
    case StudyKind::calibration:
      resolved_json(parse_calibration_spec(json, kPlace));
      return;
    case StudyKind::error_budget:
      resolved_json(parse_budget(json, kPlace, {}, {}).study);
      return;
    case StudyKind::recording:
      recording_parameters(parse_recording_spec(json, kPlace));
      return;
    case StudyKind::sensitivity:
      resolved_json(parse_sensitivity(json, kPlace, {}, Json::object()));
      return;
  }
}

void read_with(std::uint8_t reader, std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (reader == 0) return read_study_of_any_kind(parse_json(text, kPlace));
  if (reader == 1) {
    const SimulationSpec spec = parse_simulation(parse_json(text, kPlace), kPlace, {});
    rig_poses(spec.rig, Eigen::Vector3d::UnitY());
    return;
  }
  const MemoryFile file(bytes);
  if (reader == 2) read_campaign(file.path());
  if (reader == 3) read_mapping(file.path());
  if (reader == 4) calibration_json(read_calibration(file.path()));
}

}  // namespace
}  // namespace trilat

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::uint8_t kReaders = 5;
  if (size == 0) return 0;
  trilat::tolerate_bad_input([&] { trilat::read_with(data[0] % kReaders, {data + 1, size - 1}); });
  return 0;
}
