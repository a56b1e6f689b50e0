// SPDX-License-Identifier: MIT
#include <atomic>
#include <fstream>
#include <functional>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/calibration/calibration.h"
#include "tests/pipeline/divided.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/same_results.h"

namespace trilat {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST(Reuse, OnlyTheNewTakeOfACampaignIsComputed) {
  Divided work(4, false);
  Campaign fewer = work.campaign;
  fewer.takes.pop_back();
  execute_study(work.study, fewer, work.folder / "yesterday", {});
  const AccuracyRun again =
      run(work.study, work.campaign, work.folder / "today", {.reuse = {work.folder / "yesterday"}});
  EXPECT_THAT(again.tally.computed, ElementsAre(item_of(work.campaign.takes.back())));
  EXPECT_THAT(again.tally.reused, SizeIs(fewer.takes.size()));
  expect_same_results(work.whole(), work.folder / "today");
}

TEST(Reuse, ATakeWhoseFileOrSettingsChangedIsComputed) {
  Divided work(3, false);
  work.whole();
  const ExecuteOptions reuse{.reuse = {work.folder / "whole"}};
  Campaign moved = work.campaign;
  moved.takes[2].mocap_start_host_ns += 1'000'000;
  EXPECT_THAT(run(work.study, moved, work.folder / "a", reuse).tally.computed,
              ElementsAre(item_of(moved.takes[2])));
  std::ofstream(work.campaign.takes[0].mocap, std::ios::app) << "\n";
  EXPECT_THAT(run(work.study, work.campaign, work.folder / "b", reuse).tally.computed,
              ElementsAre(item_of(work.campaign.takes[0])));
  const ExecuteOptions checked{.cross_check = true, .reuse = reuse.reuse};
  EXPECT_THAT(run(work.study, work.campaign, work.folder / "checked", checked).tally.reused, IsEmpty());
  work.study.sensor_gap_s = 0.2;
  EXPECT_THAT(run(work.study, work.campaign, work.folder / "c", reuse).tally.reused, IsEmpty());
}

// A field that is added to Take stops the binding in planned_work.cpp, and is then changed here.
TEST(Reuse, EveryFieldOfATakeAndOfTheCampaignIsInTheKey) {
  Divided work(1, false);
  const auto copied = [&](const std::filesystem::path& file) {
    const std::filesystem::path copy = work.folder / ("other_" + file.filename().string());
    write_file(copy, read_file(file) + "\n");
    return copy;
  };
  const std::pair<const char*, std::function<void(Campaign&)>> changes[] = {
      {"name", [](Campaign& c) { c.name += "x"; }},
      {"simulated", [](Campaign& c) { c.simulated = !c.simulated; }},
      {"id", [](Campaign& c) { c.takes[0].id += "x"; }},
      {"participant", [](Campaign& c) { c.takes[0].participant += "x"; }},
      {"activity", [](Campaign& c) { c.takes[0].activity += "x"; }},
      {"session", [&](Campaign& c) { c.takes[0].session = copied(c.takes[0].session); }},
      {"calibration", [&](Campaign& c) { c.takes[0].calibration = copied(c.takes[0].calibration); }},
      {"mocap", [&](Campaign& c) { c.takes[0].mocap = copied(c.takes[0].mocap); }},
      {"mapping", [&](Campaign& c) { c.takes[0].mapping = copied(c.takes[0].mapping); }},
      {"mocap_start_host_ns", [](Campaign& c) { ++c.takes[0].mocap_start_host_ns; }},
      {"up_axis", [](Campaign& c) { c.takes[0].up_axis = UpAxis::z; }},
      {"left_out", [](Campaign& c) { c.takes[0].left_out = "k1"; }}};
  const auto key_of = [&](const Campaign& campaign) {
    HashCache hashes;
    return key_of_results(work.study, campaign, false, hashes, {});
  };
  const std::string key = key_of(work.campaign);
  EXPECT_EQ(key_of(work.campaign), key);
  for (const auto& [field, change] : changes) {
    Campaign campaign = work.campaign;
    change(campaign);
    EXPECT_NE(key_of(campaign), key) << field;
  }
}

TEST(Reuse, ATakeWhoseUpAxisIsStatedAnewIsComputed) {
  Divided work(2, false);
  work.whole();
  Campaign turned = work.campaign;
  turned.takes[1].up_axis = UpAxis::automatic;
  EXPECT_THAT(run(work.study, turned, work.folder / "a", {.reuse = {work.folder / "whole"}}).tally.computed,
              ElementsAre(item_of(turned.takes[1])));
}

TEST(Reuse, SettingsOfTheSummaryCostNoTakeAndChangeWhatTheyShould) {
  Divided work(3, false);
  work.whole();
  const auto changed = [&](const char* members) {
    const StudySpec study = study_of(members);
    const AccuracyRun again =
        run(study, work.campaign, work.folder / "again", {.reuse = {work.folder / "whole"}});
    EXPECT_THAT(again.tally.computed, IsEmpty()) << members;
    execute_study(study, work.campaign, work.folder / "fresh", {});
    expect_same_results(work.folder / "fresh", work.folder / "again");
  };
  const std::string methods = R"("methods": [
      {"method": "mean"}, {"method": "nonlinear"}, {"method": "geometric"}, {"method": "rts"}])";
  changed((R"("alignments": ["held_out"], "training_share": 0.3, "resamples": 300, "reference": "rts", )" +
           methods)
              .c_str());
  changed((R"("alignments": ["rigid", "none"], "block_s": 0.5, )" + methods).c_str());
  changed((R"("occluded_apart": false, "cross_check_limit_m": 0.5, )" + methods).c_str());
}

