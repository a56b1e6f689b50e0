// SPDX-License-Identifier: MIT
#include "pipeline/cli/terminal/calibration_text.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/units.h"
#include "reports/render/render.h"

namespace trilat {
namespace {

constexpr double kGoodSigma_m = 0.005;
constexpr double kGoodSigma_rad = 0.2 * kRadPerDegree;
constexpr std::uint64_t kFewPositions = 15;

Table sensors_table(const Calibration& calibration, const std::vector<SensorEvidence>& evidence) {
  Table table;
  table.id = "calibration";
  table.title = fmt::format("{} sensors in the frame of: {}{}", calibration.sensors.size(), calibration.world,
                            calibration.simulated ? " (simulated recording)" : "");
  table.columns = {{"sensor", "sensor", true},
                   {"x (m)", "x_m"},
                   {"y (m)", "y_m"},
                   {"z (m)", "z_m"},
                   {"± (mm)", "sigma_mm"},
                   {"turn ± (°)", "sigma_deg"},
                   {"residual (mm)", "rms_mm"},
                   {"used", "used"},
                   {"left out", "left_out"},
                   {"depth off (mm)", "offset_mm"},
                   {"± (mm)", "offset_sigma_mm"},
                   {"seen at (m)", "seen_at", true}};
  for (std::size_t s = 0; s < calibration.sensors.size(); ++s) {
    const SensorPose& pose = calibration.sensors[s];
    const auto& t = pose.world_from_sensor.translation_m;
    const double none = std::nan("");
    const bool stated = pose.covariance.has_value();
    table.rows.push_back(
        {TableValue::of(pose.name), TableValue::of(t.x(), 4), TableValue::of(t.y(), 4),
         TableValue::of(t.z(), 4), TableValue::of(stated ? 1e3 * pose.position_sigma_m : none, 1),
         TableValue::of(stated ? pose.rotation_sigma_rad / kRadPerDegree : none, 3),
         TableValue::of(stated ? 1e3 * pose.residual_rms_m : none, 2),
         TableValue::of(static_cast<double>(pose.used), 0),
         TableValue::of(static_cast<double>(pose.left_out), 0),
         TableValue::of(pose.depth_offset_sigma_m > 0.0 ? 1e3 * pose.depth_offset_m : none, 1),
         TableValue::of(pose.depth_offset_sigma_m > 0.0 ? 1e3 * pose.depth_offset_sigma_m : none, 1),
         TableValue::of(s < evidence.size() && evidence[s].rests > 0
                            ? fmt::format("{:.1f} to {:.1f}", evidence[s].nearest_m, evidence[s].farthest_m)
                            : std::string("–"))});
  }
  table.notes.push_back("± is one standard deviation an axis; 95 % lie within 1.96 of it.");
  return table;
}

// What a person should look at before trusting the calibration; empty when there is nothing.
std::vector<std::string> doubts_about(const Calibration& calibration) {
  std::vector<std::string> doubts;
  for (const SensorPose& pose : calibration.sensors) {
    if (!pose.covariance) continue;
    if (pose.position_sigma_m > kGoodSigma_m || pose.rotation_sigma_rad > kGoodSigma_rad)
      doubts.push_back(fmt::format("{} is only known to {:.1f} mm and {:.2f}° (one standard deviation)",
                                   pose.name, 1e3 * pose.position_sigma_m,
                                   pose.rotation_sigma_rad / kRadPerDegree));
    if (pose.used < kFewPositions)
      doubts.push_back(
          fmt::format("{} saw only {} positions; {} and more are good", pose.name, pose.used, kFewPositions));
    if (pose.left_out * 5 > pose.used)
      doubts.push_back(
          fmt::format("{} disagrees with the others at {} positions; was it moved, or are its "
                      "intrinsics another sensor's?",
                      pose.name, pose.left_out));
  }
  if (calibration.method == "wand" && calibration.reduced_chi2 > 4.0)
    doubts.push_back(
        fmt::format("residuals are {:.1f} times what noise explains; the intrinsics may be wrong",
                    std::sqrt(calibration.reduced_chi2)));
  return doubts;
}

void print_text(const Calibration& calibration, const std::vector<SensorEvidence>& evidence,
                const std::filesystem::path& output) {
  fmt::print("{}\n", markdown_of(sensors_table(calibration, evidence)));
  for (const RejectedSighting& r : calibration.rejected)
    fmt::print("left out: {} at position {} ({:.1f} s after the first), {}\n", r.sensor, r.position, r.time_s,
               r.off_by_m > 0.0 ? fmt::format("{:.0f} mm off", 1e3 * r.off_by_m)
                                : std::string("seen by two that disagree"));
  if (calibration.method == "bodies")
    fmt::print(
        "± comes from leaving each joint out in turn: it contains what the tracker does differently at every "
        "joint, and nothing that it does to all joints of a sensor alike.\n");
  const std::vector<std::string> doubts = doubts_about(calibration);
  for (const std::string& doubt : doubts) fmt::print("look at: {}\n", doubt);
  if (doubts.empty() && calibration.sensors.front().covariance)
    fmt::print("{} {}; nothing looks wrong.\n", calibration.positions,
               calibration.method == "bodies" ? "joint positions" : "wand positions");
  fmt::print("calibration: {}\n", output.string());
}

}  // namespace

void print_calibration(const Calibration& calibration, const std::vector<SensorEvidence>& evidence,
                       const std::filesystem::path& output, bool json) {
  if (!json) {
    print_text(calibration, evidence, output);
    return;
  }
  Json document = calibration_json(calibration);
  document["calibration"] = output.string();
  document["look_at"] = doubts_about(calibration);
  fmt::print("{}\n", json_text(document, 2));
}

}  // namespace trilat
