// SPDX-License-Identifier: MIT
#include "pipeline/items/study_items.h"

#include <algorithm>
#include <atomic>
#include <mutex>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "pipeline/calibration_study/calibration_spec.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/cli/budget_study.h"
#include "pipeline/cli/generated_studies.h"
#include "pipeline/cli/simulate_part.h"
#include "pipeline/recording_study/recording_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/same_results.h"

namespace trilat {
namespace {

using ::testing::HasSubstr;

constexpr const char* kCalibration = R"({"format": "trilat.study", "version": 1, "kind": "calibration",
    "name": "tiny", "units": 2, "samples": 1, "near_samples": 0, "frames": 1, "distortion_units": 2,
    "distortion_frames": 1, "rig": {"heights_m": [0.6, 2.2, 0.9]}, "runs": 2, "positions": 4, "position_frames": 1,
    "bodies_s": 0.5, "bodies_instants": 3, "effect_joints": 50, "sensor_sigmas_m": [0.01]})";
constexpr const char* kRecording = R"({"format": "trilat.study", "version": 1, "kind": "recording",
    "name": "tiny", "frames": 60, "sensors": 2, "runs": 2, "capture_s": 0,
    "networks": [{"name": "quiet"}, {"name": "busy", "jitter_s": 0.002, "lost_share": 0.05}],
    "methods": [{"method": "linear"}, {"method": "nonlinear"}]})";
constexpr const char* kBudget = R"({"format": "trilat.study", "version": 1, "kind": "error_budget",
    "name": "tiny", "simulation": "simulation.json", "resamples": 0,
    "methods": [{"method": "mean"}, {"method": "nonlinear"}]})";
constexpr const char* kSimulation =
    R"({"format": "trilat.simulation", "version": 1, "name": "short", "seed": 3,
    "participants": 1, "activities": [{"name": "walking", "duration_s": 0.3}], "body_tracker": {}})";

// Runs of the program, each in a folder of its own name.
struct StudyFiles {
  ScratchFolder folder;
  std::string file;

  explicit StudyFiles(const char* text) : file((folder / "study.json").string()) {
    write_file(file, text);
    write_file(folder / "simulation.json", kSimulation);
  }
  Json json() const { return read_json(file); }
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

struct KindOfStudy {
  const char* name;
  const char* text;
};
void PrintTo(const KindOfStudy& kind, std::ostream* out) { *out << kind.name; }

const KindOfStudy kKinds[] = {
    {"calibration", kCalibration}, {"error_budget", kBudget}, {"recording", kRecording}};

class EveryKind : public testing::TestWithParam<KindOfStudy> {};

TEST(GeneratedKinds, AllHaveARowInThisTable) {
  std::vector<std::string> tested, known;
  for (const KindOfStudy& kind : kKinds) tested.push_back(kind.name);
  for (const GeneratedKind& kind : generated_kinds()) known.push_back(name_of(kind.kind));
  EXPECT_THAT(tested, testing::UnorderedElementsAreArray(known));
}

TEST_P(EveryKind, MergesToTheBytesOfOneRun) {
  const StudyFiles files(GetParam().text);
  const GeneratedKind& kind = *generated_kind(GetParam().name);
  RunArguments arguments;
  arguments.study = files.file;
  const Study study = kind.open(arguments, files.json()).study;
  run_study(study, files.folder / "whole", {});
  for (const std::uint64_t shards : {1u, 2u, 7u, 64u}) {
    std::vector<std::filesystem::path> parts;
    for (std::uint64_t k = shards; k >= 1; --k) {
      parts.push_back(files.folder / fmt::format("part{}of{}", k, shards));
      run_study(study, parts.back(), {.work = {{k, shards}, {}}});
    }
    const auto merged = files.folder / fmt::format("merged{}", shards);
    const std::vector<FoundPart> found = read_parts(parts);
    merge_parts(kind.of_parts(found[0].part.work, "part.json"), found, merged, {});
    expect_same_results(files.folder / "whole", merged);
  }
}

TEST_P(EveryKind, TheProgramMergesItsPartsToTheBytesOfItsOneRun) {
  StudyFiles study(GetParam().text);
  ASSERT_EQ(study.run("whole").code, 0);
  for (const char* k : {"1", "2"}) {
    const Ended part = study.run(fmt::format("part{}", k), {"--shard", fmt::format("{}/2", k)});
    ASSERT_EQ(part.code, 0) << part.err;
  }
  const Ended merged = study.merge(2, "merged");
  ASSERT_EQ(merged.code, 0) << merged.err;
  expect_same_results(study.folder / "whole", study.folder / "merged");
}

TEST_P(EveryKind, TakesWhatDidNotChangeFromEarlierResults) {
  StudyFiles study(GetParam().text);
  ASSERT_EQ(study.run("whole").code, 0);
  const Json again = parse_json(study.run("whole").out, "stdout");
  EXPECT_EQ(again.at("items_computed"), 0);
  EXPECT_EQ(again.at("items_reused"), again.at("items"));
  const Json other =
      parse_json(study.run("other", {"--reuse", (study.folder / "whole").string()}).out, "stdout");
  EXPECT_EQ(other.at("items_computed"), 0);
  EXPECT_EQ(read_json(study.folder / "other/run.json").at("reused").size(), other.at("items"));
  expect_same_results(study.folder / "whole", study.folder / "other");
  EXPECT_EQ(parse_json(study.run("whole", {"--fresh"}).out, "stdout").at("items_reused"), 0);
}

INSTANTIATE_TEST_SUITE_P(StudyItems, EveryKind, testing::ValuesIn(kKinds),
                         [](const auto& kind) { return std::string(kind.param.name); });

TEST(StudyItems, AFileThatWasThrownAwayIsMadeAgain) {
  StudyFiles study(kRecording);
  ASSERT_EQ(study.run("whole").code, 0);
  for (const char* file : {"timings.json", "simulator.json"}) {
    ASSERT_TRUE(std::filesystem::remove(study.folder / "whole" / file));
    ASSERT_EQ(study.run("whole").code, 0);
    EXPECT_TRUE(std::filesystem::exists(study.folder / "whole" / file));
  }
}

TEST(StudyItems, ARecordingStudyThatTimesNothingIsLeftAloneWhenNothingChanged) {
  StudyFiles study(
      R"({"format": "trilat.study", "version": 1, "kind": "recording", "name": "tiny", "frames": 60,
      "sensors": 2, "runs": 2, "capture_s": 0, "networks": [{"name": "quiet"}]})");
  ASSERT_EQ(study.run("whole").code, 0);
  EXPECT_FALSE(std::filesystem::exists(study.folder / "whole/timings.json"));
  const auto written = std::filesystem::last_write_time(study.folder / "whole/summary.json");
  ASSERT_EQ(study.run("whole").code, 0);
  EXPECT_EQ(std::filesystem::last_write_time(study.folder / "whole/summary.json"), written);
}

