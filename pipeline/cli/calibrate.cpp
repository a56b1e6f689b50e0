// SPDX-License-Identifier: MIT
// `trilat calibrate`.
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/units.h"
#include "pipeline/calibration/calibrate_bodies.h"
#include "pipeline/calibration/calibrate_two_positions.h"
#include "pipeline/calibration/calibrate_wand.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/results_folder.h"
#include "reports/render.h"

namespace trilat {
namespace {

constexpr double kGoodSigma_m = 0.005;
constexpr double kGoodSigma_rad = 0.2 * kRadPerDegree;
constexpr std::uint64_t kFewPositions = 15;

std::vector<std::pair<std::string, std::filesystem::path>> named_files(
    const std::vector<std::string>& entries) {
  std::vector<std::pair<std::string, std::filesystem::path>> result;
  for (const std::string& entry : entries) {
    const std::size_t equals = entry.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size())
      throw InputError("--intrinsics " + entry, "must be SENSOR=FILE, as in k1=calib_ir.yaml");
    result.emplace_back(entry.substr(0, equals), entry.substr(equals + 1));
  }
  return result;
}

CalibrateWandOptions wand_options(const CalibrateArguments& arguments, Progress& progress) {
  CalibrateWandOptions options;
  options.search.find.ball_radius_m = arguments.ball_radius_m;
  options.search.stop_requested = stop_requested;
  options.search.progress = [&](double share) { progress.set(share); };
  options.intrinsics = named_files(arguments.intrinsics);
  options.depth_correction = !arguments.no_depth_correction;
  options.movement_m = arguments.movement_m;
  options.movement_sigma_m = arguments.movement_sigma_m;
  if (arguments.mocap.empty() != arguments.asset.empty() ||
      arguments.mocap.empty() == arguments.mocap_start_host_ns.has_value())
    throw InputError("--mocap", "needs --asset and --mocap-start-host-ns beside it, and they need it");
  if (!arguments.mocap.empty())
    options.world = WandInWorld{arguments.mocap, arguments.asset, *arguments.mocap_start_host_ns};
  return options;
}

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

void print_text(const CalibrateArguments& arguments, const Calibration& calibration,
                const std::vector<SensorEvidence>& evidence) {
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
  fmt::print("calibration: {}\n", arguments.output.string());
}

// Options that the method would not look at.
void refuse_ignored(const CalibrateArguments& a) {
  const bool bodies = a.method == "bodies", two = a.method == "two_positions" || a.method == "printed";
  const auto refuse = [&](const char* option) {
    throw InputError(option, "is of no use with --method " + a.method);
  };
  if ((bodies || two) && !a.mocap.empty()) refuse("--mocap");
  if (bodies && !a.intrinsics.empty()) refuse("--intrinsics");
  if (bodies && a.movement_m) refuse("--movement-m");
  if ((bodies || two) && a.no_depth_correction) refuse("--no-depth-correction");
  if ((bodies || two) && a.sessions.size() > 1)
    throw InputError(a.sessions[1].string(), "is one session too many for --method " + a.method);
  if (!a.mocap.empty() && a.movement_m)
    throw InputError("--movement-m",
                     "is of no use beside --mocap, which already says how far the wand moved");
}

struct Outcome {
  Calibration calibration;
  std::vector<SensorEvidence> evidence;
};

Outcome calibrate_by(const CalibrateArguments& arguments) {
  Progress progress(arguments.method == "bodies" ? "calibrating" : "looking for the wand");
  refuse_ignored(arguments);
  if (arguments.method == "bodies") {
    CalibrateBodiesOptions options;
    options.stop_requested = stop_requested;
    options.progress = [&](double share) { progress.set(share); };
    return {calibrate_bodies(arguments.sessions[0], options).calibration, {}};
  }
  const CalibrateWandOptions options = wand_options(arguments, progress);
  if (arguments.method == "wand") {
    WandCalibration result = calibrate_wand(arguments.sessions, options);
    return {std::move(result.calibration), std::move(result.views.evidence)};
  }
  const bool corrected = arguments.method == "two_positions";
  const WandViews views = view_wand(arguments.sessions, options);
  const TwoPositionOptions two{corrected, corrected, corrected, Eigen::Vector3d::UnitY()};
  return {calibrate_two_positions(views, arguments.sessions[0], two, arguments.movement_m, !corrected),
          views.evidence};
}

}  // namespace

int calibrate(const CalibrateArguments& arguments) {
  check_output_file(arguments.output);  // before minutes of work
  Outcome outcome;
  on_threads(arguments.threads, [&](int) { outcome = calibrate_by(arguments); });
  write_calibration(arguments.output, outcome.calibration);
  if (!arguments.json) {
    print_text(arguments, outcome.calibration, outcome.evidence);
    return kDone;
  }
  Json json = calibration_json(outcome.calibration);
  json["calibration"] = arguments.output.string();
  json["look_at"] = doubts_about(outcome.calibration);
  fmt::print("{}\n", json_text(json, 2));
  return kDone;
}

}  // namespace trilat
