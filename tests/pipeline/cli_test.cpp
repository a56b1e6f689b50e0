// SPDX-License-Identifier: MIT
// The program as a person or a script meets it.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/summary.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using Clock = std::chrono::steady_clock;

const std::vector<std::string> kVerbs{"info",      "verify", "recover", "record",    "simulate",
                                      "calibrate", "run",    "report",  "reproduce", "demo",
                                      "init",      "merge",  "gate",    "fuse",      "schema"};

std::string simulation_file(const ScratchFolder& folder, const std::string& members) {
  return file_with(folder, "simulation.json",
                   R"({"format": "trilat.simulation", "version": 1, )" + members + "}");
}

std::string study_file(const ScratchFolder& folder) {
  return file_with(folder, "study.json", R"({"format": "trilat.study", "version": 1, "kind": "accuracy",
      "name": "test", "methods": [{"method": "nonlinear"}, {"method": "mean"}]})");
}

constexpr const char* kTwoShortTakes =
    R"("participants": 2, "activities": [{"name": "walking", "duration_s": 1}])";

TEST(Door, EveryVerbHasHelp) {
  const ScratchFolder folder;
  for (const std::string& verb : kVerbs) {
    const Ended ended = run_trilat(folder, {verb, "--help"});
    EXPECT_EQ(ended.code, 0) << verb;
    EXPECT_THAT(ended.out, HasSubstr(verb));
    EXPECT_EQ(ended.err, "");
  }
  const Ended ended = run_trilat(folder, {"--help"});
  EXPECT_EQ(ended.code, 0);
  for (const std::string& verb : kVerbs) EXPECT_THAT(ended.out, HasSubstr("\n  " + verb));
  const Ended version = run_trilat(folder, {"--version"});
  EXPECT_THAT(version.out, StartsWith("trilat "));
  EXPECT_THAT(version.out,
              ::testing::ContainsRegex(
                  "\ncommit [^,]+, .*\nEigen [0-9.]+, Ceres [0-9.]+, OpenCV [0-9.]+, HDF5 [0-9.]+"));
}

TEST(Door, WrongUsageIsOneLineAndExitCodeTwo) {
  const ScratchFolder folder;
  expect_refused(run_trilat(folder, {}), "subcommand is required");
  expect_refused(run_trilat(folder, {"levitate"}), "levitate");
  expect_refused(run_trilat(folder, {"simualte"}), "did you mean \"simulate\"?");
  expect_refused(run_trilat(folder, {"run", "tabel3", "-o", "x"}), "did you mean \"table3\"?");
  expect_refused(run_trilat(folder, {"--levitate"}), "subcommand is required");
  expect_refused(run_trilat(folder, {"simulate"}), "required");
  expect_refused(run_trilat(folder, {"run", "a.json", "--threads", "many"}), "--threads");
  expect_refused(run_trilat(folder, {"run", "a.json", "--threads", "-1"}), "--threads");
  expect_refused(run_trilat(folder, {"reproduce", "--scale", "huge"}), "huge");
  for (const std::string& verb : kVerbs)
    expect_refused(run_trilat(folder, {verb, "a", "-o", "b", "--levitate"}), "");
}

