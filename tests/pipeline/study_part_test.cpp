// SPDX-License-Identifier: MIT
#include "pipeline/study_part.h"

#include <array>
#include <fstream>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/calibration/calibration.h"
#include "datasets/results/samples.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/same_results.h"

namespace trilat {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr const char* kMethods = R"("occluded_apart": true, "resamples": 200, "block_s": 0.2,
    "alignments": ["mean", "none", "rigid", "first", "held_out", "joint_offset"], "methods": [
    {"method": "mean"}, {"method": "nonlinear"}, {"method": "geometric"}, {"method": "rts"}])";

// Takes of two activities; one cannot be evaluated.
struct Divided {
  ScratchFolder folder;
  Campaign campaign;
  StudySpec study = study_of(kMethods);

  explicit Divided(std::uint64_t participants = 4, bool one_fails = true) {
    SimulationSpec spec = walking_spec(participants);
    spec.activities.push_back(spec.activities[0]);
    spec.activities[1].activity = Activity::arm_swing;
    spec.activities[1].duration_s = 0.7;
    campaign = simulate_into(folder / "campaign", spec);
    if (one_fails) campaign.takes[1].mocap = folder / "campaign/absent.csv";
  }
  std::filesystem::path whole(ExecuteOptions options = {}) {
    execute_study(study, campaign, folder / "whole", options);
    return folder / "whole";
  }
  std::vector<std::filesystem::path> parts(std::uint64_t of, ExecuteOptions options = {}) {
    std::vector<std::filesystem::path> names;
    for (std::uint64_t k = 1; k <= of; ++k) {
      names.push_back(folder / fmt::format("part{}of{}", k, of));
      run_study_part(study, campaign, {k, of}, names.back(), options);
    }
    return names;
  }
  std::filesystem::path merged(const std::vector<std::filesystem::path>& parts) {
    const std::filesystem::path output = folder / fmt::format("merged{}", parts.size());
    merge_study(read_parts(parts), output, {});
    return output;
  }
};

TEST(StudyPart, AnyNumberOfShardsMergesToTheBytesOfOneRun) {
  Divided work;
  const auto whole = work.whole({.cross_check = true});
  for (const std::uint64_t shards : {1u, 2u, 7u, 64u})
    expect_same_results(whole, work.merged(work.parts(shards, {.cross_check = true})));
}

TEST(StudyPart, MergedInHardlyAnyMemoryTheBytesAreTheSame) {
  Divided work(2);
  const auto whole = work.whole(), output = work.folder / "merged";
  const auto parts = work.parts(2);
  merge_study(read_parts(parts), output, {.memory_bytes = 0});
  expect_same_results(whole, output);
}

TEST(StudyPart, EveryTakeIsInExactlyOneShardAndTheSharesAreBalanced) {
  Divided work(6, false);
  const Plan plan = make_plan(work.study, work.campaign);
  std::array<double, 3> load{};
  double all = 0.0;
  for (const PartItem& item : part_items(plan, 3)) {
    load.at(item.shard - 1) += item.cost;
    all += item.cost;
  }
  for (const double cost : load) EXPECT_NEAR(cost / all, 1.0 / 3.0, 0.06);
}

TEST(StudyPart, AShardThatWasStoppedGoesOnAndEndsWithTheSameBytes) {
  Divided work;
  const auto whole = work.whole();
  const auto part = [&](std::uint64_t k) { return work.folder / fmt::format("p{}", k); };
  run_study_part(work.study, work.campaign, {1, 2}, part(1), {.threads = 1});
  const auto journal = work.folder / "p2.partial/items.jsonl";
  const auto one_is_done = [&] {
    return std::filesystem::exists(journal) && std::filesystem::file_size(journal) > 0;
  };
  EXPECT_THROW(run_study_part(work.study, work.campaign, {2, 2}, part(2),
                              {.threads = 1, .stop_requested = one_is_done}),
               Interrupted);
  EXPECT_FALSE(std::filesystem::exists(part(2)));
  const StudyPart rest = run_study_part(work.study, work.campaign, {2, 2}, part(2), {});
  EXPECT_GT(rest.tally.continued.size(), 0u);
  EXPECT_GT(rest.tally.computed.size(), 0u);
  expect_same_results(whole, work.merged(std::vector{part(1), part(2)}));
}

TEST(StudyPart, AFinishedPartIsTakenOverByTheSameShard) {
  Divided work;
  const auto whole = work.whole();
  const auto parts = work.parts(2);
  const StudyPart again = run_study_part(work.study, work.campaign, {1, 2}, parts[0], {.reuse = {parts[0]}});
  EXPECT_GT(again.tally.reused.size(), 0u);
  EXPECT_THAT(again.tally.computed, IsEmpty());
  expect_same_results(whole, work.merged(parts));
}

