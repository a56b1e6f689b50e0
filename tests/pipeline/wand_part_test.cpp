// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/calibration/wand_search.h"
#include "pipeline/calibration/wand_study.h"
#include "pipeline/study/results_folder.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/same_results.h"
#include "tests/pipeline/wand_sessions.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

constexpr std::uint64_t kFrames = 25;  // of a place; runs of frames end in the middle of one

// Two sensors that see a ball at a few places.
void record_places(const std::filesystem::path& path, std::size_t places) {
  std::vector<DepthScene> scenes;
  for (std::size_t p = 0; p < places; ++p) scenes.push_back(ball_in_room(kPlaces[p]));
  record(path, rig_of(2), scenes, header_of(2), kFrames, true);
}

using Paths = std::vector<std::filesystem::path>;

struct DividedWand {
  ScratchFolder folder;
  Paths sessions{folder / "session.h5"};
  CalibrateWandOptions options;
  WandMethod method = WandMethod::wand;

  explicit DividedWand(std::size_t places = 3) { record_places(sessions.front(), places); }
  // What the part of this name holds already is taken over.
  ItemTally part(const Shard& shard, const std::string& name, StudyOptions run = {}) const {
    const std::filesystem::path output = folder / name;
    run.shard = shard;
    if (std::filesystem::exists(output)) run.reuse = {output};
    return run_study(wand_study(sessions, method, options, kWandBlock), output, run);
  }
  // What parts of these names hold already is taken over.
  Paths parts(std::uint64_t of) const {
    Paths names;
    for (std::uint64_t k = 1; k <= of; ++k) {
      names.push_back(folder / fmt::format("{}-of-{}", k, of));
      part({k, of}, names.back().filename());
    }
    return names;
  }
};

std::string text_of(const WandCalibration& result) {
  std::string text = json_text(calibration_json(result.calibration), 1);
  for (const SensorEvidence& sensor : result.views.evidence) {
    text += fmt::format("\n{} {} {} {} {}", sensor.name, sensor.frames, sensor.rests, sensor.nearest_m,
                        sensor.farthest_m);
    for (const auto& [status, count] : sensor.statuses) text += fmt::format(" {} {}", status, count);
  }
  return text;
}

std::string merged(const Paths& parts) { return text_of(calibrate_parts(read_parts(parts))); }

TEST(WandPart, AnyNumberOfShardsMergesToTheBytesOfOneRun) {
  DividedWand work;
  for (const WandMethod method : {WandMethod::wand, WandMethod::two_positions}) {
    work.method = method;
    const std::string whole = text_of(calibrate_wand(work.sessions, work.options, method));
    for (const std::uint64_t shards : {1u, 2u, 7u, 64u})
      EXPECT_EQ(merged(work.parts(shards)), whole) << name_of(method) << ' ' << shards;
  }
}

TEST(WandPart, TheMethodAsPrintedMergesTooWithTheAxisThatWasAskedFor) {
  DividedWand work;
  work.method = WandMethod::printed;
  const std::string as_printed = text_of(calibrate_wand(work.sessions, work.options, work.method));
  EXPECT_EQ(merged(work.parts(2)), as_printed);
  std::uint64_t shards = 2;  // each number has folders of its own
  for (const TrajectoryAxis axis : {TrajectoryAxis::x, TrajectoryAxis::y, TrajectoryAxis::z}) {
    work.options.trajectory_axis = axis;
    const std::string whole = text_of(calibrate_wand(work.sessions, work.options, work.method));
    EXPECT_EQ(whole == as_printed, axis == TrajectoryAxis::y);
    EXPECT_EQ(merged(work.parts(++shards)), whole);
  }
}

TEST(WandPart, TheLengthOfItemsChangesNothing) {
  const DividedWand work;
  run_study(wand_study(work.sessions, work.method, work.options), work.folder / "long", {.shard = {1, 1}});
  EXPECT_EQ(merged({work.folder / "long"}), merged(work.parts(2)));
}

TEST(WandPart, SeveralRecordingsAreSharedOut) {
  DividedWand work;
  work.sessions.push_back(work.folder / "second.h5");
  record(work.sessions.back(), rig_of(2), {ball_in_room(kPlaces[3]), ball_in_room(kPlaces[4])}, header_of(2));
  EXPECT_EQ(merged(work.parts(3)), text_of(calibrate_wand(work.sessions, work.options)));
}

