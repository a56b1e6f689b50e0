// SPDX-License-Identifier: MIT
// What holds for studies of every kind: parts, stops, earlier results, damage.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "pipeline/budget/budget_study.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/simulate/campaign_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/same_results.h"

namespace trilat {
namespace {

using ::testing::HasSubstr;

constexpr const char* kCalibration = R"({"format": "trilat.study", "version": 1, "kind": "calibration",
    "name": "tiny", "units": 2, "samples": 1, "near_samples": 0, "frames": 1, "distortion_units": 2,
    "distortion_frames": 1, "rig": {"heights_m": [0.6, 2.2, 0.9]}, "runs": 2, "positions": 4, "position_frames": 1,
    "bodies_s": 0.5, "bodies_instants": 3})";
constexpr const char* kRecording = R"({"format": "trilat.study", "version": 1, "kind": "recording",
    "name": "tiny", "frames": 60, "sensors": 2, "runs": 2, 
    "networks": [{"name": "quiet"}, {"name": "busy", "jitter_s": 0.002, "lost_share": 0.05}],
    "methods": [{"method": "linear"}, {"method": "nonlinear"}]})";
constexpr const char* kBudget = R"({"format": "trilat.study", "version": 1, "kind": "error_budget",
    "name": "tiny", "simulation": "simulation.json", "resamples": 0,
    "methods": [{"method": "mean"}, {"method": "nonlinear"}]})";
constexpr const char* kSensitivity = R"({"format": "trilat.study", "version": 1, "kind": "sensitivity",
    "name": "tiny", "resamples": 0, "clock": "stated", "participants": 1, "rows": 4,
    "simulation": {"format": "trilat.simulation", "version": 1, "body_tracker": {},
      "activities": [{"name": "walking", "duration_s": 0.5}]},
    "methods": [{"method": "mean"}, {"method": "nonlinear"}],
    "space": [{"setting": "/rig/radius_m", "low": 1.8, "high": 2.2}],
    "claims": [{"better": "nonlinear", "than": ["mean"]}]})";
constexpr const char* kSweep = R"({"format": "trilat.study", "version": 1, "kind": "threshold_sweep",
    "name": "tiny", "rigs": [{"name": "a", "heights_m": [0.3, 2.3, 0.3, 2.3]}], "trials": 9000,
    "stops": ["objective"], "max_iterations": 20, "search": true, "time_problems": 5, "time_repeats": 1})";
constexpr const char* kAccuracy =
    R"({"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "tiny",
    "campaign": "campaign", "resamples": 200, "block_s": 0.1,
    "methods": [{"method": "mean"}, {"method": "nonlinear"}]})";
constexpr const char* kSimulation =
    R"({"format": "trilat.simulation", "version": 1, "name": "short", "seed": 3,
    "participants": 3, "body_tracker": {},
    "activities": [{"name": "walking", "duration_s": 0.3}]})";

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

const KindOfStudy kKinds[] = {{"accuracy", kAccuracy},       {"threshold_sweep", kSweep},
                              {"calibration", kCalibration}, {"error_budget", kBudget},
                              {"recording", kRecording},     {"sensitivity", kSensitivity}};

TEST(Kinds, AllHaveARowInThisTable) {
  std::vector<std::string> tested, known;
  for (const KindOfStudy& kind : kKinds) tested.push_back(kind.name);
  for (const Kind& kind : kinds()) known.push_back(name_of(kind.kind));
  EXPECT_THAT(tested, testing::UnorderedElementsAreArray(known));
}

// A small study of one kind, run without the program.
class EveryKind : public testing::TestWithParam<KindOfStudy> {
 protected:
  StudyFiles files{GetParam().text};
  const Kind& kind = *find_kind(GetParam().name);