TEST(Door, AMessageSaysWhatWouldBeRight) {
  const ScratchFolder folder;
  const std::string simulation = simulation_file(folder, kTwoShortTakes), study = study_file(folder),
                    campaign = folder / "campaign";
  ASSERT_EQ(run_trilat(folder, {"simulate", simulation, "-o", campaign}).code, 0);
  const std::string nose = file_with(folder, "nose.json", R"({"format": "trilat.study", "version": 1,
      "kind": "accuracy", "name": "n", "joints": ["nose"], "methods": [{"method": "mean"}]})");
  const std::string feet = file_with(folder, "feet.json", R"({"format": "trilat.study", "version": 1,
      "kind": "accuracy", "name": "f", "joints": ["foot_left"], "methods": [{"method": "mean"}]})");
  const std::string four = file_with(folder, "four.json", R"({"format": "trilat.study", "version": 1,
      "kind": "accuracy", "name": "s", "methods": [{"method": "single", "sensors": ["k1"]},
      {"method": "single", "sensors": ["k9"]}]})");
  const std::string k9 = file_with(folder, "k9.json", R"({"format": "trilat.study", "version": 1,
      "kind": "accuracy", "name": "k", "sensors": ["k1", "k9"], "methods": [{"method": "mean"}]})");
  const std::string kinect = file_with(folder, "kinect.csv", "1,0.0,0.1,0.2\n2,0.033,0.1,0.2\n");
  const std::string results = folder / "results";
  const struct {
    std::vector<std::string> arguments;
    const char* said;
  } cases[] = {
      {{"run", simulation, "-o", results},
       "\"trilat.simulation\", which `trilat simulate` takes; here it must be"},
      {{"simulate", study, "-o", results}, "\"trilat.study\", which `trilat run` takes; here it must be"},
      {{"run"}, "trilat: run: study is required. Usage: trilat run [OPTIONS] study"},
      {{"run", study, "more"}, "trilat: run: "},
      {{"report", campaign, "-o", folder / "report"}, "is a campaign; `trilat run STUDY.json --campaign"},
      {{"report", study, "-o", folder / "report"},
       "is a file; a results folder is meant, which `trilat run` makes"},
      {{"report", folder / "absent", "-o", folder / "report"},
       "does not exist; `trilat run` makes results folders"},
      {{"run", nose, "--campaign", campaign, "-o", results},
       "which is no joint; known are: spine_base, spine_mid,"},
      {{"run", feet, "--campaign", campaign, "-o", results},
       "asks for foot_left, which no take's mapping maps; they map"},
      {{"run", four, "--campaign", campaign, "-o", results},
       "method \"single k9\": names the sensor \"k9\"; the rig has k1"},
      {{"info", kinect}, "Bodies of a Kinect belong into a session: `python3 -m trilat.convert` makes one"},
  };
  for (const auto& [arguments, said] : cases) expect_refused(run_trilat(folder, arguments), said);
  EXPECT_THAT(run_trilat(folder, {"run", k9, "--campaign", campaign, "-o", results}).err,
              HasSubstr("has no sensor \"k9\"; it has k1, k2, k3, k4; name those to use under \"sensors\""));
}

TEST(Door, ARigThatSeesNobodyIsSaidTo) {
  const ScratchFolder folder;
  const std::string simulation =
      simulation_file(folder, std::string(R"("rig": {"centre_m": [50, 1, 0]}, )") + kTwoShortTakes);
  const Ended simulated = run_trilat(folder, {"simulate", simulation, "-o", folder / "c"});
  EXPECT_THAT(simulated.err, HasSubstr("p01-walking: no sensor sees anybody"));
  EXPECT_THAT(run_trilat(folder, {"verify", folder / "c/p01-walking/session.h5"}).out,
              HasSubstr("no sensor sees anybody: no frame holds a body"));
}