TEST(WandPart, OneRecordingIsSharedOutAndEverySearchIsOneShards) {
  const DividedWand work;
  const std::vector<FoundPart> parts = read_parts(work.parts(3));
  std::array<double, 3> load{};
  for (const PartItem& item : parts.front().part.items) load.at(item.shard - 1) += item.cost;
  EXPECT_THAT(load, testing::Each(testing::Gt(0.0)));
  std::size_t held = 0;
  for (const FoundPart& part : parts)
    for (const PartItem& item : part.part.items)
      held += std::filesystem::exists(item_folder(part.folder, item.id)) ? 1 : 0;
  EXPECT_EQ(held, parts.front().part.items.size());
}

TEST(WandPart, AnExportIsNotNeededForMerging) {
  DividedWand work;
  write_wand_export(work.folder / "wand.csv", true);
  work.options.world = WandInWorld{work.folder / "wand.csv", "Wand", kStart_ns};
  const std::string whole = text_of(calibrate_wand(work.sessions, work.options));
  EXPECT_THAT(whole, AllOf(HasSubstr("optitrack"), HasSubstr("wand.csv")));
  const Paths parts = work.parts(2);
  std::filesystem::remove(work.folder / "wand.csv");
  std::filesystem::remove(work.sessions.front());
  EXPECT_EQ(merged(parts), whole);
}

TEST(WandPart, AShardThatWasStoppedGoesOnAndEndsWithTheSameBytes) {
  DividedWand work;
  const std::string whole = text_of(calibrate_wand(work.sessions, work.options));
  const auto is_begun = [&] { return finished_items(work.folder / "part.partial"); };
  EXPECT_THROW(work.part({1, 1}, "part", {.threads = 1, .stop_requested = is_begun}), Interrupted);
  EXPECT_FALSE(std::filesystem::exists(work.folder / "part"));
  EXPECT_THAT(message_of([&] { merged({work.folder / "part"}); }), HasSubstr("is not finished yet"));
  const ItemTally rest = work.part({1, 1}, "part");
  EXPECT_THAT(rest.continued, Not(IsEmpty()));
  EXPECT_THAT(rest.computed, Not(IsEmpty()));
  EXPECT_EQ(merged({work.folder / "part"}), whole);
}

TEST(WandPart, WhatDoesNotConcernTheSearchCostsNoSearch) {
  DividedWand work;
  work.part({1, 1}, "part");
  work.options.movement_m = 0.61;
  EXPECT_THAT(work.part({1, 1}, "part").computed, IsEmpty());
  EXPECT_EQ(merged({work.folder / "part"}), text_of(calibrate_wand(work.sessions, work.options)));
  work.options.search.find.ball_radius_m = 0.07;
  EXPECT_THAT(work.part({1, 1}, "part").reused, SizeIs(1));  // the recording's hash
}

TEST(WandPart, AnotherRecordingOfThatNameIsSearchedAnew) {
  DividedWand work;
  work.part({1, 1}, "part");
  record(work.sessions.front(), rig_of(2),
         {ball_in_room(kPlaces[0]), ball_in_room(kPlaces[1]), ball_in_room(kPlaces[3])}, header_of(2),
         kFrames, true);
  EXPECT_THAT(work.part({1, 1}, "part").reused, IsEmpty());
  EXPECT_EQ(merged({work.folder / "part"}), text_of(calibrate_wand(work.sessions, work.options)));
}

// What no search depends on is in the file's hash all the same; not even its times need tell.
TEST(WandPart, ARecordingThatWasWrittenAgainIsHashedAnew) {
  DividedWand work;
  work.part({1, 1}, "part");
  const auto& file = work.sessions.front();
  const auto written = std::filesystem::last_write_time(file);
  SessionHeader header = header_of(2);
  header.sensors.front().model = "Kinect V2";
  record(file, rig_of(2), {ball_in_room(kPlaces[0]), ball_in_room(kPlaces[1]), ball_in_room(kPlaces[2])},
         header, kFrames, true);
  std::filesystem::last_write_time(file, written);
  EXPECT_THAT(work.part({1, 1}, "part").computed, ElementsAre("wand/r1-sha256"));
  EXPECT_EQ(merged({work.folder / "part"}), text_of(calibrate_wand(work.sessions, work.options)));
}