TEST(Reuse, WhatDecidesTheClockDecidesTheTake) {
  Divided work(3, false);
  work.whole();
  const std::string methods = R"("methods": [{"method": "mean"}], )";
  const auto computed = [&](const std::string& members, const std::filesystem::path& earlier) {
    return run(study_of(methods + members), work.campaign, work.folder / "again", {.reuse = {earlier}})
        .tally.computed.size();
  };
  execute_study(study_of(methods + R"("alignments": ["rigid"])"), work.campaign, work.folder / "shapes", {});
  EXPECT_EQ(computed(R"("alignments": ["rigid"], "clock_error_s": 0.01)", work.folder / "shapes"),
            work.campaign.takes.size());
  EXPECT_EQ(computed(R"("alignments": ["rigid", "none"])", work.folder / "shapes"),
            work.campaign.takes.size());
  EXPECT_EQ(computed(R"("alignments": ["rigid"], "resamples": 300)", work.folder / "shapes"), 0u);
}

TEST(Reuse, ResultsThatAreDamagedAreMadeAgain) {
  Divided work(2, false);
  const auto whole = work.whole(), results = work.folder / "results";
  for (const char* file : {"samples.h5", "replay.h5", "items.json", "hashes.json", "summary.json"})
    for (const char* name : {"", "another"}) {
      std::filesystem::remove_all(results);
      std::filesystem::copy(whole, results);
      std::filesystem::resize_file(results / file, std::filesystem::file_size(results / file) / 2);
      StudySpec study = work.study;
      if (*name) study.name = name;
      EXPECT_EQ(run(study, work.campaign, results, {.reuse = {results}}).tally.unchanged,
                !*name && file == std::string("hashes.json"))
          << file;
      if (!*name) expect_same_results(whole, results);
    }
}

TEST(Reuse, APartHoldsNoItemsOfAnEarlierShard) {
  Divided work(2, false);
  const auto part = work.folder / "part";
  work.part({1, 1}, work.folder / "all");
  make_folder(part.string() + ".partial");
  std::filesystem::rename(work.folder / "all" / kItemsFolder, partial_name(part) / kItemsFolder);
  const ItemTally tally = work.part({1, 2}, part);
  std::size_t items = 0;
  for (const auto& entry : std::filesystem::directory_iterator(part / kItemsFolder / "takes"))
    items += entry.is_directory();
  EXPECT_EQ(items, tally.all());
  EXPECT_LT(items, work.campaign.takes.size());
}

TEST(Reuse, NothingIsTouchedWhenNothingChanged) {
  Divided work(2, false);
  const auto whole = work.whole();
  const auto before = std::filesystem::last_write_time(whole / "summary.json");
  const AccuracyRun again = run(work.study, work.campaign, whole, {.reuse = {whole}});
  EXPECT_TRUE(again.tally.unchanged);
  EXPECT_THAT(again.tally.reused, SizeIs(4));
  EXPECT_EQ(again.summary.takes, 4u);
  EXPECT_EQ(std::filesystem::last_write_time(whole / "summary.json"), before);
  std::ofstream(work.campaign.takes[0].mocap, std::ios::app) << "\n";
  EXPECT_FALSE(run(work.study, work.campaign, whole, {.reuse = {whole}}).tally.unchanged);
}

