// SPDX-License-Identifier: MIT
#include "pipeline/items/study_items.h"

#include <atomic>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "pipeline/cli/execute_budget.h"
#include "pipeline/cli/simulate_part.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/same_results.h"

namespace trilat {
namespace {

using ::testing::HasSubstr;

constexpr const char* kCalibration = R"({"format": "trilat.study", "version": 1, "kind": "calibration",
    "name": "tiny", "units": 3, "samples": 2, "near_samples": 1, "frames": 1, "distortion_units": 2,
    "distortion_frames": 3, "runs": 3, "positions": 6, "position_frames": 1, "bodies_s": 2, "effect_joints": 100})";
constexpr const char* kRecording = R"({"format": "trilat.study", "version": 1, "kind": "recording",
    "name": "tiny", "frames": 90, "sensors": 2, "runs": 2, "capture_s": 0,
    "networks": [{"name": "quiet"}, {"name": "busy", "jitter_s": 0.002, "lost_share": 0.05}],
    "methods": [{"method": "linear"}, {"method": "nonlinear"}]})";
constexpr const char* kBudget = R"({"format": "trilat.study", "version": 1, "kind": "error_budget",
    "name": "tiny", "simulation": "simulation.json", "resamples": 0,
    "methods": [{"method": "mean"}, {"method": "nonlinear"}]})";
constexpr const char* kSimulation =
    R"({"format": "trilat.simulation", "version": 1, "name": "short", "seed": 3,
    "participants": 1, "activities": [{"name": "walking", "duration_s": 1}], "body_tracker": {}})";

// Runs of the program, each in a folder of its own name.
struct Study {
  ScratchFolder folder;
  std::string file;

  explicit Study(const char* text) : file((folder / "study.json").string()) {
    write_file(file, text);
    write_file(folder / "simulation.json", kSimulation);
  }
  Ended run(const std::string& output, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"run", file, "-o", (folder / output).string(), "--json"});
    return run_trilat(folder, more);
  }
  Ended merge(std::uint64_t shards, const std::string& output) {
    std::vector<std::string> arguments{"merge", "-o", (folder / output).string()};
    for (std::uint64_t k = shards; k >= 1; --k)
      arguments.push_back((folder / fmt::format("part{}", k)).string());
    return run_trilat(folder, arguments);
  }
};

class EveryKind : public testing::TestWithParam<const char*> {};

TEST_P(EveryKind, MergesToTheBytesOfOneRun) {
  Study study(GetParam());
  ASSERT_EQ(study.run("whole").code, 0);
  for (const std::uint64_t shards : {1u, 2u, 7u, 64u}) {
    for (std::uint64_t k = 1; k <= shards; ++k) {
      const Ended part = study.run(fmt::format("part{}", k), {"--shard", fmt::format("{}/{}", k, shards)});
      ASSERT_EQ(part.code, 0) << part.err;
    }
    const Ended merged = study.merge(shards, "merged");
    ASSERT_EQ(merged.code, 0) << merged.err;
    expect_same_results(study.folder / "whole", study.folder / "merged");
  }
}

TEST_P(EveryKind, TakesWhatDidNotChangeFromEarlierResults) {
  Study study(GetParam());
  ASSERT_EQ(study.run("whole").code, 0);
  const Json again = parse_json(study.run("whole").out, "stdout");
  EXPECT_EQ(again.at("items_computed"), 0);
  EXPECT_EQ(again.at("items_reused"), again.at("items"));
  const Json other =
      parse_json(study.run("other", {"--reuse", (study.folder / "whole").string()}).out, "stdout");
  EXPECT_EQ(other.at("items_computed"), 0);
  expect_same_results(study.folder / "whole", study.folder / "other");
  EXPECT_EQ(parse_json(study.run("whole", {"--fresh"}).out, "stdout").at("items_reused"), 0);
}

std::string name_of_kind(const testing::TestParamInfo<const char*>& kind) {
  constexpr const char* kNames[] = {"Calibration", "Recording", "Budget"};
  return kNames[kind.index];
}
INSTANTIATE_TEST_SUITE_P(StudyItems, EveryKind, testing::Values(kCalibration, kRecording, kBudget),
                         name_of_kind);