TEST(StudyPart, ATakeThatFailedIsNamed) {
  Divided work;
  const StudyPart part = run_study_part(work.study, work.campaign, {1, 1}, work.folder / "part", {});
  EXPECT_EQ(part.failed, 1u);
  const auto failed =
      std::find_if(part.notes.begin(), part.notes.end(), [](const TakeNote& note) { return note.failed; });
  ASSERT_NE(failed, part.notes.end());
  EXPECT_EQ(failed->take, work.campaign.takes[1].id);
}

TEST(StudyPart, MergingSaysWhatIsMissing) {
  Divided work;
  const auto parts = work.parts(3);
  EXPECT_THAT(message_of([&] {
                read_parts(std::array{parts[0], parts[2]});
              }),
              AllOf(HasSubstr("missing: shard 2/3"), HasSubstr("p0")));
  std::filesystem::rename(parts[1], parts[1].string() + ".partial");
  EXPECT_THAT(message_of([&] { read_parts(parts); }), HasSubstr("is not finished yet"));
}

TEST(StudyPart, MergingRefusesWhatDoesNotBelongTogether) {
  Divided work;
  const auto parts = work.parts(2);
  EXPECT_THAT(message_of([&] {
                read_parts(std::array{parts[0], parts[0]});
              }),
              HasSubstr("is shard 1/2, which"));
  work.study.rate_hz = 20.0;
  run_study_part(work.study, work.campaign, {2, 2}, work.folder / "other", {});
  EXPECT_THAT(
      message_of([&] {
        read_parts(std::array{parts[0], work.folder / "other"});
      }),
      AllOf(HasSubstr("does not belong to"), HasSubstr("/study/rate_hz is 30.0 in the first and 20.0 here")));
  run_study_part(work.study, work.campaign, {1, 3}, work.folder / "third", {});
  EXPECT_THAT(message_of([&] {
                read_parts(std::array{parts[0], work.folder / "third"});
              }),
              HasSubstr("it is shard 1/3, the first is 1/2"));
}

TEST(StudyPart, MergingRefusesShardsThatReadOtherFilesAndNamesTheTake) {
  Divided work(2, false);
  run_study_part(work.study, work.campaign, {1, 2}, work.folder / "part", {});
  const std::string id = work.campaign.takes[0].id;
  const auto said = [&] {
    run_study_part(work.study, work.campaign, {2, 2}, work.folder / "other", {});
    return message_of([&] { read_parts(std::array{work.folder / "part", work.folder / "other"}); });
  };
  EXPECT_EQ(said(), "no error");
  const Campaign before = work.campaign;
  const auto moved = work.folder / "moved.json";
  Calibration calibration = read_calibration(before.takes[0].calibration);
  calibration.sensors[0].world_from_sensor.translation_m.x() += 0.01;
  write_calibration(moved, calibration);
  work.campaign.takes[0].calibration = moved;
  EXPECT_THAT(said(), HasSubstr("/inputs/" + id +
                                "/calibration/file is \"calibration.json\" in the first and "
                                "\"moved.json\" here"));
  work.campaign = before;
  std::ofstream(before.takes[0].mocap, std::ios::app) << "\n";
  EXPECT_THAT(said(), HasSubstr("/inputs/" + id + "/mocap/bytes is "));
  std::filesystem::resize_file(before.takes[0].mocap, std::filesystem::file_size(before.takes[0].mocap) - 1);
  EXPECT_EQ(said(), "no error");
  write_calibration(before.takes[0].calibration, calibration);
  EXPECT_THAT(said(), HasSubstr("/inputs/" + id + "/calibration/sha256 is "));
}

TEST(StudyPart, EveryKindOfMethodMergesToTheBytesOfOneRun) {
  Divided work(1, false);
  work.study = study_of(R"("resamples": 0, "methods": [{"method": "linear"}, {"method": "newton"},
      {"method": "ceres"}, {"method": "tracked_mean"}, {"method": "single", "sensors": ["k1"]},
      {"method": "weighted_mean", "occlusion": "corrected"}, {"method": "median"}, {"method": "robust_mean"},
      {"method": "kalman"}, {"method": "window"}])");
  expect_same_results(work.whole(), work.merged(work.parts(2)));
}