TEST(Reuse, WhatWasThrownAwayIsComputedAgain) {
  Divided work(1, false);
  const auto whole = work.whole();
  std::filesystem::remove(whole / "samples.h5");
  const AccuracyRun again = run(work.study, work.campaign, whole, {.reuse = {whole}});
  EXPECT_FALSE(again.tally.unchanged);
  EXPECT_THAT(again.tally.reused, IsEmpty());
  EXPECT_TRUE(std::filesystem::exists(whole / "samples.h5"));
}

TEST(Reuse, AReplayThatWasThrownAwayIsMadeAgain) {
  Divided work(1, false);
  const auto whole = work.whole();
  work.study.name = "another";  // of the summary alone
  const auto fresh = work.folder / "fresh";
  execute_study(work.study, work.campaign, fresh, {});
  std::filesystem::remove(whole / "replay.h5");
  run(work.study, work.campaign, work.folder / "results", {.reuse = {whole}});
  expect_same_results(fresh, work.folder / "results");
  std::filesystem::remove(fresh / "replay.h5");
  EXPECT_FALSE(run(work.study, work.campaign, fresh, {.reuse = {fresh}}).tally.unchanged);
  EXPECT_TRUE(std::filesystem::exists(fresh / "replay.h5"));
}

TEST(Reuse, WhatCouldNotBeRemovedAtTheEndIsRemovedByTheNextRun) {
  Divided work(1, false);
  const auto whole = work.whole();
  const auto results = work.folder / "results";
  std::filesystem::copy(whole, results);
  work.part({1, 1}, work.folder / "part");
  std::filesystem::rename(work.folder / "part" / kItemsFolder, results / kItemsFolder);
  EXPECT_THAT(run(work.study, work.campaign, results, {.reuse = {results}}).tally.reused,
              SizeIs(work.campaign.takes.size()));
  expect_same_results(whole, results);
}

TEST(Reuse, TheOneFileThatAWorkflowEngineRemovesIsMadeAgainFromTheOthers) {
  Divided work(2, false);
  const auto whole = work.whole();
  std::filesystem::copy(whole, work.folder / "results");
  std::filesystem::remove(work.folder / "results/manifest.json");
  const AccuracyRun again =
      run(work.study, work.campaign, work.folder / "results", {.reuse = {work.folder / "results"}});
  EXPECT_THAT(again.tally.computed, IsEmpty());
  expect_same_results(whole, work.folder / "results");
  const auto parts = work.parts(2);
  std::filesystem::remove(parts[0] / "part.json");
  EXPECT_THAT(work.part({1, 2}, parts[0], {.reuse = {parts[0]}}).computed, IsEmpty());
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
  const AccuracyRun again =
      run(work.study, work.campaign, work.folder / "results", {.threads = 1, .stop_requested = replace});
  EXPECT_EQ(again.summary.takes_failed, again.summary.takes);
  ASSERT_THAT(again.summary.notes, Not(IsEmpty()));
  EXPECT_THAT(again.summary.notes[0].text, HasSubstr("changed while it was being evaluated"));
  EXPECT_THAT(again.tally.computed, IsEmpty());
}

TEST(Reuse, WhatFailedIsTriedAgain) {
  Divided work;
  const auto whole = work.whole();
  const AccuracyRun again = run(work.study, work.campaign, whole, {.reuse = {whole}});
  EXPECT_FALSE(again.tally.unchanged);
  EXPECT_EQ(again.summary.takes_failed, 1u);
  EXPECT_THAT(again.tally.reused, SizeIs(7));
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
  while (!finished_items(work.folder / "results.partial"))
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
    const auto folder = work.folder / "results.partial/aside" / item_of(work.campaign.takes[take]);
    const auto is_begun = [=] { return std::filesystem::exists(folder / "samples.h5"); };
    EXPECT_THROW(run(study, work.campaign, output, {.threads = 1, .stop_requested = is_begun}), Interrupted);
  };
  stop_in_take(work.study, 3);
  stop_in_take(study_of(R"("methods": [{"method": "mean"}, {"method": "nonlinear", "max_iterations": 1},
      {"method": "geometric"}, {"method": "rts"}])"),
               2);  // which has no replay that would be missed
  EXPECT_THAT(run(work.study, work.campaign, output, {}).tally.computed, SizeIs(4));
  expect_same_results(whole, output);
}

