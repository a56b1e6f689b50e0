// SPDX-License-Identifier: MIT
// What a user does from end to end, with the program alone. These also run under the address sanitizer, so
// they are as small as they can be.
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "tests/pipeline/program.h"

namespace trilat {
namespace {

using testing::HasSubstr;

constexpr const char* kSimulation =
    R"({"format": "trilat.simulation", "version": 1, "name": "small", "seed": 5,
    "participants": 2, "body_tracker": {}, "activities": [{"name": "walking", "duration_s": 1}]})";
constexpr const char* kStudy =
    R"({"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "small",
    "alignments": ["mean", "none"], "resamples": 200, "block_s": 0.2,
    "methods": [{"method": "nonlinear"}, {"method": "linear"}, {"method": "mean"}]})";

class Walk : public testing::Test {
 protected:
  ScratchFolder folder;

  std::string in(const std::string& name) const { return (folder / name).string(); }
  Ended run(const std::vector<std::string>& arguments, int code = 0) const {
    Ended ended = run_trilat(folder, arguments);
    EXPECT_EQ(ended.code, code) << testing::PrintToString(arguments) << ended.out << ended.err;
    return ended;
  }
  // Into "campaign" and "study.json".
  Ended simulate(const char* simulation = kSimulation) const {
    write_file(in("study.json"), kStudy);
    return run(
        {"simulate", file_with(folder, "simulation.json", simulation), "-o", in("campaign"), "--json"});
  }
  void run_study(const std::string& output, int code = 0, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"run", in("study.json"), "--campaign", in("campaign"),
                                       "-o",  in(output),       "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    run(arguments, code);
  }
  // Of the mean at the head, not aligned, in metres.
  double error_of(const std::string& results) const {
    const Json summary = read_json(in(results) + "/summary.json");
    for (const Json& cell : summary["cells"])
      if (cell["method"] == "mean" && cell["group"] == "head" && cell["alignment"] == "none")
        return cell["mae_m"].get<double>();
    return -1.0;
  }
};

TEST_F(Walk, SimulateRunReport) {
  simulate();
  run_study("results");
  EXPECT_GT(error_of("results"), 0.001);
  EXPECT_LT(error_of("results"), 0.5);
  run({"report", in("results"), "-o", in("report")});
  EXPECT_THAT(read_file(in("report/report.html")), HasSubstr("simulated"));
  EXPECT_THAT(read_file(in("report/report.md")), HasSubstr("nonlinear"));
}

TEST_F(Walk, RecordKillRecoverVerify) {
  const Process process(folder, {"record", "--source", "synthetic:2,depth=no", "-o", in("s.h5")});
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!std::filesystem::exists(in("s.h5.partial")) && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  std::this_thread::sleep_for(std::chrono::seconds(3));
  process.kill_at_once();
  EXPECT_EQ(process.wait().code, -1);
  const Json recovered = only_json(run({"recover", in("s.h5"), "--json"}));
  EXPECT_GT(recovered["sensors"][0]["body_frames"].get<int>(), 20);
  run({"verify", in("s.h5")});
}

TEST_F(Walk, DepthCalibrateRun) {
  const Ended simulated =
      simulate(R"({"format": "trilat.simulation", "version": 1, "name": "wand", "seed": 5, "participants": 1,
      "activities": [{"name": "walking", "duration_s": 1}], "depth": {"takes": false},
      "rig": {"heights_m": [0.8, 1.7]}, "wand": {"positions": 8, "hold_s": 0.6, "move_s": 0.4}})");
  const std::int64_t start_ns = only_json(simulated)["wand"]["mocap_start_host_ns"].get<std::int64_t>();
  run({"calibrate", in("campaign/wand/session.h5"), "-o", in("calibration.json"), "--mocap",
       in("campaign/wand/mocap.csv"), "--asset", "wand", "--mocap-start-host-ns", std::to_string(start_ns)});
  run_study("exact");
  run_study("calibrated", 0, {"--calibration", in("calibration.json")});
  EXPECT_NEAR(error_of("calibrated"), error_of("exact"), 0.01);
  EXPECT_NE(error_of("calibrated"), error_of("exact"));
}

TEST_F(Walk, ASweepInTwoShardsMerges) {
  const std::string study = file_with(folder, "sweep.json", R"({"format": "trilat.study", "version": 1,
      "kind": "threshold_sweep", "name": "small", "trials": 500, "time_problems": 0, "joints": ["volume"],
      "rigs": [{"name": "mine", "heights_m": [0.6, 2.2, 0.9, 1.9]}], "thresholds": [1, 1e-4]})");
  run({"run", study, "-o", in("whole")});
  for (const char* k : {"1", "2"})
    run({"run", study, "--shard", k + std::string("/2"), "-o", in(std::string("part") + k)});
  run({"merge", in("part2"), in("part1"), "-o", in("merged")});
  const std::string whole = read_file(in("whole/summary.json"));
  EXPECT_THAT(whole, HasSubstr("mine"));
  EXPECT_EQ(read_file(in("merged/summary.json")), whole);
}

TEST_F(Walk, GateIsQuietAndThenNamesTheTakeThatFails) {
  simulate();
  run_study("baseline");
  run_study("now");
  const std::vector<std::string> gate{"gate", in("now"), "--baseline", in("baseline"), "--resamples", "200"};
  EXPECT_THAT(run(gate).out, HasSubstr("QUIET"));
  std::filesystem::resize_file(in("campaign/p02-walking/session.h5"), 3000);
  run_study("now", 1);
  EXPECT_THAT(run(gate, 1).out, HasSubstr("p02-walking"));
}

}  // namespace
}  // namespace trilat