TEST(StudyPart, APartThatWasWrittenByHandIsRefusedAtItsPlace) {
  Divided work(1, false);
  const auto parts = work.parts(1);
  const Json good = read_json(parts[0] / "part.json");
  const auto said = [&](const char* pointer, const Json& value) {
    Json json = good;
    if (value.is_discarded())
      json["work"].erase(pointer);
    else
      json["work"][pointer] = value;
    write_file(parts[0] / "part.json", json_text(json, 1));
    return message_of([&] { work.merged(parts); });
  };
  EXPECT_THAT(said("cross_check", Json(Json::value_t::discarded)),
              HasSubstr("part.json /work/cross_check: is missing"));
  EXPECT_THAT(said("cross_check", 1), HasSubstr("part.json /work/cross_check"));
  EXPECT_THAT(said("takes", Json::array()), HasSubstr("/work/takes: must be the items"));
}

TEST(StudyPart, ASamplesFileThatIsCutIsAnErrorAndNoResult) {
  Divided work;
  const auto parts = work.parts(2);
  const std::string id = read_items(parts[0]).items.front().id;
  std::filesystem::resize_file(parts[0] / "takes" / id / "samples.h5", 1000);
  EXPECT_THAT(message_of([&] { work.merged(parts); }), HasSubstr(id));
  EXPECT_FALSE(std::filesystem::exists(work.folder / "merged2"));
}

TEST(Reuse, OnlyTheNewTakeOfACampaignIsComputed) {
  Divided work(4, false);
  Campaign fewer = work.campaign;
  fewer.takes.pop_back();
  execute_study(work.study, fewer, work.folder / "yesterday", {});
  const StudyRun run =
      run_study(work.study, work.campaign, work.folder / "today", {.reuse = {work.folder / "yesterday"}});
  EXPECT_THAT(run.takes.computed, ElementsAre(work.campaign.takes.back().id));
  EXPECT_THAT(run.takes.reused, SizeIs(fewer.takes.size()));
  expect_same_results(work.whole(), work.folder / "today");
}

TEST(Reuse, ATakeWhoseFileOrSettingsChangedIsComputed) {
  Divided work(3, false);
  work.whole();
  const ExecuteOptions reuse{.reuse = {work.folder / "whole"}};
  Campaign moved = work.campaign;
  moved.takes[2].mocap_start_host_ns += 1'000'000;
  EXPECT_THAT(run_study(work.study, moved, work.folder / "a", reuse).takes.computed,
              ElementsAre(moved.takes[2].id));
  std::ofstream(work.campaign.takes[0].mocap, std::ios::app) << "\n";
  EXPECT_THAT(run_study(work.study, work.campaign, work.folder / "b", reuse).takes.computed,
              ElementsAre(work.campaign.takes[0].id));
  work.study.sensor_gap_s = 0.2;
  EXPECT_THAT(run_study(work.study, work.campaign, work.folder / "c", reuse).takes.reused, IsEmpty());
}

TEST(Reuse, SettingsOfTheSummaryCostNoTakeAndChangeWhatTheyShould) {
  Divided work(3, false);
  work.whole();
  const auto changed = [&](const char* members) {
    const StudySpec study = study_of(members);
    const StudyRun run =
        run_study(study, work.campaign, work.folder / "again", {.reuse = {work.folder / "whole"}});
    EXPECT_THAT(run.takes.computed, IsEmpty()) << members;
    execute_study(study, work.campaign, work.folder / "fresh", {});
    expect_same_results(work.folder / "fresh", work.folder / "again");
  };
  const std::string methods = R"("methods": [
      {"method": "mean"}, {"method": "nonlinear"}, {"method": "geometric"}, {"method": "rts"}])";
  changed((R"("alignments": ["held_out"], "training_share": 0.3, "resamples": 300, "reference": "rts", )" +
           methods)
              .c_str());
  changed((R"("alignments": ["rigid"], "block_s": 0.5, "clock_error_s": 0.01, )" + methods).c_str());
}

TEST(Reuse, NothingIsTouchedWhenNothingChanged) {
  Divided work(2, false);
  const auto whole = work.whole();
  const auto before = std::filesystem::last_write_time(whole / "summary.json");
  const StudyRun run = run_study(work.study, work.campaign, whole, {.reuse = {whole}});
  EXPECT_TRUE(run.unchanged);
  EXPECT_THAT(run.takes.reused, SizeIs(4));
  EXPECT_EQ(run.summary.takes, 4u);
  EXPECT_EQ(std::filesystem::last_write_time(whole / "summary.json"), before);
  std::ofstream(work.campaign.takes[0].mocap, std::ios::app) << "\n";
  EXPECT_FALSE(run_study(work.study, work.campaign, whole, {.reuse = {whole}}).unchanged);
}