TEST(StudyItems, AnItemOfAnotherShardHasNoOutcomeHere) {
  const ScratchFolder folder;
  StudyItems items("test", {{"x", 1}}, {{"a"}, {"b"}}, folder.path(), {{2, 2}, {}});
  EXPECT_EQ(items.outcome("a", [] { return Json(1); }), std::nullopt);
  EXPECT_EQ(items.outcome("b", [] { return Json(2); }), Json(2));
  items.finish(folder.path(), "");
  EXPECT_EQ(read_part(folder.path()).number, 2u);
  EXPECT_EQ(read_items(folder.path()).items.size(), 1u);
}

TEST(StudyItems, WhatWasDoneBeforeAStopIsNotDoneAgain) {
  const ScratchFolder folder;
  std::atomic<int> computed{0};
  const auto once = [&](const Json& settings) {
    StudyItems items("test", settings, {{"a"}, {"b"}}, folder.path(), {});
    items.outcome("a", [&] { return Json(++computed); });
    return items.tally().continued.size();
  };
  EXPECT_EQ(once({{"x", 1}}), 0u);
  EXPECT_EQ(once({{"x", 1}}), 1u);
  EXPECT_EQ(computed, 1);
  EXPECT_EQ(once({{"x", 2}}), 0u);
  EXPECT_EQ(computed, 2);
}

TEST(Merge, RefusesPartsOfDifferentKindsAndWhatIsNoPart) {
  Study study(kRecording);
  study.run("part1", {"--shard", "1/2"});
  write_file(study.file, kBudget);
  study.run("part2", {"--shard", "2/2"});
  EXPECT_THAT(study.merge(2, "merged").err,
              HasSubstr("is a part of kind recording, the first is of error_budget"));
  std::filesystem::remove_all(study.folder / "part2");
  const Ended missing = study.merge(2, "merged");
  EXPECT_EQ(missing.code, 2);
  EXPECT_THAT(missing.err, HasSubstr("part2: holds no part.json"));
}

TEST(SimulateParts, MergeToTheCampaignThatOneSimulationMakes) {
  const ScratchFolder folder;
  write_file(folder / "simulation.json",
             R"({"format": "trilat.simulation", "version": 1, "name": "short", "seed": 3, "participants": 3,
                 "activities": [{"name": "walking", "duration_s": 0.5}], "body_tracker": {}})");
  const auto simulate = [&](const std::string& output, std::vector<std::string> more = {}) {
    more.insert(more.begin(),
                {"simulate", (folder / "simulation.json").string(), "-o", (folder / output).string()});
    return run_trilat(folder, more).code;
  };
  ASSERT_EQ(simulate("whole"), 0);
  std::vector<std::string> merge;
  for (const int shards : {1, 2, 7, 64}) {
    const std::string output = (folder / fmt::format("merged{}", shards)).string();
    merge = {"merge", "-o", output};
    for (int k = 1; k <= shards; ++k) {
      const std::string part = fmt::format("part{}of{}", k, shards);
      ASSERT_EQ(simulate(part, {"--shard", fmt::format("{}/{}", k, shards)}), 0);
      merge.push_back((folder / part).string());
    }
    const Ended merged = run_trilat(folder, merge);
    ASSERT_EQ(merged.code, 0) << merged.err;
    expect_same_results(folder / "whole", output);
  }
  EXPECT_THAT(run_trilat(folder, merge).err, HasSubstr("recordings are never replaced"));
}

// Three recordings of half a second.
struct Simulated {
  ScratchFolder folder;

  void spec(int seed) {
    write_file(folder / "simulation.json",
               fmt::format(R"({{"format": "trilat.simulation", "version": 1, "name": "short", "seed": {},
                 "participants": 3, "activities": [{{"name": "walking", "duration_s": 0.5}}]}})",
                           seed));
  }
  ItemTally part(const std::filesystem::path& output, const Shard& shard,
                 const SimulatePartOptions& options = {}) {
    const auto file = folder / "simulation.json";
    return simulate_part(read_simulation(file, {}), hash_of_file(file), shard, output, options);
  }
};

TEST(SimulateParts, ASeedThatChangedAndChangedBackBetweenStopsLeavesNoOtherRecordings) {
  Simulated simulated;
  const auto stop_in = [&](int seed, const char* recording) {
    simulated.spec(seed);
    const auto session = simulated.folder / "part.partial" / recording / "session.h5";
    std::filesystem::remove_all(session.parent_path());
    const auto is_begun = [=] { return std::filesystem::exists(session.parent_path()); };
    tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_THROW(simulated.part(simulated.folder / "part", {1, 1}, {is_begun, {}}), Interrupted);
  };
  stop_in(1, "p03-walking");
  stop_in(2, "p02-walking");
  simulated.spec(1);
  simulated.part(simulated.folder / "part", {1, 1});
  simulated.part(simulated.folder / "at-once", {1, 1});
  expect_same_results(simulated.folder / "at-once", simulated.folder / "part");
}

