// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/calibration/calibration.h"
#include "datasets/results/samples.h"
#include "tests/pipeline/divided.h"
#include "tests/pipeline/same_results.h"

namespace trilat {
namespace {

using ::testing::HasSubstr;

TEST(StudyPart, ThreeShardsMergeToTheBytesOfOneRun) {
  Divided work;
  const auto whole = work.whole({.cross_check = true});
  expect_same_results(whole, work.merged(work.parts(3, {.cross_check = true})));
}

TEST(StudyPart, TheSharesAreBalanced) {
  Divided work(6, false);
  std::array<double, 3> load{};
  double all = 0.0;
  for (const PartItem& item : read_part(work.parts(3)[0]).items) {
    load.at(item.shard - 1) += item.cost;
    all += item.cost;
  }
  for (const double cost : load) EXPECT_NEAR(cost / all, 1.0 / 3.0, 0.06);
}

TEST(StudyPart, ATakeThatFailedIsNamed) {
  Divided work;
  const auto part = work.parts(1)[0];
  const auto [takes, notes] = notes_of_part(part);
  EXPECT_EQ(takes, work.campaign.takes.size());
  const auto failed = std::ranges::find_if(notes, [](const TakeNote& note) { return note.failed; });
  ASSERT_NE(failed, notes.end());
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
  work.part({2, 2}, work.folder / "other");
  EXPECT_THAT(
      message_of([&] {
        read_parts(std::array{parts[0], work.folder / "other"});
      }),
      AllOf(HasSubstr("does not belong to"), HasSubstr("/study/rate_hz is 30.0 in the first and 20.0 here")));
  work.part({1, 3}, work.folder / "third");
  EXPECT_THAT(message_of([&] {
                read_parts(std::array{parts[0], work.folder / "third"});
              }),
              HasSubstr("it is shard 1/3, the first is 1/2"));
}

TEST(StudyPart, MergingRefusesShardsThatReadOtherFilesAndNamesTheTake) {
  Divided work(2, false);
  work.part({1, 2}, work.folder / "part");
  const std::string id = work.campaign.takes[0].id;
  const auto said = [&] {
    work.part({2, 2}, work.folder / "other");
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
      {"method": "median", "occlusion": "corrected"},
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
  EXPECT_THAT(said("parameters", Json::array({1})), HasSubstr("/work/parameters/0: must be an object"));
  Json takes = good["work"]["takes"];
  takes[0]["id"] = "p99-walking";
  EXPECT_THAT(said("takes", takes), HasSubstr("p99-walking: is a take of the study, but none of its items"));
}

TEST(StudyPart, APartThatNamesAnItemOutsideItselfOfNoCostOrOfNoShardIsRefused) {
  const ScratchFolder folder;
  const auto said = [&](PartItem item) {
    write_part(folder.path(), {"campaign", "build", 1, 2, Json::object(), {std::move(item)}});
    return message_of([&] { read_part(folder.path()); });
  };
  EXPECT_THAT(said({"../../secret", 1.0, 1}), HasSubstr("/items/0/id: is no name of an item"));
  EXPECT_THAT(said({"rigs//run-1", 1.0, 1}), HasSubstr("/items/0/id: is no name of an item"));
  EXPECT_EQ(said({"rigs/walk..1", 1.0, 1}), "no error");
  EXPECT_THAT(said({"/etc", 1.0, 1}), HasSubstr("/items/0/id: is no name of an item"));
  EXPECT_THAT(said({"p01-walking", std::nan(""), 1}), HasSubstr("/items/0/cost: must be a number"));
  EXPECT_THAT(said({"p01-walking", 1.0, 3}), HasSubstr("/items/0/shard: must be 1 to the number of shards"));
  EXPECT_THAT(said({"p01-walking", 1.0, 0}), HasSubstr("/items/0/shard: must be 1 to the number of shards"));
}

}  // namespace
}  // namespace trilat
