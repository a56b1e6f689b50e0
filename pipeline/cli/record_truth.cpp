// SPDX-License-Identifier: MIT
#include "pipeline/cli/record_truth.h"

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/calibration/calibration.h"
#include "pipeline/cli/simulated_mocap.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

constexpr double kDefaultDuration_s = 60.0;

const std::vector<Joint> kMarkerJoints{Joint::head,       Joint::shoulder_left, Joint::shoulder_right,
                                       Joint::elbow_left, Joint::elbow_right,   Joint::wrist_left,
                                       Joint::wrist_right};

}  // namespace

RecordTruth::RecordTruth(const std::vector<std::string>& sources, const std::filesystem::path& folder,
                         double duration_s)
    : folder_(folder) {
  const auto request = sources.size() == 1 ? synthetic_request(sources[0]) : std::nullopt;
  if (!request || request->live.speed != 1.0)
    throw InputError("--truth", "is known of one synthetic source at real speed only: --source synthetic:4");
  const SyntheticSetup setup = setup_of(*request);
  SimulatedTakePlan plan;
  plan.id = "take";
  plan.item = setup.item;
  plan.motion = setup.motion;
  plan.duration_s = duration_s > 0.0 ? duration_s : kDefaultDuration_s;
  plan.marker_joints = kMarkerJoints;
  make_folder(folder);
  Calibration poses{kSimulatedTruth, {}};
  poses.simulated = true;
  for (const SimulatedSensor& sensor : setup.sensors) poses.sensors.push_back(sensor.pose);
  write_calibration(folder / "calibration.json", poses);
  write_simulated_mocap(setup.simulation.mocap, plan, folder, stop_requested);
  write_mapping(folder / "mapping.json", marker_mapping(kMarkerJoints));
}

void RecordTruth::finish(FrameSource& source, const std::filesystem::path& session) const {
  auto* live = dynamic_cast<LiveSource*>(&source);
  if (!live) return;
  Campaign campaign{"recorded", true, {}, folder_};
  campaign.takes.push_back({"take",
                            "p01",
                            "walking",
                            std::filesystem::absolute(session),
                            folder_ / "calibration.json",
                            folder_ / "mocap.csv",
                            folder_ / "mapping.json",
                            live->start(),
                            {}});
  write_campaign(folder_, campaign);
}

}  // namespace trilat