  void SetUp() override {
    if (kind.no_campaign.empty())
      simulate_campaign(read_simulation(files.folder / "simulation.json"), files.folder / "campaign", {});
  }
  Study study(const Json& json) const {
    RunArguments arguments;
    arguments.study = files.file;
    return kind.open(arguments, json).plan({});
  }
  Study study() const { return study(files.json()); }
  std::filesystem::path path(const std::string& name) const { return files.folder / name; }
  std::vector<std::filesystem::path> parts(std::uint64_t shards, const StudyOptions& given = {}) const {
    std::vector<std::filesystem::path> parts;
    for (std::uint64_t k = shards; k >= 1; --k) {
      parts.push_back(path(fmt::format("part{}of{}", k, shards)));
      StudyOptions options = given;
      options.shard = {k, shards};
      run_study(study(), parts.back(), options);
    }
    return parts;
  }
  void merge(const std::vector<std::filesystem::path>& parts, const std::string& output) const {
    const std::vector<FoundPart> found = read_parts(parts);
    merge_parts(kind.of_parts(found[0].part.work, "part.json"), found, path(output), {});
  }
  // Runs until the first item is there; how many then are.
  std::size_t stop_after_one(const std::string& output, const Shard& shard = {}) const {
    const auto one_is_there = [&] { return finished_items(path(output + ".partial")) > 0; };
    EXPECT_THROW(
        run_study(study(), path(output), {.threads = 1, .stop_requested = one_is_there, .shard = shard}),
        Interrupted);
    EXPECT_FALSE(std::filesystem::exists(path(output)));
    const std::size_t finished = finished_items(path(output + ".partial"));
    EXPECT_GT(finished, 0u);
    return finished;
  }
  // item.json of the first item in a folder.
  std::filesystem::path first_item(const std::string& output) const {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path(output)))
      if (entry.path().filename() == kItemFile) return entry.path();
    return {};
  }
};

// What the engine does, whatever it computes.
class AnyKind : public EveryKind {};

// Nor does the number of threads change a byte.
TEST_P(EveryKind, MergesToTheBytesOfOneRun) {
  run_study(study(), path("whole"), {.threads = 1});
  for (const std::uint64_t shards : {1, 3}) {
    const std::string merged = fmt::format("merged{}", shards);
    merge(parts(shards), merged);
    expect_same_results(path("whole"), path(merged));
  }
}

TEST_P(EveryKind, GoesOnAfterAStopToTheSameBytes) {
  run_study(study(), path("whole"), {});
  const std::size_t finished = stop_after_one("results");
  const ItemTally tally = run_study(study(), path("results"), {});
  EXPECT_EQ(tally.continued.size(), finished);
  EXPECT_EQ(tally.all(), study().items.size());
  expect_same_results(path("whole"), path("results"));
}

TEST_P(AnyKind, AShardGoesOnAfterAStopToTheSameBytes) {
  run_study(study(), path("whole"), {});
  const std::size_t finished = stop_after_one("part1of2", {1, 2});
  EXPECT_THAT(message_of([&] { read_part(path("part1of2")); }), HasSubstr("is not finished yet"));
  EXPECT_EQ(run_study(study(), path("part1of2"), {.shard = {1, 2}}).continued.size(), finished);
  run_study(study(), path("part2of2"), {.shard = {2, 2}});
  merge({path("part2of2"), path("part1of2")}, "merged");
  expect_same_results(path("whole"), path("merged"));
}

TEST_P(AnyKind, FreshGoesOnWithNothing) {
  stop_after_one("results");
  EXPECT_THAT(run_study(study(), path("results"), {.fresh = true}).continued, testing::IsEmpty());
}

