// SPDX-License-Identifier: MIT
// `trilat calibrate`.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/units.h"
#include "datasets/rig/calibration.h"
#include "pipeline/accuracy/fuse_session.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/calibration/calibrate_bodies.h"
#include "pipeline/calibration/calibrate_wand.h"
#include "pipeline/calibration/wand_views.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/study/study.h"
#include "reports/render/render.h"

namespace trilat {
namespace {

struct CalibrateArguments {
  std::vector<std::filesystem::path> sessions;
  std::filesystem::path output;
  std::string method = "wand";
  std::filesystem::path from;  // of bodies: the calibration that is corrected; empty: none
  std::optional<double> ball_radius_m;
  std::filesystem::path mocap;
  std::string asset;
  std::optional<std::int64_t> mocap_start_host_ns;
  std::optional<double> baseline_m;
  std::optional<double> movement_sigma_m;
  bool no_depth_correction = false;
  std::string trajectory_axis;  // x, y or z; empty: that of the method
  int threads = 0;
  bool force = false;  // may replace what others wrote
  bool json = false;
};

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
  table.notes.push_back("± is one standard deviation an axis.");
  return table;
}

// Doubts that a person should look at before trusting the calibration; empty without any.
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
          fmt::format("{} disagrees with the others at {} positions; was it moved, or are its intrinsics "
                      "another sensor's?",
                      pose.name, pose.left_out));
  }
  if (calibration.method == "wand" && calibration.reduced_chi2.value_or(0.0) > 4.0)
    doubts.push_back(
        fmt::format("residuals are {:.1f} times what noise explains; the intrinsics may be wrong",
                    std::sqrt(*calibration.reduced_chi2)));
  return doubts;
}

void print_text(const Calibration& calibration, const std::vector<SensorEvidence>& evidence,
                const std::filesystem::path& output) {
  fmt::print("{}\n", markdown_of(sensors_table(calibration, evidence)));
  for (const RejectedSighting& r : calibration.rejected)
    fmt::print("left out: {} at position {} ({:.1f} s after the first), {}\n", r.sensor, r.position, r.time_s,
               r.off_by_m ? fmt::format("{:.0f} mm off", 1e3 * *r.off_by_m)
                          : std::string("seen by two that disagree"));
  if (calibration.method == "bodies")
    fmt::print(
        "± comes from leaving each joint out in turn: it contains what the tracker does differently at every "
        "joint, and nothing that it does to all joints of a sensor alike.\n");
  const std::vector<std::string> doubts = doubts_about(calibration);
  for (const std::string& doubt : doubts) fmt::print("look at: {}\n", doubt);
  if (doubts.empty() && calibration.sensors.front().covariance)
    fmt::print("{} {}; nothing looks wrong.\n", calibration.positions,
               calibration.method.ends_with("bodies") ? "joint positions" : "wand positions");
  fmt::print("calibration: {}\n", output.string());
}

// A calibration that has been written to `output`, on stdout: the sensors, what was left out, and what a
// person should look at before trusting it. `evidence`: one a sensor, or empty.
void print_calibration(const Calibration& calibration, const std::vector<SensorEvidence>& evidence,
                       const std::filesystem::path& output, bool json) {
  if (!json) {
    print_text(calibration, evidence, output);
    return;
  }
  Json document = json_of(calibration);
  document["calibration"] = output.string();
  document["look_at"] = doubts_about(calibration);
  fmt::print("{}\n", json_text(document, 2));
}

CalibrateWandOptions wand_options(const CalibrateArguments& arguments, const RunControl& control) {
  CalibrateWandOptions options;
  if (arguments.ball_radius_m) options.search.find.ball_radius_m = *arguments.ball_radius_m;
  options.search.control = control;
  options.depth_correction = !arguments.no_depth_correction;
  options.baseline_m = arguments.baseline_m;
  if (arguments.movement_sigma_m) options.movement_sigma_m = *arguments.movement_sigma_m;
  const auto axis = std::ranges::find(kTrajectoryAxes, arguments.trajectory_axis);
  if (axis != kTrajectoryAxes.end())
    options.trajectory_axis = static_cast<TrajectoryAxis>(axis - kTrajectoryAxes.begin());
  if (arguments.mocap.empty() != arguments.asset.empty() ||
      arguments.mocap.empty() == arguments.mocap_start_host_ns.has_value())
    throw InputError("--mocap", "needs --asset and --mocap-start-host-ns beside it, and they need it");
  if (!arguments.mocap.empty())
    options.world = WandInWorld{arguments.mocap, arguments.asset, *arguments.mocap_start_host_ns};
  return options;
}

// Options that the method would not look at.
void refuse_ignored(const CalibrateArguments& a) {
  const bool bodies = a.method == "bodies", two = a.method == "two_positions" || a.method == "printed";
  const auto refuse = [&](const char* option) {
    throw InputError(option, "is of no use with --method " + a.method);
  };
  if (bodies && !a.mocap.empty()) refuse("--mocap");
  if (!bodies && !a.from.empty()) refuse("--from");
  if (bodies && a.baseline_m) refuse("--movement-m");
  if (bodies && a.movement_sigma_m) refuse("--movement-sigma-m");
  if (bodies && a.ball_radius_m) refuse("--ball-radius-m");
  if ((bodies || two) && a.no_depth_correction) refuse("--no-depth-correction");
  if (!two && !a.trajectory_axis.empty()) refuse("--trajectory-axis");
  if ((bodies || two) && a.sessions.size() > 1)
    throw InputError(a.sessions[1].string(), "is one session too many for --method " + a.method);
  if (!a.mocap.empty() && a.baseline_m)
    throw InputError("--movement-m",
                     "is of no use beside --mocap, which already says how far the wand moved");
}

