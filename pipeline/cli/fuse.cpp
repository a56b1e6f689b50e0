// SPDX-License-Identifier: MIT
// `trilat fuse`.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/mocap/mocap_writer.h"
#include "pipeline/accuracy/fuse_session.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

struct FuseArguments {
  std::filesystem::path session, calibration, output;
  std::string method = "range_bearing";
  std::string sensor;  // of single
  double rate_hz = 30.0;
  bool force = false;  // may replace what others wrote
  bool json = false;
};

// With the settings that a study gives it by default.
MethodSpec method_of(const FuseArguments& a) {
  if (!a.sensor.empty() && a.method != "single")
    throw InputError("--sensor",
                     fmt::format("is for --method single; {} uses all sensors of the session", a.method));
  Json json{{"method", a.method}};
  if (!a.sensor.empty()) json["sensors"] = {a.sensor};
  return read_as<MethodSpec>(json, {"--method", {}});
}

struct JointFormat {
  const char* extension;
  void (*write)(const std::filesystem::path&, const JointTrack&);
};

constexpr JointFormat kJointFormats[] = {{".trc", write_trc}, {".csv", write_joint_csv}};

const JointFormat& joint_format_of(const std::filesystem::path& output) {
  for (const JointFormat& format : kJointFormats)
    if (output.extension() == format.extension) return format;
  throw InputError(output.string(), "must end in .trc or .csv, which say the format");
}

int fuse(const FuseArguments& a) {
  const JointFormat& format = joint_format_of(a.output);
  const MethodSpec method = method_of(a);
  check_output_file({a.output, {a.session, a.calibration}, a.force});
  const FusedSession fused = [&] {
    Progress progress("fusing " + a.session.filename().string());
    return fuse_session(a.session, a.calibration, method, a.rate_hz,
                        {stop_requested, [&](double share) { progress.set(share); }});
  }();
  format.write(a.output, track_of(fused));
  if (a.json) {
    Json exchanged = Json::array();
    for (const ExchangedStretch& stretch : fused.exchanged)
      exchanged.push_back(
          {{"sensor", stretch.sensor}, {"first_s", stretch.first_s}, {"last_s", stretch.last_s}});
    fmt::print("{}\n", json_text(Json{{"file", a.output.string()},
                                      {"instants", fused.instants()},
                                      {"start_host_ns", fused.start_host_ns},
                                      {"sensors", fused.sensors},
                                      {"answered", fused.answered},
                                      {"exchanged", exchanged},
                                      {"rays", json_of(fused.rays)},
                                      {"checks", json_of(fused.checks)}},
                                 2));
    return fused.answered > 0.0 ? kDone : kItemsFailed;
  }
  for (const TakeNote& note : fused.notes) fmt::print(stderr, "note: {}: {}\n", note.place, note.text);
  fmt::print("{}: {} joints at {} instants ({:g} Hz) by {} from {}; {:.1f} % answered\n{}\n",
             a.output.string(), fused.joints.size(), fused.instants(), fused.rate_hz, a.method,
             fmt::join(fused.sensors, ", "), 100.0 * fused.answered, ray_text(fused.rays));
  if (method.calibration_is_estimated)
    for (const std::string& line : pose_lines(fused.checks)) fmt::print("{}\n", line);
  if (fused.answered > 0.0) return kDone;
  fmt::print(
      stderr,
      "trilat: {}: no joint at any instant has an answer: `trilat verify {}` says whether anybody was seen\n",
      a.output.string(), a.session.string());
  return kItemsFailed;
}

}  // namespace

void add_fuse(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<FuseArguments>(
      app, code, "fuse", "one person's joints from all sensors of a session, without OptiTrack", fuse);
  verb.add_option("session", a.session, "session.h5 of several calibrated sensors")->required();
  verb.add_option("--calibration", a.calibration, "calibration.json of its sensors")->required();
  verb.add_option("-o,--output", a.output,
                  "walk.trc (OpenSim's markers) or walk.csv (with statuses and sigmas)")
      ->required();
  verb.add_option("--method", a.method,
                  "any method of a study, with its default settings; range_bearing finds from the bodies how "
                  "well sensors measure, and how they stand beside their calibration")
      ->capture_default_str();
  verb.add_option("--sensor", a.sensor, "single: which one");
  verb.add_option("--rate-hz", a.rate_hz, "instants a second")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  add_force(verb, a.force);
  add_json(verb, a.json);
  verb.footer("Example: trilat fuse session.h5 --calibration calibration.json -o walk.trc");
}

}  // namespace trilat