TEST(WandPart, AFileThatIsReplacedDuringTheSearchIsRefused) {
  DividedWand work;
  work.options.world = WandInWorld{work.folder / "wand.csv", "Wand", kStart_ns};
  std::filesystem::path replaced;
  const auto replace = [&] {
    std::error_code done;
    std::filesystem::rename(work.folder / "other", replaced, done);
  };
  const auto expect_refused = [&](const std::function<void()>& action) {
    for (const auto& file : {work.sessions.front(), work.options.world->mocap}) {
      replaced = file;
      record_places(work.sessions.front(), 3);
      write_wand_export(work.options.world->mocap, true);
      write_file(work.folder / "other", "something else");
      EXPECT_THAT(message_of(action),
                  HasSubstr(file.filename().string() + ": changed while it was being evaluated; run again"));
      EXPECT_FALSE(std::filesystem::exists(work.folder / "part"));
    }
  };
  expect_refused([&] {
    work.part({1, 1}, "part", {.threads = 1, .progress = [&](const std::string&, double) { replace(); }});
  });
  work.options.search.watch.progress = [&](double) { replace(); };
  expect_refused([&] { on_threads(1, [&](int) { calibrate_wand(work.sessions, work.options); }); });
}

TEST(WandPart, MergingNamesWhatIsMissingAndWhatIsThereTwice) {
  const DividedWand work;
  const Paths parts = work.parts(3);
  EXPECT_THAT(message_of([&] {
                merged({parts[0], parts[2]});
              }),
              AllOf(HasSubstr("missing: shard 2/3"), HasSubstr("r1-s")));
  EXPECT_THAT(message_of([&] {
                merged({parts[0], parts[1], parts[1], parts[2]});
              }),
              HasSubstr("is shard 2/3, which"));
}

TEST(WandPart, MergingRefusesPartsOfOtherRecordingsAndOptions) {
  DividedWand work(1);
  const std::filesystem::path first = work.folder / "first";
  work.part({1, 2}, "first");
  const auto complaint = [&] {
    work.part({2, 2}, "other");
    return message_of([&] { merged({first, work.folder / "other"}); });
  };
  work.method = WandMethod::printed;
  EXPECT_THAT(complaint(), AllOf(HasSubstr("other: does not belong to " + first.string()),
                                 HasSubstr("/method is \"wand\" in the first and \"printed\" here")));
  work.method = WandMethod::wand;
  work.options.search.find.ball_radius_m = 0.08;
  EXPECT_THAT(complaint(), HasSubstr("/options/ball_radius_m is 0.075 in the first and 0.08 here"));
  work.options = {};
  record(work.sessions.front(), rig_of(2), {ball_in_room(kPlaces[1])}, header_of(2), kFrames, true);
  EXPECT_THAT(complaint(), HasSubstr("/recordings/0/"));
}

TEST(WandPart, APartThatWasChangedIsRefusedWithThePlace) {
  const DividedWand work;
  const Paths parts = work.parts(1);
  const auto complaint = [&](const char* file, const std::string& from, const std::string& to) {
    const std::string text = read_file(parts[0] / file);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at == std::string::npos) return from;
    write_file(parts[0] / file, std::string(text).replace(at, from.size(), to));
    const std::string message = message_of([&] { merged(parts); });
    write_file(parts[0] / file, text);
    return message;
  };
  const char* frames = "items/wand/r1-s1-f0/item.json";
  EXPECT_THAT(complaint(frames, R"({"found":60})", R"({"found":59})"),
              AllOf(HasSubstr("r1-s1-f0/item.json outcome"), HasSubstr("is of 59 frames, not of 60")));
  EXPECT_THAT(complaint(frames, R"("pixels":[)", R"("pixels":[0.5,)"), HasSubstr("pixels"));
  EXPECT_THAT(complaint("items/wand/r1-sha256/item.json", R"("sha256":)", R"("sha512":)"),
              HasSubstr("sha256"));
  EXPECT_THAT(complaint("part.json", R"("depth_frames": 75)", R"("depth_frames": 75000000000000)"),
              HasSubstr("/items: are not those that its work is divided into"));
  EXPECT_THAT(complaint("part.json", R"("frames_of_item": 60)", R"("frames_of_item": 61)"),
              HasSubstr("/work/frames_of_item: must be a multiple of 60"));
  EXPECT_THAT(complaint("part.json", R"("method": "wand")", R"("method": "guess")"),
              HasSubstr("/work/method"));
}