WandMethod wand_method(const CalibrateArguments& arguments) {
  if (arguments.method == "wand") return WandMethod::wand;
  return arguments.method == "printed" ? WandMethod::printed : WandMethod::two_positions;
}

std::vector<std::filesystem::path> inputs_of(const CalibrateArguments& arguments) {
  std::vector<std::filesystem::path> inputs = arguments.sessions;
  inputs.push_back(arguments.mocap);
  inputs.push_back(arguments.from);
  return inputs;
}

struct Calibrated {
  Calibration calibration;
  std::vector<SensorEvidence> evidence;
  std::vector<CheckRow> checks = {};
  std::vector<std::string> notes = {};
};

Calibrated calibrate_by(const CalibrateArguments& arguments) {
  Progress progress(arguments.method == "bodies" ? "calibrating" : "looking for the wand");
  if (!arguments.from.empty()) {
    CorrectedCalibration result =
        correct_calibration(arguments.sessions[0], arguments.from, {stop_requested, {}});
    std::vector<std::string> notes;
    for (const TakeNote& note : result.notes) notes.push_back(note.place + ": " + note.text);
    return {std::move(result.calibration), {}, std::move(result.checks), std::move(notes)};
  }
  if (arguments.method == "bodies") {
    BodyCalibration result = calibrate_bodies(arguments.sessions[0], {.stop_requested = stop_requested});
    for (std::string& note : result.notes) note = arguments.sessions[0].string() + ": " + note;
    return {std::move(result.calibration), {}, {}, std::move(result.notes)};
  }
  const RunControl control{stop_requested, [&](double share) { progress.set(share); }};
  WandCalibration result =
      calibrate_wand(arguments.sessions, wand_options(arguments, control), wand_method(arguments));
  return {std::move(result.calibration), std::move(result.views.evidence)};
}

int calibrate(const CalibrateArguments& arguments) {
  refuse_ignored(arguments);
  check_output_file({arguments.output, inputs_of(arguments), arguments.force});
  Calibrated outcome;
  on_threads(arguments.threads, [&](int) { outcome = calibrate_by(arguments); });
  write_calibration(arguments.output, outcome.calibration);
  for (const std::string& note : outcome.notes) fmt::print(stderr, "note: {}\n", note);
  if (!arguments.json)
    for (const std::string& line : pose_lines(outcome.checks)) fmt::print("{}\n", line);
  print_calibration(outcome.calibration, outcome.evidence, arguments.output, arguments.json);
  return kDone;
}

}  // namespace

void add_calibrate(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<CalibrateArguments>(
      app, code, "calibrate", "wand frames to sensor poses, with stated uncertainty", calibrate);
  verb.add_option("sessions", a.sessions,
                  "session.h5 of one rig, in which the wand is held still at many places")
      ->required();
  verb.add_option("-o,--output", a.output, "calibration.json")->required();
  verb.add_option("--method", a.method,
                  "wand: all positions, refined together; bodies: a tracked person instead of a wand; "
                  "two_positions, printed: the paper's eq. 6 and 7, corrected and as printed")
      ->check(CLI::IsMember({"wand", "bodies", "two_positions", "printed"}))
      ->capture_default_str();
  verb.add_option("--from", a.from,
                  "bodies: this calibration.json, its sensors turned and shifted as the bodies show");
  verb.add_option("--ball-radius-m", a.ball_radius_m, "radius of the wand's ball; else 0.075")
      ->check(CLI::Range(0.02, 0.3));
  removed_option(verb, "--intrinsics",
                 "write them into the session: docs/how-to/calibrate.md has the three lines of h5py");
  verb.add_option("--mocap", a.mocap, "OptiTrack export of the wand: poses come out in OptiTrack's world");
  verb.add_option("--asset", a.asset, "asset of the export whose position is the ball's centre");
  verb.add_option("--mocap-start-host-ns", a.mocap_start_host_ns,
                  "what the recording's host clock showed at the export's first frame");
  verb.add_option("--movement-m", a.baseline_m,
                  "how far the wand moved from its first place to its second, when measured: fixes the scale")
      ->check(CLI::PositiveNumber);
  verb.add_option("--movement-sigma-m", a.movement_sigma_m, "standard deviation of --movement-m; else 0.001")
      ->check(CLI::PositiveNumber);
  verb.add_option("--trajectory-axis", a.trajectory_axis,
                  "two_positions, printed: which axis of the sensor (x right, y down, z depth) is the "
                  "paper's y of eq. 6; without it y as printed, z (a horizontal axis) corrected")
      ->check(CLI::IsMember({"x", "y", "z"}));
  verb.add_flag("--no-depth-correction", a.no_depth_correction,
                "do not estimate each sensor's depth offset and wiggle beside its pose");
  add_threads(verb, a.threads);
  add_force(verb, a.force);
  add_json(verb, a.json);
}

}  // namespace trilat
