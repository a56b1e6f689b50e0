// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/wand_poses.h"

#include <algorithm>
#include <array>
#include <vector>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/calibration/calibrate_wand.h"

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

fs::path file_of(PoseSource poses, const fs::path& folder) {
  return folder / "poses" / wand_poses(poses).file;
}

// By their content, in the order of calibrate_wand()'s sources.
std::vector<std::string> hashes_of(const CampaignWand& wand, const Watch& watch) {
  std::vector<std::string> hashes{hash_of_file(wand.session, watch.stop_requested)};
  if (!wand.mocap.empty()) hashes.push_back(hash_of_file(wand.mocap, watch.stop_requested));
  return hashes;
}

bool is_made_from(const std::vector<std::string>& hashes, const fs::path& file) {
  try {
    const Calibration calibration = read_calibration(file);
    return calibration.program == kProgramVersion &&
           std::ranges::equal(calibration.sources, hashes, {}, &CalibrationSource::sha256);
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

StudySpec with_wand_poses(StudySpec study, const Campaign& campaign, const fs::path& folder,
                          const Watch& watch) {
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
  const std::vector<std::string> hashes = hashes_of(wand, watch);
  std::vector<PoseSource> missing;
  for (Stage* stage : stages) {
    stage->calibration = file_of(stage->poses, folder);
    if (std::ranges::find(missing, stage->poses) == missing.end() &&
        !is_made_from(hashes, stage->calibration))
      missing.push_back(stage->poses);
  }
  if (missing.empty()) return study;
  CalibrateWandOptions options;
  options.search.watch = watch;
  if (!wand.mocap.empty()) options.world = WandInWorld{wand.mocap, wand.asset, wand.mocap_start_host_ns};
  std::vector<WandMethod> methods;
  for (const PoseSource poses : missing) methods.push_back(wand_poses(poses).method);
  const std::vector<WandCalibration> made = calibrate_wand_by(methods, {wand.session}, options);
  make_folder(folder / "poses");
  for (std::size_t m = 0; m < missing.size(); ++m)
    write_calibration(file_of(missing[m], folder), made[m].calibration);
  return study;
}

}  // namespace trilat