TEST(WandOutcome, ReadsBackToTheLastBit) {
  SensorSearch search{{}, {{"found", 1}, {"no_wand", 2}}, 3};
  WandSighting sighting{WandStatus::found, {0.1, -1.0 / 3.0, 2e-17}, {}, std::nan(""), 321};
  sighting.covariance_m2 << 1e-300, 1.0 / 7.0, -0.0, 4.0, 5.0, 6.0, 7.0, 8.0, std::nextafter(9.0, 10.0);
  search.found.push_back({HostTime{9'007'199'254'740'993}, sighting});
  const std::string text = json_text(json_of(search), -1);
  const SensorSearch again = read_sensor_search(parse_json(text, "here"), "here");
  EXPECT_EQ(json_text(json_of(again), -1), text);
  ASSERT_THAT(again.found, SizeIs(1));
  EXPECT_EQ(again.frames, 3u);
  EXPECT_EQ(again.found[0].time.ns, 9'007'199'254'740'993);
  EXPECT_EQ(again.found[0].sighting.centre_in_sensor_m, sighting.centre_in_sensor_m);
  EXPECT_EQ(again.found[0].sighting.covariance_m2, sighting.covariance_m2);
  EXPECT_TRUE(std::signbit(again.found[0].sighting.covariance_m2(0, 2)));
  EXPECT_TRUE(std::isnan(again.found[0].sighting.rms_m));
  EXPECT_EQ(again.found[0].sighting.pixels, 321);
}

TEST(WandSearch, WhatFollowsIsFoundOnlyWhereTimeRises) {
  const auto at = [](std::vector<std::int64_t> times_ns) {
    SensorSearch search{{}, {{"found", times_ns.size()}}, times_ns.size()};
    for (const std::int64_t time_ns : times_ns) search.found.push_back({HostTime{time_ns}, {}});
    return search;
  };
  SensorSearch search = at({1, 5});
  append(search, at({4, 5, 6}));
  append(search, at({}));
  EXPECT_THAT(search.found, SizeIs(3));
  EXPECT_EQ(search.found.back().time.ns, 6);
  EXPECT_EQ(search.frames, 5u);
  EXPECT_EQ(search.statuses.at("found"), 5u);
}

TEST(CalibrateVerb, ShardsMergeToTheFileAndTheTextOfOneRun) {
  const DividedWand work;
  const ScratchFolder& folder = work.folder;
  const std::string session = work.sessions.front();
  const Ended whole =
      run_trilat(folder, {"calibrate", session, "--movement-m", "0.61", "-o", folder / "calibration.json"});
  EXPECT_EQ(whole.code, 0) << whole.err;
  const std::string bytes = read_file(folder / "calibration.json");
  std::filesystem::remove(folder / "calibration.json");
  for (const char* k : {"1", "2"}) {
    const Ended part = run_trilat(folder, {"calibrate", session, "--movement-m", "0.61", "--shard",
                                           std::string(k) + "/2", "-o", folder / k, "--json"});
    EXPECT_EQ(part.code, 0) << part.err;
    EXPECT_EQ(only_json(part).at("shard"), std::string(k) + "/2");
  }
  const auto merge = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"merge", folder / "2", folder / "1", "-o", folder / "calibration.json"});
    return run_trilat(folder, more);
  };
  const Ended merged = merge({});
  EXPECT_EQ(merged.code, 0) << merged.err;
  EXPECT_EQ(merged.out, whole.out);
  EXPECT_EQ(read_file(folder / "calibration.json"), bytes);
  EXPECT_EQ(only_json(merge({"--json"})).at("calibration"), (folder / "calibration.json").string());
}

TEST(CalibrateVerb, WhatCannotBeSharedOutIsRefused) {
  const DividedWand work(1);
  const std::string session = work.sessions.front(), part = work.folder / "part";
  expect_refused(
      run_trilat(work.folder, {"calibrate", session, "--method", "bodies", "--shard", "1/2", "-o", part}),
      "--shard: is of no use with --method bodies, which takes seconds");
  expect_refused(run_trilat(work.folder, {"calibrate", session, "--shard", "3/2", "-o", part}), "--shard");
  std::filesystem::create_directory(work.folder / "mine");
  write_file(work.folder / "mine/notes.txt", "mine");
  expect_refused(
      run_trilat(work.folder, {"calibrate", session, "--shard", "1/2", "-o", work.folder / "mine"}),
      "is not a results folder");
  EXPECT_FALSE(std::filesystem::exists(part));
}

}  // namespace
}  // namespace trilat
