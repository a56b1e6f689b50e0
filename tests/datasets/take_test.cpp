// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "datasets/base/files.h"
#include "datasets/rig/campaign.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

Take take_in(const std::filesystem::path& folder, const std::string& id) {
  return {id,
          "p01",
          "walking",
          folder / id / "session.h5",
          folder / "calibration.json",
          folder / id / "mocap.csv",
          folder / id / "mapping.json",
          1'234'567'890'123};
}

TEST(CampaignFile, WhatIsWrittenIsReadBackWhereverTheFolderIsMoved) {
  const ScratchFolder folder;
  const auto here = folder / "here";
  std::filesystem::create_directories(here);
  write_campaign(here, {.name = "two takes",
                        .simulated = true,
                        .takes = {take_in(here, "a"), take_in(here, "b")},
                        .wand = CampaignWand{here / "wand.h5", here / "wand.csv", "ball", 7, 0.05},
                        .stated_distances = {{here / "ball.h5", here / "places.csv", 0.06}},
                        .walls = {{here / "near.h5", 1.5}, {here / "far.h5"}}});
  std::filesystem::rename(here, folder / "there");
  const Campaign campaign = read_campaign(folder / "there");
  EXPECT_EQ(campaign.name, "two takes");
  EXPECT_TRUE(campaign.simulated);
  ASSERT_EQ(campaign.takes.size(), 2u);
  const Take expected = take_in(folder / "there", "b");
  EXPECT_EQ(campaign.takes[1].id, "b");
  EXPECT_EQ(campaign.takes[1].session, expected.session);
  EXPECT_EQ(campaign.takes[1].calibration, expected.calibration);
  EXPECT_EQ(campaign.takes[1].mapping, expected.mapping);
  EXPECT_EQ(campaign.takes[1].mocap_start_host_ns, expected.mocap_start_host_ns);
  ASSERT_TRUE(campaign.wand.has_value());
  EXPECT_EQ(campaign.wand->session, folder / "there/wand.h5");
  EXPECT_EQ(campaign.wand->mocap, folder / "there/wand.csv");
  EXPECT_EQ(campaign.wand->asset, "ball");
  EXPECT_EQ(campaign.wand->mocap_start_host_ns, 7);
  EXPECT_EQ(campaign.wand->ball_radius_m, 0.05);
  ASSERT_EQ(campaign.stated_distances.size(), 1u);
  EXPECT_EQ(campaign.stated_distances[0].session, folder / "there/ball.h5");
  EXPECT_EQ(campaign.stated_distances[0].places, folder / "there/places.csv");
  EXPECT_EQ(campaign.stated_distances[0].ball_radius_m, 0.06);
  ASSERT_EQ(campaign.walls.size(), 2u);
  EXPECT_EQ(campaign.walls[0].distance_m, 1.5);
  EXPECT_EQ(campaign.walls[1].session, folder / "there/far.h5");
  EXPECT_EQ(campaign.walls[1].distance_m, std::nullopt);
}

// A take's paths are relative to the current directory, those in the file to the file.
TEST(CampaignFile, TakesOfAnotherFolderAreStillFound) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "new");
  const auto old = std::filesystem::relative(folder / "old");
  write_campaign(folder / "new", {"moved", false, {take_in(old, "a")}});
  const Take take = read_campaign(folder / "new").takes.at(0);
  EXPECT_EQ(std::filesystem::weakly_canonical(take.session), folder / "old" / "a" / "session.h5");
}

// Message with which read_campaign() refuses a campaign whose take has `path` under `key`.
std::string refusal_of_path(const ScratchFolder& folder, const std::string& key, const std::string& path) {
  Json take{{"id", "a"},    {"participant", "p"}, {"session", "s"},          {"calibration", "c"},
            {"mocap", "m"}, {"mapping", "n"},     {"mocap_start_host_ns", 5}};
  take[key] = path;
  const Json json{{"format", "trilat.campaign"}, {"version", 1}, {"name", "x"}, {"takes", {take}}};
  std::filesystem::create_directories(folder / "campaign");
  write_file(folder / "campaign" / "campaign.json", json.dump());
  return message_of([&] { read_campaign(folder / "campaign"); });
}

TEST(CampaignFile, PathsMayLeadAnywhereButToPipes) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "campaign");
  ASSERT_EQ(::mkfifo((folder / "campaign" / "pipe").c_str(), 0600), 0);
  for (const char* path : {"below/s", "../s", "/etc/s"})
    EXPECT_EQ(refusal_of_path(folder, "session", path), "no error") << path;
  EXPECT_THAT(refusal_of_path(folder, "session", ""),
              HasSubstr("campaign.json /takes/0/session: must name a file"));
  EXPECT_THAT(refusal_of_path(folder, "mocap", "pipe"), HasSubstr("is a device, a pipe or a socket"));
}

// Message with which read_campaign() refuses a campaign whose wand and take have these additional keys.
std::string refusal_with(const Json& of_wand, const Json& of_take) {
  Json json = parse_json(R"({"format": "trilat.campaign", "version": 1, "name": "x",
      "takes": [{"id": "a", "participant": "p", "session": "s.h5", "calibration": "c.json"}],
      "wand": {"session": "w.h5"}})",
                         "c.json");
  json["wand"].update(of_wand);
  json["takes"][0].update(of_take);
  return message_of([&] { parse_campaign(json, "c.json"); });
}

TEST(CampaignFile, AKeyOfNoUseWithoutAnotherNamesIt) {
  const std::string without_mocap = ": is of no use without \"mocap\"";
  EXPECT_EQ(refusal_with(Json::object(), Json::object()), "no error");
  EXPECT_EQ(refusal_with({{"asset", "Ball"}}, Json::object()), "c.json /wand/asset" + without_mocap);
  EXPECT_EQ(refusal_with({{"mocap_start_host_ns", 5}}, Json::object()),
            "c.json /wand/mocap_start_host_ns" + without_mocap);
  EXPECT_EQ(refusal_with(Json::object(), {{"mapping", "m.json"}}), "c.json /takes/0/mapping" + without_mocap);
  EXPECT_EQ(refusal_with(Json::object(), {{"up_axis", "z"}}), "c.json /takes/0/up_axis" + without_mocap);
}

}  // namespace
}  // namespace trilat