TEST(Reuse, WhatWasThrownAwayIsComputedAgain) {
  Divided work(1, false);
  const auto whole = work.whole();
  std::filesystem::remove(whole / "samples.h5");
  const StudyRun run = run_study(work.study, work.campaign, whole, {.reuse = {whole}});
  EXPECT_FALSE(run.unchanged);
  EXPECT_THAT(run.takes.reused, IsEmpty());
  EXPECT_TRUE(std::filesystem::exists(whole / "samples.h5"));
}

TEST(Reuse, AReplayThatWasThrownAwayIsMadeAgain) {
  Divided work(1, false);
  const auto whole = work.whole();
  work.study.name = "another";  // of the summary alone
  const auto fresh = work.folder / "fresh";
  execute_study(work.study, work.campaign, fresh, {});
  std::filesystem::remove(whole / "replay.h5");
  run_study(work.study, work.campaign, work.folder / "results", {.reuse = {whole}});
  expect_same_results(fresh, work.folder / "results");
  std::filesystem::remove(fresh / "replay.h5");
  EXPECT_FALSE(run_study(work.study, work.campaign, fresh, {.reuse = {fresh}}).unchanged);
  EXPECT_TRUE(std::filesystem::exists(fresh / "replay.h5"));
}

TEST(Reuse, WhatCouldNotBeRemovedAtTheEndIsRemovedByTheNextRun) {
  Divided work(1, false);
  const auto whole = work.whole();
  const auto results = work.folder / "results";
  std::filesystem::copy(whole, results);
  const StudyPart part = run_study_part(work.study, work.campaign, {1, 1}, work.folder / "part", {});
  std::filesystem::rename(work.folder / "part/takes", results / "takes");
  write_file(results / ItemJournal::kFile, "");
  EXPECT_THAT(run_study(work.study, work.campaign, results, {.reuse = {results}}).takes.reused,
              SizeIs(part.takes));
  expect_same_results(whole, results);
}

TEST(Reuse, TheOneFileThatAWorkflowEngineRemovesIsMadeAgainFromTheOthers) {
  Divided work(2, false);
  const auto whole = work.whole();
  std::filesystem::copy(whole, work.folder / "results");
  std::filesystem::remove(work.folder / "results/manifest.json");
  const StudyRun run =
      run_study(work.study, work.campaign, work.folder / "results", {.reuse = {work.folder / "results"}});
  EXPECT_THAT(run.takes.computed, IsEmpty());
  expect_same_results(whole, work.folder / "results");
  const auto parts = work.parts(2);
  std::filesystem::remove(parts[0] / "part.json");
  const StudyPart part = run_study_part(work.study, work.campaign, {1, 2}, parts[0], {.reuse = {parts[0]}});
  EXPECT_THAT(part.tally.computed, IsEmpty());
  expect_same_results(whole, work.merged(parts));
}

TEST(Reuse, AFileThatIsReplacedDuringTheRunFailsItsTakesInsteadOfGivingThemItsHash) {
  Divided work(1, false);
  const auto file = work.campaign.takes[0].calibration;
  std::once_flag once;
  const auto replace = [&] {
    std::call_once(once, [&] {
      Calibration calibration = read_calibration(file);
      calibration.sensors[0].world_from_sensor.translation_m.x() += 0.1;
      write_calibration(file, calibration);
    });
    return false;
  };
  const StudyRun run = run_study(work.study, work.campaign, work.folder / "results",
                                 {.threads = 1, .stop_requested = replace});
  EXPECT_EQ(run.summary.takes_failed, run.summary.takes);
  ASSERT_THAT(run.summary.notes, Not(IsEmpty()));
  EXPECT_THAT(run.summary.notes[0].text, HasSubstr("changed while the take was evaluated"));
  EXPECT_THAT(run.takes.computed, IsEmpty());
}

TEST(Reuse, EarlierResultsThatAreReplacedMeanwhileAreNotTakenForThoseThatWereFound) {
  Divided work(1, false);
  const auto whole = work.whole();
  StudySpec other = study_of(R"("methods": [{"method": "mean"}, {"method": "nonlinear", "max_iterations": 1},
      {"method": "geometric"}, {"method": "rts"}])");
  execute_study(other, work.campaign, work.folder / "other", {});
  work.study.name = "another";
  std::once_flag once;
  const auto replace = [&](double) {
    std::call_once(once, [&] {
      std::filesystem::rename(whole, work.folder / "aside");
      std::filesystem::rename(work.folder / "other", whole);
    });
  };
  EXPECT_THAT(message_of([&] {
                run_study(work.study, work.campaign, work.folder / "results",
                          {.threads = 1, .progress = replace, .reuse = {whole}});
              }),
              HasSubstr("whole: was replaced while its results were used again"));
  EXPECT_FALSE(std::filesystem::exists(work.folder / "results"));
}