TEST_P(AnyKind, AnItemThatWasTornOrIsOfOtherSettingsIsComputedAgain) {
  const auto part = parts(1)[0];
  const auto unfinished = partial_name(part);
  Json other = read_json(first_item(part.filename()));
  other["key"] = "another";
  for (const std::string& text :
       {std::string(), std::string("{\"format\": "),
        std::string("{\"format\": \"trilat.item\", \"version\": 1}"), json_text(other, -1)}) {
    std::filesystem::rename(part, unfinished);
    write_file(first_item(unfinished.filename()), text);
    EXPECT_THAT(run_study(study(), part, {.shard = {1, 1}}).computed, testing::SizeIs(1)) << text;
  }
  run_study(study(), path("whole"), {});
  merge({part}, "merged");
  expect_same_results(path("whole"), path("merged"));
}

TEST_P(AnyKind, AFinishedPartIsTakenOverAlsoWithoutThePartFile) {
  run_study(study(), path("whole"), {});
  const auto part = parts(1)[0];
  std::filesystem::remove(part / "part.json");
  EXPECT_THAT(parts(1, {.reuse = {part}}), testing::SizeIs(1));
  EXPECT_THAT(run_study(study(), part, {.shard = {1, 1}, .reuse = {part}}).computed, testing::IsEmpty());
  merge({part}, "merged");
  expect_same_results(path("whole"), path("merged"));
}

TEST_P(AnyKind, PartsThatAreNotWholeAreNotMerged) {
  const auto part = parts(1)[0];
  const auto item = first_item(part.filename());
  const Json good = read_json(item);
  Json json = good;
  json["files"]["absent.h5"] = 5;
  write_file(item, json_text(json, -1));
  EXPECT_THAT(message_of([&] { merge({part}, "merged"); }),
              HasSubstr("absent.h5: is missing or has another size than its part says"));
  json = good;
  json["files"]["../absent.h5"] = 5;
  write_file(item, json_text(json, -1));
  EXPECT_THAT(message_of([&] { merge({part}, "merged"); }), HasSubstr("is no name of a file"));
  std::filesystem::remove_all(item.parent_path());
  EXPECT_THAT(message_of([&] { merge({part}, "merged"); }), HasSubstr("does not hold its item"));
  EXPECT_FALSE(std::filesystem::exists(path("merged")));
}

TEST_P(AnyKind, TakesNothingFromWhatIsReplacedMeanwhile) {
  run_study(study(), path("whole"), {});
  run_study(study(), path("again"), {});
  std::once_flag once;
  const auto replace = [&](const std::string&, double) {
    std::call_once(once, [&] {
      std::filesystem::rename(path("whole"), path("aside"));
      std::filesystem::rename(path("again"), path("whole"));
    });
  };
  EXPECT_THAT(message_of([&] {
                run_study(study(), path("results"),
                          {.threads = 1, .progress = replace, .reuse = {path("whole")}});
              }),
              HasSubstr("whole: was replaced while its results were used again"));
  EXPECT_THAT(message_of([&] { run_study(study(), path("results"), {.reuse = {path("nowhere")}}); }),
              HasSubstr("nowhere: is no folder whose results could be used again"));
}

TEST_P(EveryKind, TakesWhatDidNotChangeFromEarlierResults) {
  StudyFiles& study = files;
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

INSTANTIATE_TEST_SUITE_P(Kinds, EveryKind, testing::ValuesIn(kKinds),
                         [](const auto& kind) { return std::string(kind.param.name); });
INSTANTIATE_TEST_SUITE_P(Kinds, AnyKind, testing::Values(KindOfStudy{"recording", kRecording}),
                         [](const auto& kind) { return std::string(kind.param.name); });

TEST(Items, AFileThatWasThrownAwayIsMadeAgain) {
  StudyFiles study(kRecording);
  ASSERT_EQ(study.run("whole").code, 0);
  for (const char* file : {"timings.json", "simulator.json"}) {
    ASSERT_TRUE(std::filesystem::remove(study.folder / "whole" / file));
    ASSERT_EQ(study.run("whole").code, 0);
    EXPECT_TRUE(std::filesystem::exists(study.folder / "whole" / file));
  }
}

TEST(Items, ARecordingStudyThatTimesNothingIsLeftAloneWhenNothingChanged) {
  StudyFiles study(
      R"({"format": "trilat.study", "version": 1, "kind": "recording", "name": "tiny", "frames": 60,
      "sensors": 2, "runs": 2, "networks": [{"name": "quiet"}]})");
  ASSERT_EQ(study.run("whole").code, 0);
  EXPECT_FALSE(std::filesystem::exists(study.folder / "whole/timings.json"));
  const auto written = std::filesystem::last_write_time(study.folder / "whole/summary.json");
  ASSERT_EQ(study.run("whole").code, 0);
  EXPECT_EQ(std::filesystem::last_write_time(study.folder / "whole/summary.json"), written);
}

