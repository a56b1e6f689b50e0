// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "datasets/base/files.h"
#include "datasets/take/campaign.h"
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

// What reading says of a campaign one of whose paths is this.
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
  EXPECT_THAT(message_of([&] { read_campaign(folder.path()); }),
              HasSubstr("/version: must be 1, the version that this program reads"));
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
              HasSubstr("mapping.json /joints/nose: is not a joint; known are: spine_base, "));
  EXPECT_THAT(refusal(R"({"head": []})"), HasSubstr("/joints/head: must name at least one asset"));
  EXPECT_THAT(refusal(R"({"head": ["a", "a"]})"), HasSubstr("/joints/head: names the asset \"a\" twice"));
  EXPECT_THAT(refusal(R"({"head": "a"})"), HasSubstr("/joints/head: must be an array of texts"));
  EXPECT_THAT(refusal("{}"), HasSubstr("/joints: must map at least one joint"));
}

}  // namespace
}  // namespace trilat