TEST(StudyItems, OfAnotherShardDoNotCountAsProgress) {
  const StudyFiles files(kRecording);
  const Study study = recording_study(parse_recording_spec(files.json(), files.file));
  std::vector<double> shares;
  std::mutex mutex;
  run_study(study, files.folder / "part",
            {.threads = 1,
             .progress =
                 [&](const std::string& stage, double share) {
                   const std::lock_guard lock(mutex);
                   if (stage == "clocks") shares.push_back(share);
                 },
             .work = {{2, 2}, {}}});
  ASSERT_THAT(shares, testing::Not(testing::IsEmpty()));
  EXPECT_LT(*std::min_element(shares.begin(), shares.end()), 0.5);
  EXPECT_EQ(shares.back(), 1.0);
}

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
  StudyFiles study(kRecording);
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

TEST(SimulateParts, ADocumentThatIsReplacedMeanwhileIsRefused) {
  Simulated simulated;
  simulated.spec(1);
  std::once_flag once;
  const auto replace = [&](double) { std::call_once(once, [&] { simulated.spec(22); }); };
  EXPECT_THAT(message_of([&] {
                simulated.part(
                    simulated.folder / "part", {1, 1},
                    {.progress = replace, .inputs = WatchedFiles({simulated.folder / "simulation.json"})});
              }),
              HasSubstr("simulation.json: changed while it was being evaluated; run again"));
  EXPECT_FALSE(std::filesystem::exists(simulated.folder / "part"));
}

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
  const auto empty = simulated.folder / "empty";
  ASSERT_THAT(simulated.part(empty, {64, 64}).computed, testing::IsEmpty());
  simulated.spec(2);
  EXPECT_THAT(message_of([&] {
                simulated.part(empty, {64, 64});
              }),
              HasSubstr("recordings are never replaced"));
  EXPECT_THAT(refused(), HasSubstr("recordings are never replaced"));
  simulated.spec(1);
  std::filesystem::remove(part / "p01-walking/mocap.csv");
  EXPECT_THAT(refused(), HasSubstr("recordings are never replaced"));
  write_file(simulated.folder / "study.json", kRecording);
  EXPECT_THAT(
      run_trilat(simulated.folder, {"run", (simulated.folder / "study.json").string(), "-o", part.string()})
          .err,
      HasSubstr("is not a results folder"));
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
  const Json good{
      {"study", {{"name", "tiny"}}}, {"campaign", "short"},          {"seed", 1},   {"participants", 1},
      {"calibration_sigma_m", 0.0},  {"calibration_sigma_deg", 0.0}, {"sha256", ""}};
  const auto said = [&](const Json& work) { return message_of([&] { budget_of_parts(work, "part.json"); }); };
  Json json = good;
  json["seed"] = "one";
  EXPECT_THAT(said(json), HasSubstr("part.json /work/seed: must be"));
  json.erase("seed");
  EXPECT_THAT(said(json), HasSubstr("part.json /work/seed: is missing"));
  EXPECT_THAT(said(Json::array()), HasSubstr("part.json /work"));
}

TEST(StudyItems, OptionsThatWouldHaveNoEffectAreRefused) {
  StudyFiles study(kRecording);
  EXPECT_THAT(study.run("out", {"--dry-run", "--shard", "9/3"}).err, HasSubstr("--shard: is \"9/3\""));
  EXPECT_THAT(study.run("out", {"--memory-mb", "500"}).err, HasSubstr("--memory-mb: is for studies of kind"));
}

}  // namespace
}  // namespace trilat