TEST(Items, AfterAFailureNoOtherIsBegun) {
  const ScratchFolder folder;
  std::atomic<int> begun{0};
  Study study{.kind = "toy", .work = "work", .reduce = {}};
  for (int i = 0; i < 100; ++i)
    study.items.push_back(
        {fmt::format("toys/{}", i), 1.0, [&, i](const std::filesystem::path&, const Watch&) {
           ++begun;
           if (i == 0) throw OutputError("disk", "is full");
           std::this_thread::sleep_for(std::chrono::milliseconds(5));
           return Json(i);
         }});
  EXPECT_THAT(message_of([&] {
                run_study(study, folder / "out", {.threads = 4, .shard = {1, 1}});
              }),
              HasSubstr("disk: is full"));
  EXPECT_LT(begun, 50);
}

TEST(Items, OfAnotherShardDoNotCountAsProgress) {
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
             .shard = {2, 2}});
  ASSERT_THAT(shares, testing::Not(testing::IsEmpty()));
  EXPECT_LT(*std::ranges::min_element(shares), 0.5);
  EXPECT_EQ(shares.back(), 1.0);
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

// Three recordings of half a second.
struct Simulated {
  ScratchFolder folder;

  void spec(int seed) {
    write_file(folder / "simulation.json",
               fmt::format(R"({{"format": "trilat.simulation", "version": 1, "name": "short", "seed": {},
                 "participants": 3, "activities": [{{"name": "walking", "duration_s": 0.5}}]}})",
                           seed));
  }
  Study study() const {
    const auto file = folder / "simulation.json";
    return campaign_study(read_simulation(file), hash_of_file(file), WatchedFiles({file}));
  }
  ItemTally part(const std::filesystem::path& output, const StudyOptions& options = {.shard = {1, 1}}) {
    return run_study(study(), output, options);
  }
  Ended program(const std::filesystem::path& output, const std::string& shard,
                std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"simulate", (folder / "simulation.json").string(), "-o", output.string(),
                               "--shard", shard, "--json"});
    return run_trilat(folder, more);
  }
};

TEST(SimulateParts, MergeToTheCampaignThatOneSimulationMakes) {
  Simulated simulated;
  simulated.spec(1);
  const std::filesystem::path& folder = simulated.folder.path();
  simulate_campaign(read_simulation(folder / "simulation.json"), folder / "whole", {});
  std::vector<std::filesystem::path> parts;
  for (std::uint64_t k = 1; k <= 3; ++k) {
    parts.push_back(folder / fmt::format("part{}", k));
    simulated.part(parts.back(), {.shard = {k, 3}});
  }
  const std::vector<FoundPart> found = read_parts(parts);
  merge_parts(campaign_of_parts(found[0].part.work, "part.json"), found, folder / "merged", {});
  expect_same_results(folder / "whole", folder / "merged");
}

TEST(SimulateParts, ADocumentThatIsReplacedMeanwhileIsRefused) {
  Simulated simulated;
  simulated.spec(1);
  const Study study = simulated.study();
  simulated.spec(22);
  EXPECT_THAT(message_of([&] {
                run_study(study, simulated.folder / "part", {.shard = {1, 1}});
              }),
              HasSubstr("simulation.json: changed while it was being evaluated; run again"));
  EXPECT_FALSE(std::filesystem::exists(simulated.folder / "part"));
}