TEST(Door, AMissingFileIsNamed) {
  const ScratchFolder folder;
  const std::string absent = folder / "absent";
  for (const char* verb : {"info", "verify"}) expect_refused(run_trilat(folder, {verb, absent}), absent);
  for (const char* verb : {"simulate", "run", "report"})
    expect_refused(run_trilat(folder, {verb, absent, "-o", folder / "out"}), absent);
  expect_refused(run_trilat(folder, {"run", study_file(folder), "--campaign", absent, "-o", folder / "out"}),
                 absent);
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(Door, AFolderOrAnEmptyFileInPlaceOfAFileIsNamed) {
  const ScratchFolder folder;
  const std::string place = folder.path().string(), empty = file_with(folder, "empty", "");
  for (const char* verb : {"info", "verify"}) {
    expect_refused(run_trilat(folder, {verb, place}), place);
    expect_refused(run_trilat(folder, {verb, empty}), empty);
  }
  for (const char* verb : {"simulate", "run"}) {
    expect_refused(run_trilat(folder, {verb, place, "-o", folder / "out"}), place);
    expect_refused(run_trilat(folder, {verb, empty, "-o", folder / "out"}), empty);
  }
}

TEST(Door, ANameTheFileSystemRefusesIsBadInputNotABug) {
  const ScratchFolder folder;
  const std::string name = folder / std::string(300, 'a');
  expect_refused(run_trilat(folder, {"report", name, "-o", folder / "out"}), "aaa");
  expect_refused(run_trilat(folder, {"info", name}), "aaa");
  expect_refused(run_trilat(folder, {"simulate", simulation_file(folder, kTwoShortTakes), "-o", name}),
                 "aaa");
}

TEST(Door, WrongSettingsAreNamedByTheirPointer) {
  const ScratchFolder folder;
  expect_refused(
      run_trilat(folder, {"simulate", simulation_file(folder, "\"sed\": 1"), "-o", folder / "out"}),
      "simulation.json /sed: is an unknown key");
  expect_refused(run_trilat(folder, {"run", study_file(folder), "-o", folder / "out"}),
                 "study.json /campaign: is missing");
}

// simulate, info, verify, mocap, run and report, one after the other, as in docs/how-to/own_recordings.md.
TEST(RunVerb, AWholeWalkPrintsOneJsonDocumentAStep) {
  const ScratchFolder folder;
  const std::string campaign = folder / "campaign", take = campaign + "/p01-walking";
  Ended ended =
      run_trilat(folder, {"simulate", simulation_file(folder, kTwoShortTakes), "-o", campaign, "--json"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(only_json(ended)["takes"].size(), 2u);

  ended = run_trilat(folder, {"info", take + "/session.h5", "--json"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_EQ(only_json(ended)["sensors"].size(), 4u);
  EXPECT_NEAR(only_json(ended)["sensors"][0]["rate_hz"].get<double>(), 30.0, 1.5);
  EXPECT_EQ(only_json(ended)["sensors"][0]["clock"]["sensor_restarts"], 0);
  EXPECT_LT(only_json(ended)["sensors"][0]["clock"]["offset_bound_s"].get<double>(), 0.002);
  EXPECT_EQ(only_json(ended)["complete"], true);

  ended = run_trilat(folder, {"verify", take + "/session.h5", "--json"});
  EXPECT_EQ(ended.code, 0) << ended.out;
  EXPECT_EQ(only_json(ended)["sound"], true);

  ended = run_trilat(folder, {"info", take + "/mocap.csv", "--json"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_EQ(only_json(ended)["assets"].size(), 28u);
  EXPECT_EQ(only_json(ended)["frames"], 101);
  EXPECT_EQ(only_json(ended)["rate_hz"], 100.0);

  const std::string study = study_file(folder), results = folder / "results";
  ended = run_trilat(folder, {"run", study, "--campaign", campaign, "--dry-run", "--json"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_EQ(only_json(ended)["takes"].size(), 2u);
  EXPECT_FALSE(std::filesystem::exists(results));

  ended =
      run_trilat(folder, {"run", study, "--campaign", campaign, "-o", results, "--cross-check", "--json"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(only_json(ended)["takes_failed"], 0);
  EXPECT_EQ(only_json(ended)["cross_check_passed"], true);

  ended = run_trilat(folder, {"report", results, "-o", folder / "report", "--json"});
  EXPECT_EQ(ended.code, 0);
  const Json written = only_json(ended);
  for (const auto& file : written["files"])
    EXPECT_TRUE(std::filesystem::exists(file.get<std::string>())) << file;
  EXPECT_THAT(read_file(folder / "report/report.html"), Not(HasSubstr("id=\"claims\"")));
  EXPECT_EQ(run_trilat(folder, {"report", results, "-o", folder / "report", "--paper"}).code, 0);
  EXPECT_THAT(read_file(folder / "report/report.html"), HasSubstr("id=\"claims\""));
}

TEST(RunVerb, ABrokenTakeGivesExitCodeOneAndItsPlace) {
  const ScratchFolder folder;
  const std::string campaign = folder / "campaign", study = study_file(folder);
  run_trilat(folder, {"simulate", simulation_file(folder, kTwoShortTakes), "-o", campaign});
  std::filesystem::remove(campaign + "/p02-walking/mocap.csv");
  for (const bool json : {false, true}) {
    std::vector<std::string> arguments{"run", study, "--campaign", campaign, "-o", folder / "results"};
    if (json) arguments.push_back("--json");
    const Ended ended = run_trilat(folder, arguments);
    EXPECT_EQ(ended.code, 1);
    EXPECT_THAT(ended.err, HasSubstr("failed: take p02-walking: p02-walking/mocap.csv: cannot be opened"));
    if (json) {
      EXPECT_EQ(only_json(ended)["takes_failed"], 1);
    } else {
      EXPECT_THAT(ended.out, HasSubstr("1 of 2 takes"));
    }
  }
  const Ended dry = run_trilat(folder, {"run", study, "--campaign", campaign, "--dry-run"});
  EXPECT_EQ(dry.code, 1);
  EXPECT_THAT(dry.out, HasSubstr("p02-walking          cannot be evaluated: "));
}

TEST(RunVerb, ASessionThatIsNotSoundGivesExitCodeOne) {
  const ScratchFolder folder;
  const std::string session = folder / "campaign/p01-walking/session.h5";
  run_trilat(folder, {"simulate", simulation_file(folder, kTwoShortTakes), "-o", folder / "campaign"});
  const std::string bytes = read_file(session);
  std::ofstream(session, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  const Ended ended = run_trilat(folder, {"verify", session});
  EXPECT_THAT(ended.code, testing::AnyOf(1, 2));
  EXPECT_THAT(ended.out + ended.err, HasSubstr("session.h5"));
}

// Interrupts once `sign` exists; the process must then end by itself within about a second.
Ended interrupted_at(const Process& process, const std::filesystem::path& sign) {
  const auto given_up = Clock::now() + std::chrono::seconds(20);
  while (!std::filesystem::exists(sign) && Clock::now() < given_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_TRUE(std::filesystem::exists(sign));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const auto start = Clock::now();
  process.interrupt();
  const Ended ended = process.wait();
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(10));
  EXPECT_EQ(ended.code, 130) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("interrupted"));
  return ended;
}

TEST(RunVerb, AnInterruptedSimulationLeavesNothingHalfWritten) {
  struct Case {
    const char *settings, *being_written;
  };
  for (const auto& [settings, being_written] :
       {Case{R"("participants": 3, "activities": [{"name": "walking", "duration_s": 1e5}])",
             "p01-walking/session.h5.partial"},
        Case{R"("participants": 1, "sensor": {"rate_hz": 1}, "mocap": {"rate_hz": 2000},
                "activities": [{"name": "walking", "duration_s": 600}])",
             "p01-walking/mocap.csv.partial"},
        Case{R"("participants": 1, "activities": [{"name": "walking", "duration_s": 0.2}],
                "wand": {"positions": 10000})",
             "wand/session.h5.partial"}}) {
    const ScratchFolder folder;
    const Process process(folder, {"simulate", simulation_file(folder, settings), "-o", folder / "out"});
    interrupted_at(process, folder / "out.partial/aside/recordings" / being_written);
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  }
}

TEST(RunVerb, AnInterruptWhileEvaluatingLeavesNoResults) {
  const ScratchFolder folder;
  const std::string spec = simulation_file(folder, R"("participants": 1, "mocap": {"rate_hz": 30},
      "activities": [{"name": "walking", "duration_s": 60}])");
  run_trilat(folder, {"simulate", spec, "-o", folder / "campaign"});
  const std::string study = file_with(folder, "slow.json", R"({"format": "trilat.study", "version": 1,
      "kind": "accuracy", "name": "slow", "rate_hz": 1000, "methods": [{"method": "ceres"}]})");
  const Process process(folder, {"run", study, "--campaign", folder / "campaign", "-o", folder / "results"});
  interrupted_at(process, folder / "results.partial/aside/takes");
  EXPECT_FALSE(std::filesystem::exists(folder / "results"));
}

constexpr const char* kSweep = R"({"format": "trilat.study", "version": 1, "kind": "threshold_sweep",
    "name": "sweep", "rigs": [{"name": "a", "heights_m": [0.3, 2.3, 0.3, 2.3]}], "trials": )";

TEST(RunVerb, SweepsThresholdsWithoutACampaign) {
  const ScratchFolder folder;
  const std::string study = file_with(folder, "sweep.json", std::string(kSweep) + R"(50, "search": true})");
  const Ended text = run_trilat(folder, {"run", study, "-o", folder / "results"});
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("sweep (simulated, 50 trials a cell)"));
  EXPECT_THAT(text.out, HasSubstr("Of 4 readings tried, a/volume/range_signed/cm2/"));
  EXPECT_THAT(text.out, HasSubstr(" fits the printed errors best: typically within a factor of "));
  EXPECT_THAT(text.out,
              HasSubstr("In the reading that fits the printed times best, the smallest threshold takes "));
  const Ended json = run_trilat(folder, {"run", study, "-o", folder / "results", "--json"});
  EXPECT_EQ(only_json(json)["trials"], 4 * 12 * 50);
  EXPECT_EQ(only_json(json)["simulated"], true);
  const Ended dry = run_trilat(folder, {"run", study, "--dry-run"});
  EXPECT_THAT(dry.out, HasSubstr("4 interpretations x 4 thresholds x 3 error ranges = 48 cells x 50 trials"));
  EXPECT_THAT(dry.out, HasSubstr("a/volume/range_signed/cm2/printed/gauss_newton/objective/none/linear"));
  const Ended dry_json = run_trilat(folder, {"run", study, "--dry-run", "--json"});
  EXPECT_EQ(only_json(dry_json)["interpretations"].size(), 4u);
}

TEST(RunVerb, RefusesWhatASweepHasNoUseFor) {
  const ScratchFolder folder;
  const std::string study = file_with(folder, "sweep.json", std::string(kSweep) + "50}");
  expect_refused(
      run_trilat(folder, {"run", study, "-o", folder / "r", "--campaign", folder.path().string()}),
      "--campaign: is of no use: a threshold sweep makes its own trials and places its own sensors");
  expect_refused(run_trilat(folder, {"run", study, "-o", folder / "r", "--cross-check"}),
                 "--cross-check: is for studies of kind accuracy");
  expect_refused(run_trilat(folder, {"run", study}), "--output: is missing");
  const std::string bad = file_with(folder, "bad.json", std::string(kSweep) + R"(50, "thresholds": [-1]})");
  expect_refused(run_trilat(folder, {"run", bad, "-o", folder / "r"}),
                 "bad.json /thresholds/0: must be greater than 0, is -1");
  EXPECT_FALSE(std::filesystem::exists(folder / "r.partial"));
}

TEST(RunVerb, AnInterruptedSweepKeepsWhatIsDone) {
  const ScratchFolder folder;
  const std::string study = file_with(folder, "sweep.json", std::string(kSweep) + "1000000000000}");
  const Process process(folder, {"run", study, "-o", folder / "results"});
  const Ended ended = interrupted_at(process, folder / "results.partial");
  EXPECT_THAT(ended.err, HasSubstr("interrupted; what was finished has been kept in "));
  EXPECT_THAT(ended.err, HasSubstr("results.partial"));
  EXPECT_TRUE(std::filesystem::exists(folder / "results.partial"));
}

TEST(ReproduceVerb, RefusesAFolderOfSomebodyElse) {
  const ScratchFolder folder;
  file_with(folder, "chapter1.tex", "ten years of work");
  expect_refused(run_trilat(folder, {"reproduce", "-o", folder.path().string()}),
                 "exists and is not an earlier reproduction");
}

TEST(RunSimulate, AnInterruptedSecondTryLeavesTheFirstCampaignAsItIs) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(2);
  simulate_into(folder / "campaign", spec);
  EXPECT_TRUE(std::filesystem::exists(folder / "campaign/campaign.json"));
  spec.seed += 1;
  const std::string truth = read_file(folder / "campaign/p01-walking/truth.json");
  EXPECT_THROW(simulate_campaign(spec, folder / "campaign", {[] { return true; }, {}}), Interrupted);
  EXPECT_TRUE(std::filesystem::exists(folder / "campaign/campaign.json"));
  EXPECT_EQ(read_file(folder / "campaign/p01-walking/truth.json"), truth);
}

// Linear trilateration needs four ranges: with three sensors it answers nothing, and nothing is compared with
// it.
TEST(RunVerb, AReferenceThatAnswersNothingIsSaidAndNotComparedWith) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(2);
  spec.rig.heights_m = {0.6, 2.2, 0.9};
  simulate_into(folder / "campaign", spec);
  write_file(folder / "study.json",
             R"({"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "three",
                 "methods": [{"method": "linear"}, {"method": "nonlinear"}, {"method": "mean"}]})");
  const std::vector<std::string> run{"run", folder / "study.json", "--campaign", folder / "campaign"};
  const auto with = [&](std::initializer_list<std::string> more) {
    std::vector<std::string> arguments = run;
    arguments.insert(arguments.end(), more);
    return run_trilat(folder, arguments);
  };
  EXPECT_THAT(with({"--dry-run"}).out,
              HasSubstr("note: linear answers nothing on this rig (rank_deficient): the others are compared "
                        "with the first that answers"));
  const Ended ended = with({"-o", folder / "results"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.err,
              HasSubstr("note: study \"three\" /reference: \"linear\" answers nothing in any take; the "
                        "others are compared with \"nonlinear\""));
  const ResultsSummary summary = read_summary(folder / "results");
  EXPECT_EQ(summary.reference, "nonlinear");
  std::size_t finite = 0;
  for (const DifferenceCell& cell : summary.differences) finite += std::isfinite(cell.difference_m) ? 1 : 0;
  EXPECT_EQ(finite, summary.differences.size() / 2);  // of the mean, none of linear
  // the same as with nonlinear as reference from the start
  write_file(
      folder / "study.json",
      R"({"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "three", "reference": "nonlinear",
                 "methods": [{"method": "linear"}, {"method": "nonlinear"}, {"method": "mean"}]})");
  EXPECT_EQ(with({"-o", folder / "named"}).code, 0);
  const ResultsSummary named = read_summary(folder / "named");
  ASSERT_EQ(named.differences.size(), summary.differences.size());
  for (std::size_t k = 0; k < named.differences.size(); ++k)
    if (std::isfinite(named.differences[k].difference_m)) {
      EXPECT_EQ(named.differences[k].low_m, summary.differences[k].low_m);
    }
  EXPECT_THAT(with({"--shard", "1/2", "-o", folder / "parts"}).err,
              testing::Not(HasSubstr("answers nothing in any")));
}

TEST(Demo, MakesAPageOnceAndAgainAndLeavesOtherFoldersAlone) {
  const ScratchFolder folder;
  const std::string output = (folder / "demo").string();
  for (int again = 0; again < 2; ++again) {
    const Ended ended = run_trilat(folder, {"demo", "-o", output});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("Simulated data."));
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "demo/report/report.html"));
  std::filesystem::create_directories(folder / "mine");
  write_file(folder / "mine/thesis.txt", "all of it");
  expect_refused(run_trilat(folder, {"demo", "-o", (folder / "mine").string()}),
                 "exists and is not an earlier");
}

}  // namespace
}  // namespace trilat
