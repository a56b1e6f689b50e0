// SPDX-License-Identifier: MIT
#include <functional>
#include <map>
#include <mutex>
#include <set>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/rig/calibration.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/take_key.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"

namespace trilat {
namespace {

std::string keys_of_takes(const StudySpec& study, const Campaign& campaign) {
  const Plan plan = make_plan(study, campaign);
  HashCache hashes;
  std::string keys;
  for (std::size_t t = 0; t < plan.takes.size(); ++t)
    keys += key_of_take(plan, t, inputs_of(plan.takes[t].take, hashes, {}), false) + " ";
  return keys;
}

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kDividedMethods = R"("occluded_apart": true,
    "alignments": ["mean", "none", "rigid", "first", "held_out", "joint_offset"], "methods": [
    {"method": "mean"}, {"method": "nonlinear"}, {"method": "geometric"}, {"method": "rts"}])";

// How many takes the last run into this folder computed.
std::size_t computed_in(const std::filesystem::path& results) {
  return read_json(results / "run.json").at("computed").size();
}

// Takes of two activities; one cannot be evaluated.
struct Divided {
  ScratchFolder folder;
  Campaign campaign;
  StudySpec study = study_of(kDividedMethods);

  explicit Divided(std::uint64_t participants = 4, bool one_fails = true) {
    SimulationSpec spec = walking_spec(participants);
    spec.activities.push_back(spec.activities[0]);
    spec.activities[1].activity = Activity::arm_swing;
    spec.activities[1].duration_s = 0.7;
    campaign = simulate_into(folder / "campaign", spec);
    if (one_fails) campaign.takes[1].mocap = folder / "campaign/absent.csv";
  }
  void whole() { execute_study(study, campaign, folder / "whole", {}); }
};

// A field that is added to Take stops the binding in take_key.cpp, and is then changed here.
TEST(Reuse, EveryFieldOfATakeAndOfTheCampaignIsInTheKey) {
  Divided work(1, false);
  const auto copied = [&](const std::filesystem::path& file) {
    const std::filesystem::path copy = work.folder / ("other_" + file.filename().string());
    write_file(copy, read_file(file) + "\n");
    return copy;
  };
  const std::pair<const char*, std::function<void(Campaign&)>> changes[] = {
      {"id", [](Campaign& c) { c.takes[0].id += "x"; }},
      {"participant", [](Campaign& c) { c.takes[0].participant += "x"; }},
      {"activity", [](Campaign& c) { c.takes[0].activity += "x"; }},
      {"session", [&](Campaign& c) { c.takes[0].session = copied(c.takes[0].session); }},
      {"calibration", [&](Campaign& c) { c.takes[0].calibration = copied(c.takes[0].calibration); }},
      {"mocap", [&](Campaign& c) { c.takes[0].mocap = copied(c.takes[0].mocap); }},
      {"mapping", [&](Campaign& c) { c.takes[0].mapping = copied(c.takes[0].mapping); }},
      {"mocap_start_host_ns", [](Campaign& c) { ++c.takes[0].mocap_start_host_ns; }},
      {"up_axis", [](Campaign& c) { c.takes[0].up_axis = UpAxis::z; }},
      {"joints/method", [](Campaign& c) { c.takes[0].joints[0].method += "x"; }},
      {"joints/file", [&](Campaign& c) { c.takes[0].joints[0].file = copied(c.takes[0].joints[0].file); }},
      {"joints/mapping name", [](Campaign& c) { c.takes[0].joints[0].mapping[0].name = "wrist_left"; }},
      {"joints/mapping assets", [](Campaign& c) { c.takes[0].joints[0].mapping[0].assets.push_back("two"); }},
      {"joints/clock", [](Campaign& c) { c.takes[0].joints[0].clock_by_motion = true; }}};
  write_file(work.folder / "mine.csv", "time_s,joint,x_m,y_m,z_m\n0,one,1,2,3\n");
  work.campaign.takes[0].joints = {{"mine", work.folder / "mine.csv", {{"head", {"one"}}}}};
  const auto key_of = [&](const Campaign& campaign) { return keys_of_takes(work.study, campaign); };
  const std::string key = key_of(work.campaign);
  EXPECT_EQ(key_of(work.campaign), key);
  for (const auto& [field, change] : changes) {
    Campaign campaign = work.campaign;
    change(campaign);
    EXPECT_NE(key_of(campaign), key) << field;
  }
}

// A setting that is added to a study has to be named in one of the lists.
TEST(Reuse, EverySettingThatDecidesSamplesIsInTheKeyAndNoOther) {
  const Divided work(1, false);
  const std::map<std::string, std::string> deciding{
      {"sensors", R"(["k1", "k2"])"},
      {"joints", R"(["head"])"},
      {"truth", R"("left_out_sensor")"},
      {"rate_hz", "15"},
      {"sensor_gap_s", "0.2"},
      {"truth_gap_s", "0.1"},
      {"clock", R"("motion")"},
      {"clock_search_s", "1"},
      {"repair_exchanges", "false"},
      {"frames", R"("newest")"},
      {"poses", R"("wand")"},
      {"sensor_clocks", R"("causal")"},
      {"clock_error_s", "0.01"},
      {"methods", R"([{"method": "nonlinear", "max_iterations": 7}])"}};
  const std::map<std::string, std::string> others{{"name", R"("another")"},
                                                  {"paper", R"("table3")"},
                                                  {"conditions", R"(["walking", "arm_swing"])"},
                                                  {"occluded_apart", "true"},
                                                  {"reference", R"("nonlinear")"},
                                                  {"alignments", R"(["first"])"},
                                                  {"training_share", "0.3"},
                                                  {"cross_check_limit_m", "1e-5"}};
  const auto keys_of = [&](const std::string& key, const std::string& value) {
    Json json = parse_json(R"({"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "test",
                               "methods": [{"method": "nonlinear"}]})",
                           "study");
    if (!key.empty()) json[key] = parse_json(value, key);
    return keys_of_takes(parse_study(json, "study", {}), work.campaign);
  };
  const std::string plain = keys_of("", "");
  for (const auto& [key, value] : deciding) EXPECT_NE(keys_of(key, value), plain) << key;
  for (const auto& [key, value] : others) EXPECT_EQ(keys_of(key, value), plain) << key;
  const std::set<std::string> heads{"format", "version", "kind", "campaign"};
  const Json resolved = json_of(work.study);
  for (const auto& [key, value] : resolved.items())
    EXPECT_TRUE(deciding.contains(key) || others.contains(key) || heads.contains(key)) << key;
}