TEST(Reuse, TwoRunsCannotFillOneFolder) {
  Divided work(2, false);
  bool refused = false;
  execute_study(work.study, work.campaign, work.folder / "results", {.stop_requested = [&] {
                  static std::once_flag once;
                  if (std::filesystem::exists(work.folder / "results.partial.lock"))
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

// Left by a stop between putting in place and tidying up, they would be taken for those that the key is of.
TEST(Reuse, SamplesOfOtherSettingsDoNotStayBesideATakeThatIsTakenOver) {
  Divided work(1, false);
  const auto whole = work.whole();
  const auto unfinished = work.folder / "results.partial" / kItemsFolder;
  const StudySpec other = study_of(R"("methods": [{"method": "nonlinear", "max_iterations": 1}])");
  run_accuracy(other, work.campaign, work.folder / "part", {.shard = {1, 1}});
  std::filesystem::create_directories(unfinished.parent_path());
  std::filesystem::rename(work.folder / "part" / kItemsFolder, unfinished);
  work.study.name = "another";
  std::atomic<double> done = 0.0;
  EXPECT_THROW(run(work.study, work.campaign, work.folder / "results",
                   {.threads = 1,
                    .stop_requested = [&] { return done > 0.79; },
                    .progress = [&](double share) { done = share; },
                    .reuse = {whole}}),
               Interrupted);
  for (const Take& take : work.campaign.takes)
    EXPECT_FALSE(std::filesystem::exists(unfinished / item_of(take))) << take.id;
}

// A calibration that lies elsewhere, however it is named, and whatever the campaign's folder is called.
TEST(Reuse, ATakeThatIsTakenOverNamesNoOtherRunsFolder) {
  Divided work(1, false);
  work.study = study_of(R"("alignments": ["rigid"], "methods": [{"method": "mean"}])");
  Calibration calibration = read_calibration(work.campaign.takes[0].calibration);
  calibration.world = "sensor k1";
  const auto take_over = [&](const std::filesystem::path& place, const char* output,
                             const ExecuteOptions& options) {
    std::filesystem::create_directories(place);
    write_calibration(place / "calibration.json", calibration);
    for (Take& take : work.campaign.takes) take.calibration = place / "calibration.json";
    return trilat::run(work.study, work.campaign, work.folder / output, options);
  };
  const AccuracyRun first = take_over(work.folder / "here", "first", {});
  ASSERT_THAT(first.summary.notes, Not(IsEmpty()));
  EXPECT_EQ(first.summary.notes[0].place, "calibration.json");
  take_over(work.folder / "there", "fresh", {});
  int runs = 0;
  for (const auto& place :
       {work.folder / "there", work.folder / "acampaign", work.folder / "campaign/../there",
        std::filesystem::relative(work.folder / "there")}) {
    const std::string output = fmt::format("again{}", ++runs);
    EXPECT_THAT(take_over(place, output.c_str(), {.reuse = {work.folder / "first"}}).tally.computed,
                IsEmpty());
    expect_same_results(work.folder / "fresh", work.folder / output);
    take_over(place, (output + "fresh").c_str(), {});
    expect_same_results(work.folder / "fresh", work.folder / (output + "fresh"));
  }
}

TEST(Reuse, PlacesInACampaignAreGivenFromItsFolder) {
  Divided work(1, false);
  const std::string id = work.campaign.takes[0].id;
  std::filesystem::remove(work.campaign.takes[0].mocap);
  const std::filesystem::path started = std::filesystem::current_path();
  std::filesystem::current_path(work.folder.path());
  const std::filesystem::path named = "c";  // which "abc/" ends with, too
  std::filesystem::create_directories(named);
  std::filesystem::rename("campaign", named / "abc");
  work.campaign.folder = named;
  for (Take& take : work.campaign.takes) {
    take.session = named / "abc" / take.id / "session.h5";
    take.mocap = named / "abc" / take.id / "mocap.csv";
    take.mapping = named / "abc" / take.id / "mapping.json";
    take.calibration = named / "abc/calibration.json";
  }
  const AccuracyRun again = run(work.study, work.campaign, "results", {});
  std::filesystem::current_path(started);
  ASSERT_THAT(again.summary.notes, Not(IsEmpty()));
  EXPECT_EQ(again.summary.notes[0].place, "abc/" + id + "/mocap.csv");
}

}  // namespace
}  // namespace trilat
