// SPDX-License-Identifier: MIT
// `trilat calibrate`.
#include <algorithm>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "pipeline/calibration/calibrate_bodies.h"
#include "pipeline/calibration/calibrate_wand.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/terminal/calibration_text.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/study/results_folder.h"

namespace trilat {
namespace {

NamedIntrinsics named_files(const std::vector<std::string>& entries) {
  NamedIntrinsics result;
  for (const std::string& entry : entries) {
    const std::size_t equals = entry.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size())
      throw InputError("--intrinsics " + entry, "must be SENSOR=FILE, as in k1=calib_ir.yaml");
    result.emplace_back(entry.substr(0, equals), entry.substr(equals + 1));
  }
  return result;
}

CalibrateWandOptions wand_options(const CalibrateArguments& arguments, const Watch& watch) {
  CalibrateWandOptions options;
  options.search.find.ball_radius_m = arguments.ball_radius_m;
  options.search.watch = watch;
  options.intrinsics = named_files(arguments.intrinsics);
  options.depth_correction = !arguments.no_depth_correction;
  options.movement_m = arguments.movement_m;
  options.movement_sigma_m = arguments.movement_sigma_m;
  const auto axis = std::find(kTrajectoryAxes.begin(), kTrajectoryAxes.end(), arguments.trajectory_axis);
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
  if ((bodies || two) && !a.mocap.empty()) refuse("--mocap");
  if (bodies && !a.intrinsics.empty()) refuse("--intrinsics");
  if (bodies && a.movement_m) refuse("--movement-m");
  if ((bodies || two) && a.no_depth_correction) refuse("--no-depth-correction");
  if (!two && !a.trajectory_axis.empty()) refuse("--trajectory-axis");
  if ((bodies || two) && a.sessions.size() > 1)
    throw InputError(a.sessions[1].string(), "is one session too many for --method " + a.method);
  if (!a.mocap.empty() && a.movement_m)
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
  for (const auto& [sensor, file] : named_files(arguments.intrinsics)) inputs.push_back(file);
  return inputs;
}

struct Calibrated {
  Calibration calibration;
  std::vector<SensorEvidence> evidence;
};

Calibrated calibrate_by(const CalibrateArguments& arguments) {
  Progress progress(arguments.method == "bodies" ? "calibrating" : "looking for the wand");
  if (arguments.method == "bodies") {
    CalibrateBodiesOptions options;
    options.stop_requested = stop_requested;
    options.progress = [&](double share) { progress.set(share); };
    return {calibrate_bodies(arguments.sessions[0], options).calibration, {}};
  }
  const Watch watch{stop_requested, [&](double share) { progress.set(share); }};
  WandCalibration result =
      calibrate_wand(arguments.sessions, wand_options(arguments, watch), wand_method(arguments));
  return {std::move(result.calibration), std::move(result.views.evidence)};
}

}  // namespace

int calibrate(const CalibrateArguments& arguments) {
  refuse_ignored(arguments);
  check_output({arguments.output, OutputKind::calibration, inputs_of(arguments), arguments.force});
  Calibrated outcome;
  on_threads(arguments.threads, [&](int) { outcome = calibrate_by(arguments); });
  write_calibration(arguments.output, outcome.calibration);
  print_calibration(outcome.calibration, outcome.evidence, arguments.output, arguments.json);
  return kDone;
}

}  // namespace trilat