TEST(Reuse, WhatDecidesTheClockDecidesTheTake) {
  Divided work(3, false);
  work.whole();
  const std::string methods = R"("methods": [{"method": "mean"}], )";
  const auto computed = [&](const std::string& members) {
    execute_study(study_of(methods + members), work.campaign, work.folder / "shapes", {});
    return computed_in(work.folder / "shapes");
  };
  EXPECT_EQ(computed(R"("alignments": ["rigid"])"), work.campaign.takes.size());
  EXPECT_EQ(computed(R"("alignments": ["rigid"], "clock_error_s": 0.01)"), work.campaign.takes.size());
  EXPECT_EQ(computed(R"("alignments": ["rigid", "none"], "clock_error_s": 0.01)"),
            work.campaign.takes.size());
  EXPECT_EQ(computed(R"("alignments": ["none", "mean"], "clock_error_s": 0.01)"), 0u);
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
  const ResultsSummary summary = execute_study(work.study, work.campaign, work.folder / "results",
                                               {.threads = 1, .stop_requested = replace});
  EXPECT_EQ(summary.takes_failed, summary.takes);
  ASSERT_THAT(summary.notes, Not(IsEmpty()));
  EXPECT_THAT(summary.notes[0].text, HasSubstr("changed while it was being evaluated"));
  EXPECT_EQ(computed_in(work.folder / "results"), 0u);
}

TEST(Reuse, WhatFailedIsTriedAgain) {
  Divided work;
  work.whole();
  work.campaign.takes[1].mocap = work.campaign.takes[0].mocap;
  const ResultsSummary summary = execute_study(work.study, work.campaign, work.folder / "whole", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  EXPECT_EQ(computed_in(work.folder / "whole"), 1u);
}

// The program's own file, since one that was changed within two seconds is not remembered.
TEST(HashCache, RemembersAcrossRunsAndDoesWithoutADamagedMemory) {
  const ScratchFolder folder;
  HashCache first;
  const std::string sha256 = first.hash(kProgram, {}).sha256;
  EXPECT_EQ(sha256.size(), 64u);
  first.save(folder.path());
  std::string text = read_file(folder / "hashes.json");
  const auto at = text.find(sha256);
  ASSERT_NE(at, std::string::npos);
  const auto hash_after = [&](const std::string& memory) {
    write_file(folder / "hashes.json", memory);
    HashCache later;
    later.load(folder.path());
    return later.hash(kProgram, {}).sha256;
  };
  EXPECT_EQ(hash_after(text.replace(at, 64, std::string(64, 'f'))), std::string(64, 'f'));
  EXPECT_EQ(hash_after(text.substr(0, text.size() / 2)), sha256);
  EXPECT_EQ(hash_after(R"({"format": "trilat.hashes", "version": 2, "files": {}})"), sha256);
  HashCache absent;
  absent.load(folder / "none");
  EXPECT_EQ(absent.hash(kProgram, {}).sha256, sha256);
  EXPECT_EQ(absent.hash(folder / "none", {}).sha256, "");
}

}  // namespace
}  // namespace trilat