TEST(StudyPart, APartThatNamesAnItemOutsideItselfOrOfNoShardIsRefused) {
  const ScratchFolder folder;
  const auto said = [&](PartItem item) {
    write_part(folder.path(), {"campaign", "build", 1, 2, Json::object(), {std::move(item)}});
    return message_of([&] { read_part(folder.path()); });
  };
  EXPECT_THAT(said({"../../secret", 1.0, 1}), HasSubstr("/items/0/id: is no name of an item"));
  EXPECT_THAT(said({"rigs//run-1", 1.0, 1}), HasSubstr("/items/0/id: is no name of an item"));
  EXPECT_EQ(said({"rigs/walk..1", 1.0, 1}), "no error");
  EXPECT_THAT(said({"/etc", 1.0, 1}), HasSubstr("/items/0/id: is no name of an item"));
  EXPECT_THAT(said({"p01-walking", 1.0, 3}), HasSubstr("/items/0/shard: must be 1 to the number of shards"));
  EXPECT_THAT(said({"p01-walking", 1.0, 0}), HasSubstr("/items/0/shard: must be 1 to the number of shards"));
}

TEST(Reuse, WhatFailedIsTriedAgain) {
  Divided work;
  const auto whole = work.whole();
  const StudyRun again = run_study(work.study, work.campaign, whole, {.reuse = {whole}});
  EXPECT_FALSE(again.unchanged);
  EXPECT_EQ(again.summary.takes_failed, 1u);
  EXPECT_THAT(again.takes.reused, SizeIs(7));
}

TEST(Reuse, ARunThatWasKilledGoesOn) {
  Divided work(4, false);
  write_campaign(work.folder / "campaign", work.campaign);
  write_file(work.folder / "study.json", json_text(resolved_json(work.study), 1));
  const auto command = [&](const char* output) {
    return std::vector<std::string>{
        "run",   (work.folder / "study.json").string(), "--campaign", (work.folder / "campaign").string(),
        "-o",    (work.folder / output).string(),       "--threads",  "1",
        "--json"};
  };
  const Process killed(work.folder, command("results"));
  const std::filesystem::path journal = work.folder / "results.partial/items.jsonl";
  while (!std::filesystem::exists(journal) || std::filesystem::file_size(journal) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  killed.kill_at_once();
  killed.wait();
  const Ended ended = run_trilat(work.folder, command("results"));
  EXPECT_EQ(ended.code, 0) << ended.err;
  const Json said = parse_json(ended.out, "stdout");
  EXPECT_GT(said.at("items_continued").get<int>(), 0);
  run_trilat(work.folder, command("whole"));
  expect_same_results(work.folder / "whole", work.folder / "results");
}

TEST(Reuse, SettingsThatChangedAndChangedBackBetweenStopsLeaveNoSamplesOfTheOthers) {
  Divided work(2, false);
  const auto whole = work.whole();
  const auto output = work.folder / "results";
  const auto stop_in_take = [&](const StudySpec& study, std::size_t take) {
    const auto folder = work.folder / "results.partial/takes" / work.campaign.takes[take].id;
    std::filesystem::remove_all(folder);
    const auto is_begun = [=] { return std::filesystem::exists(folder / "samples.h5"); };
    EXPECT_THROW(run_study(study, work.campaign, output, {.threads = 1, .stop_requested = is_begun}),
                 Interrupted);
  };
  stop_in_take(work.study, 3);
  stop_in_take(study_of(R"("methods": [{"method": "mean"}, {"method": "nonlinear", "max_iterations": 1},
      {"method": "geometric"}, {"method": "rts"}])"),
               2);  // which has no replay that would be missed
  EXPECT_THAT(run_study(work.study, work.campaign, output, {}).takes.computed, SizeIs(4));
  expect_same_results(whole, output);
}

TEST(Reuse, TwoRunsCannotFillOneFolder) {
  Divided work(2, false);
  bool refused = false;
  execute_study(work.study, work.campaign, work.folder / "results", {.stop_requested = [&] {
                  static std::once_flag once;
                  std::call_once(once, [&] {
                    refused = message_of([&] {
                                execute_study(work.study, work.campaign, work.folder / "results", {});
                              }).find("is being written by another process") != std::string::npos;
                  });
                  return false;
                }});
  EXPECT_TRUE(refused);
  EXPECT_FALSE(std::filesystem::exists(work.folder / "results.partial.lock"));
}

}  // namespace
}  // namespace trilat