TEST(SimulateParts, ASeedThatChangedAndChangedBackBetweenStopsLeavesNoOtherRecordings) {
  Simulated simulated;
  const auto part = simulated.folder / "part";
  const auto stop_in = [&](int seed, const char* recording) {
    simulated.spec(seed);
    const auto making = simulated.folder / "part.partial/aside/recordings" / recording;
    const auto is_begun = [=] { return std::filesystem::exists(making); };
    EXPECT_THROW(simulated.part(part, {.threads = 1, .stop_requested = is_begun, .shard = {1, 1}}),
                 Interrupted);
  };
  stop_in(1, "p03-walking");
  stop_in(2, "p02-walking");
  simulated.spec(1);
  simulated.part(part);
  simulated.part(simulated.folder / "at-once");
  expect_same_results(simulated.folder / "at-once", part);
}

TEST(SimulateParts, AFinishedPartIsKeptAndNothingElseReplacesIt) {
  Simulated simulated;
  simulated.spec(1);
  const auto part = simulated.folder / "part";
  ASSERT_EQ(simulated.program(part, "1/2").code, 0);
  const auto computed = [](const Ended& ended) {
    return parse_json(ended.out, "stdout").at("items_computed");
  };
  EXPECT_EQ(computed(simulated.program(part, "1/2")), 0);
  std::filesystem::remove(part / "part.json");
  EXPECT_EQ(computed(simulated.program(part, "1/2")), 0);
  std::filesystem::remove(part / "items/recordings/p01-walking/mocap.csv");
  EXPECT_EQ(computed(simulated.program(part, "1/2")), 1);
  const auto refused = [&](const std::string& shard) { return simulated.program(part, shard).err; };
  EXPECT_THAT(refused("2/2"), HasSubstr("recordings are never replaced"));
  simulated.spec(2);
  EXPECT_THAT(refused("1/2"), HasSubstr("recordings are never replaced"));
  write_file(simulated.folder / "study.json", kRecording);
  EXPECT_THAT(
      run_trilat(simulated.folder, {"run", (simulated.folder / "study.json").string(), "-o", part.string()})
          .err,
      HasSubstr("is not a results folder"));
  EXPECT_TRUE(std::filesystem::exists(part / "items/recordings/p01-walking/session.h5"));
  EXPECT_EQ(simulated.program(part, "1/2", {"--force"}).code, 0);
}

TEST(SimulateParts, AreNotMergedWithoutAllFilesOfTheirRecordings) {
  Simulated simulated;
  simulated.spec(1);
  const std::vector<std::filesystem::path> parts{simulated.folder / "part"};
  simulated.part(parts[0]);
  const auto said = [&] {
    return message_of([&] {
      const std::vector<FoundPart> found = read_parts(parts);
      merge_parts(campaign_of_parts(found[0].part.work, "part.json"), found, simulated.folder / "merged", {});
    });
  };
  const auto session = parts[0] / "items/recordings/p02-walking/session.h5";
  std::filesystem::rename(session, simulated.folder / "aside");
  EXPECT_THAT(said(), HasSubstr("p02-walking/session.h5: is missing or has another size"));
  std::filesystem::rename(simulated.folder / "aside", session);
  const Json good = read_json(parts[0] / "part.json");
  for (const Json& work : {Json::object(), Json::array(),
                           Json{{"simulation", 1}, {"sha256", ""}, {"recordings", Json::array()}}}) {
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

TEST(Items, OptionsThatWouldHaveNoEffectAreRefused) {
  StudyFiles study(kRecording);
  EXPECT_THAT(study.run("out", {"--dry-run", "--shard", "9/3"}).err, HasSubstr("--shard: is \"9/3\""));
}

}  // namespace
}  // namespace trilat
