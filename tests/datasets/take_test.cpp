// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/calibration/calibration.h"
#include "datasets/take/campaign.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

TEST(Calibration, WhatIsWrittenIsReadBack) {
  const ScratchFolder folder;
  SensorPose pose;
  pose.name = "k1";
  pose.world_from_sensor = world_from_sensor_looking_at({1.0, 2.0, 3.0}, {0.1, 0.2, 0.3});
  pose.position_sigma_m = 0.004;
  pose.rotation_sigma_rad = 0.002;
  write_calibration(folder / "calibration.json", {"wand", {pose}});
  const Calibration calibration = read_calibration(folder / "calibration.json");
  EXPECT_EQ(calibration.method, "wand");
  const SensorPose& read = pose_of(calibration, "k1", "here");
  EXPECT_EQ(read.world_from_sensor.translation_m, pose.world_from_sensor.translation_m);
  EXPECT_LT(angle_between_rad(read.world_from_sensor.rotation, pose.world_from_sensor.rotation), 1e-15);
  EXPECT_EQ(read.position_sigma_m, 0.004);
  EXPECT_EQ(read.rotation_sigma_rad, 0.002);
  EXPECT_THAT(message_of([&] { pose_of(calibration, "k9", "cal.json"); }),
              HasSubstr("cal.json: has no pose for sensor \"k9\"; it has k1"));
}

TEST(Calibration, ErrorsNameThePlaceAndWhatWouldBeRight) {
  const ScratchFolder folder;
  const std::string good = R"({"name": "k1", "position_m": [0, 1, 2], "rotation_xyzw": [0, 0, 0, 1]})";
  const auto refusal = [&](const std::string& sensors) {
    write_file(
        folder / "cal.json",
        R"({"format": "trilat.calibration", "version": 1, "method": "wand", "sensors": [)" + sensors + "]}");
    return message_of([&] { read_calibration(folder / "cal.json"); });
  };
  EXPECT_EQ(refusal(good), "no error");
  EXPECT_THAT(refusal(""), HasSubstr("cal.json /sensors: must name at least one sensor"));
  EXPECT_THAT(refusal(good + "," + good), HasSubstr("cal.json /sensors/1/name: stands here twice"));
  EXPECT_THAT(refusal(R"({"name": "k1", "position_m": [0, 1200, 2], "rotation_xyzw": [0, 0, 0, 1]})"),
              HasSubstr("/sensors/0/position_m: lies beyond 100 m; is the unit metres?"));
  EXPECT_THAT(refusal(R"({"name": "k1", "position_m": [0, 1], "rotation_xyzw": [0, 0, 0, 1]})"),
              HasSubstr("/sensors/0/position_m: must be an array of 3 numbers"));
  EXPECT_THAT(refusal(R"({"name": "k1", "position_m": [0, 1, null], "rotation_xyzw": [0, 0, 0, 1]})"),
              HasSubstr("/sensors/0/position_m: must be a number, is null"));
  EXPECT_THAT(refusal(R"({"name": "k1", "position_m": [0, 1, 2], "rotation_xyzw": [0, 0, 0, 2]})"),
              HasSubstr("/sensors/0/rotation_xyzw: must be a unit quaternion"));
  EXPECT_THAT(refusal(R"({"name": "k1", "position_m": [0, 1, 2], "rotation_xyzw": [0, 0, 0, 1],
                          "position_sigma_m": -1})"),
              HasSubstr("/sensors/0/position_sigma_m: must not be negative"));
}

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
  write_campaign(here, {"two takes", true, {take_in(here, "a"), take_in(here, "b")}});
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

TEST(CampaignFile, ErrorsNameThePlaceAndWhatWouldBeRight) {
  const ScratchFolder folder;
  const auto refusal = [&](const std::string& takes) {
    write_file(folder / "campaign.json",
               R"({"format": "trilat.campaign", "version": 1, "name": "x", "takes": [)" + takes + "]}");
    return message_of([&] { read_campaign(folder.path()); });
  };
  const auto take = [](const std::string& id, const std::string& start) {
    return R"({"id": ")" + id + R"(", "participant": "p", "session": "s", "calibration": "c", "mocap": "m",
              "mapping": "m", "mocap_start_host_ns": )" +
           start + "}";
  };
  EXPECT_EQ(refusal(take("a", "5")), "no error");
  EXPECT_THAT(refusal(""), HasSubstr("campaign.json /takes: must hold at least one take"));
  EXPECT_THAT(refusal(take("a", "5") + "," + take("a", "5")),
              HasSubstr("/takes/1/id: is \"a\", which an earlier take has"));
  EXPECT_THAT(refusal(take("../a", "5")), HasSubstr("/takes/0/id: must be 1 to 100 letters"));
  EXPECT_THAT(refusal(take("a", "1.5")), HasSubstr("/takes/0/mocap_start_host_ns: must be an integer"));
  EXPECT_THAT(message_of([&] { read_campaign(folder / "absent"); }), HasSubstr("absent"));
  write_file(folder / "campaign.json", R"({"format": "trilat.campaign", "version": 2})");
  EXPECT_THAT(message_of([&] { read_campaign(folder.path()); }), HasSubstr("/version: is another version"));
}

TEST(MappingFile, WhatIsWrittenIsReadBack) {
  const ScratchFolder folder;
  write_mapping(folder / "mapping.json",
                {{{Joint::head, {"head_1", "head_2"}}, {Joint::wrist_left, {"rigid_body:Wrist"}}}});
  const JointMapping mapping = read_mapping(folder / "mapping.json");
  ASSERT_EQ(mapping.joints.size(), 2u);
  EXPECT_EQ(mapping.joints[0].joint, Joint::head);
  EXPECT_THAT(mapping.joints[0].assets, testing::ElementsAre("head_1", "head_2"));
  EXPECT_EQ(mapping.joints[1].joint, Joint::wrist_left);
}

TEST(MappingFile, ErrorsNameThePlaceAndWhatWouldBeRight) {
  const ScratchFolder folder;
  const auto refusal = [&](const std::string& joints) {
    write_file(folder / "mapping.json",
               R"({"format": "trilat.mapping", "version": 1, "joints": )" + joints + "}");
    return message_of([&] { read_mapping(folder / "mapping.json"); });
  };
  EXPECT_EQ(refusal(R"({"head": ["a"]})"), "no error");
  EXPECT_THAT(refusal(R"({"nose": ["a"]})"),
              HasSubstr("mapping.json /joints/nose: is no joint; known are: spine_base, "));
  EXPECT_THAT(refusal(R"({"head": []})"), HasSubstr("/joints/head: must name at least one asset"));
  EXPECT_THAT(refusal(R"({"head": ["a", "a"]})"), HasSubstr("/joints/head: names the asset \"a\" twice"));
  EXPECT_THAT(refusal(R"({"head": "a"})"), HasSubstr("/joints/head: must be an array of texts"));
  EXPECT_THAT(refusal("{}"), HasSubstr("/joints: must map at least one joint"));
}

}  // namespace
}  // namespace trilat
