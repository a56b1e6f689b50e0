// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/wand_poses.h"

#include <algorithm>
#include <array>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/calibration/calibrate_wand.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

struct WandPoses {
  WandMethod method;
  const char* file;
};

const WandPoses& wand_poses(PoseSource poses) {
  static constexpr std::array kByWand{WandPoses{WandMethod::wand, "wand.json"},
                                      WandPoses{WandMethod::two_positions, "two_positions.json"},
                                      WandPoses{WandMethod::printed, "printed.json"}};
  TRILAT_CHECK(poses != PoseSource::stated, "stated poses are no wand's");
  return kByWand.at(static_cast<std::size_t>(poses) - 1);
}

// Folder of the calibrations by this wand, of this build of the program.
fs::path folder_of(const CampaignWand& wand, const fs::path& results, HashCache& hashes,
                   const RunControl& control) {
  Json inputs{hashes.hash(wand.session, control.stop_requested).sha256, wand.ball_radius_m};
  if (!wand.mocap.empty())
    inputs.insert(inputs.end(), {hashes.hash(wand.mocap, control.stop_requested).sha256, wand.asset,
                                 wand.mocap_start_host_ns});
  return results / "poses" / key_of({{"wand", inputs}}).substr(0, 12);
}

}  // namespace

bool asks_for_wand(const StudySpec& study) {
  return std::ranges::any_of(stages_of(study),
                             [](const Stage& stage) { return stage.poses != PoseSource::stated; });
}

StudySpec with_wand_poses(StudySpec study, const Campaign& campaign, const fs::path& results,
                          HashCache& hashes, const RunControl& control) {
  std::vector<Stage*> stages;
  for (Stage& stage : study.stages) stages.push_back(&stage);
  if (stages.empty()) stages.push_back(&study.stage);
  std::erase_if(stages, [](const Stage* stage) { return stage->poses == PoseSource::stated; });
  if (stages.empty()) return study;
  if (!campaign.wand)
    throw InputError("study \"" + study.name + "\" /poses",
                     "asks for poses by a wand, and the campaign names none: add \"wand\": {\"session\": …} "
                     "to its campaign.json, or leave the key out for the takes' own calibration");
  const CampaignWand& wand = *campaign.wand;
  const fs::path folder = folder_of(wand, results, hashes, control);
  std::vector<PoseSource> missing;
  for (Stage* stage : stages) {
    stage->calibration = folder / wand_poses(stage->poses).file;
    if (!fs::exists(stage->calibration) && std::ranges::find(missing, stage->poses) == missing.end())
      missing.push_back(stage->poses);
  }
  if (missing.empty()) return study;
  CalibrateWandOptions options;
  options.search.control = control;
  options.search.find.ball_radius_m = wand.ball_radius_m;
  if (!wand.mocap.empty()) options.world = WandInWorld{wand.mocap, wand.asset, wand.mocap_start_host_ns};
  std::vector<WandMethod> methods;
  for (const PoseSource poses : missing) methods.push_back(wand_poses(poses).method);
  const std::vector<WandCalibration> made = calibrate_wand_by(methods, {wand.session}, options);
  make_folder(folder);
  for (std::size_t m = 0; m < missing.size(); ++m)
    write_calibration(folder / wand_poses(missing[m]).file, made[m].calibration);
  return study;
}

}  // namespace trilat