TEST(SimulateParts, AFinishedPartIsLeftAloneAndNothingElseReplacesIt) {
  Simulated simulated;
  simulated.spec(1);
  const auto part = simulated.folder / "part";
  simulated.part(part, {1, 2});
  const auto before = std::filesystem::last_write_time(part / "items.json");
  EXPECT_THAT(simulated.part(part, {1, 2}).reused, testing::SizeIs(2));
  std::filesystem::remove(part / "part.json");
  EXPECT_THAT(simulated.part(part, {1, 2}).computed, testing::IsEmpty());
  EXPECT_EQ(read_part(part).number, 1u);
  EXPECT_EQ(std::filesystem::last_write_time(part / "items.json"), before);
  const auto refused = [&] { return message_of([&] { simulated.part(part, {1, 2}); }); };
  EXPECT_THAT(message_of([&] { simulated.part(part, {2, 2}); }), HasSubstr("recordings are never replaced"));
  simulated.spec(2);
  EXPECT_THAT(refused(), HasSubstr("recordings are never replaced"));
  simulated.spec(1);
  std::filesystem::remove(part / "p01-walking/mocap.csv");
  EXPECT_THAT(refused(), HasSubstr("recordings are never replaced"));
  write_file(simulated.folder / "study.json", kRecording);
  EXPECT_THAT(
      run_trilat(simulated.folder, {"run", (simulated.folder / "study.json").string(), "-o", part.string()})
          .err,
      HasSubstr("is a part of kind campaign"));
  EXPECT_TRUE(std::filesystem::exists(part / "p01-walking/session.h5"));
}

TEST(SimulateParts, AreNotMergedWithoutAllFilesOfTheirRecordings) {
  Simulated simulated;
  simulated.spec(1);
  const std::vector<std::filesystem::path> parts{simulated.folder / "part"};
  simulated.part(parts[0], {1, 1});
  const auto said = [&] {
    return message_of([&] { merge_campaign(read_parts(parts), simulated.folder / "merged"); });
  };
  const auto session = parts[0] / "p02-walking/session.h5";
  std::filesystem::rename(session, simulated.folder / "aside");
  EXPECT_THAT(said(), HasSubstr("p02-walking/session.h5: is missing or has another size"));
  std::filesystem::rename(simulated.folder / "aside", session);
  const Json good = read_json(parts[0] / "part.json");
  for (const Json& work : {Json::object(), Json::array(), Json{{"simulation", 1}, {"sha256", ""}}}) {
    Json json = good;
    json["work"] = work;
    write_file(parts[0] / "part.json", json_text(json, 1));
    EXPECT_THAT(said(), HasSubstr("part.json /work")) << work;
  }
  write_file(parts[0] / "part.json", json_text(good, 1));
  EXPECT_EQ(said(), "no error");
}

TEST(Merge, RefusesABudgetsPartThatWasWrittenByHand) {
  const ScratchFolder folder;
  const Json good{
      {"study", {{"name", "tiny"}}}, {"campaign", "short"},          {"seed", 1},   {"participants", 1},
      {"calibration_sigma_m", 0.0},  {"calibration_sigma_deg", 0.0}, {"sha256", ""}};
  const auto said = [&](const Json& work) {
    return message_of([&] {
      merge_budget({{folder.path(), {"error_budget", "build", 1, 1, work, {}}}}, folder / "merged", {});
    });
  };
  Json json = good;
  json["seed"] = "one";
  EXPECT_THAT(said(json), HasSubstr("part.json /work/seed: must be"));
  json.erase("seed");
  EXPECT_THAT(said(json), HasSubstr("part.json /work/seed: is missing"));
  EXPECT_THAT(said(Json::array()), HasSubstr("part.json /work"));
}

TEST(StudyItems, OptionsThatWouldHaveNoEffectAreRefused) {
  Study study(kRecording);
  EXPECT_THAT(study.run("out", {"--dry-run", "--shard", "9/3"}).err, HasSubstr("--shard: is \"9/3\""));
  EXPECT_THAT(study.run("out", {"--memory-mb", "500"}).err, HasSubstr("--memory-mb: is for studies of kind"));
}

}  // namespace
}  // namespace trilat
