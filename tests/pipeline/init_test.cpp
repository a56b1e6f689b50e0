// SPDX-License-Identifier: MIT
// `trilat init`, and what it finds by names and by motion.
#include <fstream>

#include <gmock/gmock.h>

#include "datasets/mocap/mocap_take.h"
#include "pipeline/accuracy/proposals.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

MocapHeader export_of(AssetType type, const std::vector<std::string>& names) {
  MocapHeader header;
  for (const std::string& name : names) header.assets.push_back({type, name, name, "", true});
  return header;
}

std::vector<std::string> assets_for(const MocapHeader& header, Joint joint) {
  for (const auto& entry : propose_mapping(header).joints)
    if (entry.joint == joint) return entry.assets;
  return {};
}

TEST(ProposedMapping, AMotiveBoneStandsAtItsUpperJoint) {
  const MocapHeader header =
      export_of(AssetType::bone, {"Ann:Hip", "Ann:Neck", "Ann:Head", "Ann:LUArm", "Ann:LFArm", "Ann:RHand",
                                  "Ann:RShin", "Ann:LFoot", "Ann:LToe", "Ann:RIndex1"});
  EXPECT_THAT(assets_for(header, Joint::shoulder_left), ElementsAre("bone:Ann:LUArm"));
  EXPECT_THAT(assets_for(header, Joint::elbow_left), ElementsAre("bone:Ann:LFArm"));
  EXPECT_THAT(assets_for(header, Joint::wrist_right), ElementsAre("bone:Ann:RHand"));
  EXPECT_THAT(assets_for(header, Joint::knee_right), ElementsAre("bone:Ann:RShin"));
  EXPECT_THAT(assets_for(header, Joint::neck), ElementsAre("bone:Ann:Head"));
  EXPECT_THAT(assets_for(header, Joint::head), ElementsAre());
  EXPECT_EQ(propose_mapping(header).joints.size(), 9u);
}

TEST(ProposedMapping, MarkersOnBothSidesOfAJointAreItsMiddle) {
  const MocapHeader plug_in =
      export_of(AssetType::marker, {"LFHD", "RFHD", "LBHD", "RBHD", "LELB", "LWRA", "LWRB", "RKNE", "LTHI"});
  EXPECT_EQ(assets_for(plug_in, Joint::head).size(), 4u);
  EXPECT_THAT(assets_for(plug_in, Joint::elbow_left), ElementsAre("marker:LELB"));
  EXPECT_THAT(assets_for(plug_in, Joint::wrist_left), ElementsAre("marker:LWRA", "marker:LWRB"));
  EXPECT_THAT(assets_for(plug_in, Joint::knee_right), ElementsAre("marker:RKNE"));
  const MocapHeader baseline = export_of(AssetType::marker, {"A:LElbowOut", "A:LElbowIn", "A:RShoulderTop"});
  EXPECT_THAT(assets_for(baseline, Joint::elbow_left),
              ElementsAre("marker:A:LElbowIn", "marker:A:LElbowOut"));
  const MocapHeader own = export_of(AssetType::marker, {"wrist_left_1", "wrist_left_2", "head", "spine1"});
  EXPECT_THAT(assets_for(own, Joint::wrist_left), ElementsAre("marker:wrist_left_1", "marker:wrist_left_2"));
  EXPECT_THAT(assets_for(own, Joint::head), ElementsAre("marker:head"));
}

TEST(ProposedMapping, TwoPersonsAndNamesThatSayNothingGiveNone) {
  EXPECT_TRUE(propose_mapping(export_of(AssetType::bone, {"Ann:LFArm", "Bob:LFArm"})).joints.empty());
  EXPECT_TRUE(
      propose_mapping(export_of(AssetType::marker, {"Unlabeled 1036", "Rigid Body 1"})).joints.empty());
}

// A folder as somebody has it who recorded: recordings, exports, a calibration.
std::filesystem::path own_folder(const ScratchFolder& folder) {
  const auto campaign = folder / "campaign", own = folder / "own";
  simulate_into(campaign, walking_spec(2, 12.0));
  for (const Take& take : read_campaign(campaign).takes) {
    std::filesystem::create_directories(own / take.participant);
    std::filesystem::copy(take.session, own / take.participant / "walking.h5");
    std::filesystem::copy(take.mocap, own / take.participant / "walking.csv");
    std::filesystem::copy_file(take.calibration, own / "calibration.json",
                               std::filesystem::copy_options::overwrite_existing);
  }
  return own;
}

// Leaves out the first rows of an export, whose times then begin later.
void cut_rows(const std::filesystem::path& file, int rows) {
  std::ifstream in(file);
  std::string text, line;
  for (bool is_data = false; std::getline(in, line);) {
    if (is_data && rows-- > 0) continue;
    is_data = is_data || line.starts_with("Frame,");
    text += line + "\n";
  }
  in.close();
  write_file(file, text);
}

TEST(Init, AFolderOfRecordingsRunsWithoutAnythingWrittenByHand) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  const std::int64_t truly_ns = read_campaign(folder / "campaign").takes[0].mocap_start_host_ns;
  cut_rows(own / "p01/walking.csv", 300);
  const Ended ended = run_trilat(folder, {"init", own.string()});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, AllOf(HasSubstr("p01-walking: walking of p01, 4 sensors; walking.csv starts 2.99"),
                               HasSubstr(" s before the recording ("), HasSubstr("next: trilat run ")));
  const Campaign campaign = read_campaign(own);
  ASSERT_EQ(campaign.takes.size(), 2u);
  EXPECT_TRUE(campaign.simulated);
  const double off_s = 1e-9 * static_cast<double>(campaign.takes[0].mocap_start_host_ns - truly_ns);
  EXPECT_NEAR(off_s, 3.0, 0.01);  // what was cut; this tracker has no lag
  const Ended run = run_trilat(folder, {"run", (own / "study.json").string(), "--campaign", own.string(),
                                        "-o", (folder / "results").string()});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2 of 2 takes"));
}

// Sensors in a world of their own: a step later on a circle is a turn of that world.
TEST(Init, AWalkInACircleNeedsToKnowHowFarApartBothBegan) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  std::string text = read_file(own / "calibration.json");
  const std::size_t at = text.find("\"optitrack\"");
  ASSERT_NE(at, std::string::npos);
  write_file(own / "calibration.json", text.replace(at, 11, "\"sensor k1\""));
  EXPECT_THAT(run_trilat(folder, {"init", own.string()}).err,
              HasSubstr("(ambiguous): several starts fit, as when somebody walks in a circle"));
  const Ended ended = run_trilat(folder, {"init", own.string(), "--force", "--start-within-s", "0.5"});
  EXPECT_THAT(ended.out, HasSubstr("by the motion")) << ended.err;
  EXPECT_THAT(read_file(own / "study.json"), Not(HasSubstr("joint_offset")));
  EXPECT_NEAR(1e-9 * static_cast<double>(read_campaign(own).takes[0].mocap_start_host_ns -
                                         read_campaign(folder / "campaign").takes[0].mocap_start_host_ns),
              0.0, 0.01);
}

TEST(Init, RunAgainAddsNewTakesAndKeepsWhatWasEdited) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  ASSERT_EQ(run_trilat(folder, {"init", own.string()}).code, 0);
  Campaign edited = read_campaign(own);
  edited.takes[0].participant = "Ann";
  edited.takes[0].mocap_start_host_ns += 7;
  write_campaign(own, edited);
  const std::string study = read_file(own / "study.json"), mapping = read_file(own / "mapping.json");
  const std::string campaign = read_file(own / "campaign.json");
  const Ended again = run_trilat(folder, {"init", own.string()});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("has 2 takes from before, which stay as they are; 0 are new"));
  EXPECT_EQ(read_file(own / "campaign.json"), campaign);
  EXPECT_EQ(read_file(own / "study.json"), study);
  // a recording more, and an edited study and mapping
  std::filesystem::copy(own / "p01", own / "p03", std::filesystem::copy_options::recursive);
  write_file(own / "study.json", std::string(study).replace(study.find("\"window\""), 8, "\"kalman\""));
  write_file(own / "mapping.json", mapping + "\n");
  const Ended added = run_trilat(folder, {"init", own.string()});
  EXPECT_EQ(added.code, 0) << added.err;
  EXPECT_THAT(added.err, AllOf(HasSubstr("study.json: differs from what init writes, and is kept"),
                               HasSubstr("2 takes from before, which stay as they are; 1 are new")));
  const Campaign grown = read_campaign(own);
  ASSERT_EQ(grown.takes.size(), 3u);
  EXPECT_EQ(grown.takes[0].participant, "Ann");
  EXPECT_EQ(grown.takes[0].mocap_start_host_ns, edited.takes[0].mocap_start_host_ns);
  EXPECT_EQ(grown.takes[2].participant, "p03");
  EXPECT_THAT(read_file(own / "study.json"), HasSubstr("kalman"));
  EXPECT_EQ(read_file(own / "mapping.json"), mapping + "\n");
  // also where everything is to be found anew
  EXPECT_EQ(run_trilat(folder, {"init", own.string(), "--force"}).code, 0);
  EXPECT_NE(read_campaign(own).takes[0].participant, "Ann");
  EXPECT_THAT(read_file(own / "study.json"), HasSubstr("kalman"));
  EXPECT_EQ(read_file(own / "mapping.json"), mapping + "\n");
}

// "wall" and "wand", also with a number, but no name that only begins so; and what states distances.
TEST(Init, RecordingsToCalibrateByAreKnownByTheirNames) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  for (const char* file : {"wand/session.h5", "wall_2m.h5", "wanda/session.h5", "ball/session.h5"}) {
    std::filesystem::create_directories((own / file).parent_path());
    std::filesystem::copy(own / "p01/walking.h5", own / file);
  }
  write_file(own / "ball/places.csv", "from_s,to_s,sensor,distance_m\n");
  const Ended ended = run_trilat(folder, {"init", own.string()});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("wall_2m.h5: a recording to calibrate by, by its name, and not a take"));
  const Campaign campaign = read_campaign(own);
  EXPECT_EQ(campaign.takes.size(), 3u);  // p01, p02, wanda
  EXPECT_EQ(campaign.wand->session, own / "wand/session.h5");
  ASSERT_EQ(campaign.walls.size(), 1u);
  EXPECT_EQ(campaign.walls[0].session, own / "wall_2m.h5");
  ASSERT_EQ(campaign.stated_distances.size(), 1u);
  EXPECT_EQ(campaign.stated_distances[0].places, own / "ball/places.csv");
  // again, with a wall more
  std::filesystem::copy(own / "p01/walking.h5", own / "wall.h5");
  ASSERT_EQ(run_trilat(folder, {"init", own.string()}).code, 0);
  EXPECT_EQ(read_campaign(own).walls.size(), 2u);
  EXPECT_EQ(read_campaign(own).takes.size(), 3u);
  // a folder with such recordings alone gives no campaign
  std::filesystem::create_directories(folder / "walls");
  std::filesystem::copy(own / "wall.h5", folder / "walls/wall.h5");
  expect_refused(run_trilat(folder, {"init", folder / "walls"}),
                 "holds recordings to calibrate by, and no take; `trilat run calibration");
}

TEST(Init, NamesATableBesideARecordingThatIsNotRead) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  write_file(own / "p01/walking.csv", "Trajectories\n100\n");
  write_file(own / "p02/joints.csv", "frame,nose_x,nose_y,nose_z\n0,1,2,3\n");
  const Ended ended = run_trilat(folder, {"init", own.string()});
  EXPECT_THAT(ended.err, AllOf(HasSubstr("walking.csv:1: is a CSV of Vicon Nexus"),
                               HasSubstr("joints.csv:1: has three columns a joint")));
}

// As Windows and other programs name them.
TEST(Init, EndingsOfAnyCaseAndHdf5AreFound) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  std::filesystem::rename(own / "p01/walking.h5", own / "p01/walking.H5");
  std::filesystem::rename(own / "p01/walking.csv", own / "p01/walking.CSV");
  std::filesystem::rename(own / "p02/walking.h5", own / "p02/walking.hdf5");
  const Ended ended = run_trilat(folder, {"init", own.string()});
  EXPECT_THAT(ended.out, AllOf(HasSubstr("p01-walking: walking of p01, 4 sensors; walking.CSV starts "),
                               HasSubstr("p02-walking: walking of p02, 4 sensors; walking.csv starts ")))
      << ended.err;
  EXPECT_EQ(run_trilat(folder, {"info", (own / "p01/walking.H5").string()}).code, 0);
  EXPECT_EQ(run_trilat(folder, {"info", (own / "p01/walking.CSV").string()}).code, 0);
}

// `kinect/p01_walking.h5` and `mocap/p01_walking.csv`.
TEST(Init, RecordingsAndMotionCaptureMayHaveAFolderEach) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  for (const char* name : {"kinect", "mocap"}) std::filesystem::create_directories(own / name);
  for (const std::string participant : {"p01", "p02"}) {
    std::filesystem::rename(own / participant / "walking.h5", own / "kinect" / (participant + "_walking.h5"));
    std::filesystem::rename(own / participant / "walking.csv",
                            own / "mocap" / (participant + "_walking.csv"));
  }
  std::filesystem::copy(own / "mocap/p02_walking.csv", own / "mocap/calm.csv");
  const Ended ended = run_trilat(folder, {"init", own.string()});
  EXPECT_THAT(ended.out, AllOf(HasSubstr("p01_walking of kinect, 4 sensors; p01_walking.csv starts"),
                               HasSubstr("p02_walking of kinect, 4 sensors; p02_walking.csv starts")));
  EXPECT_THAT(ended.err, AllOf(HasSubstr("p01_walking.csv, by its name"),
                               HasSubstr("mocap/calm.csv: motion capture of no recording"),
                               HasSubstr("all recordings lie in kinect, so one participant made them")));
}

TEST(Init, MotionCaptureThatNoRecordingTakesIsNamed) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  std::filesystem::create_directories(own / "exports");
  for (const std::string participant : {"p01", "p02"})
    std::filesystem::rename(own / participant / "walking.csv", own / "exports" / (participant + ".csv"));
  const Ended ended = run_trilat(folder, {"init", own.string()});
  EXPECT_THAT(ended.out, HasSubstr("no motion capture"));
  EXPECT_THAT(ended.err,
              AllOf(HasSubstr("exports/p01.csv and 1 more: motion capture of no recording; put it"),
                    Not(HasSubstr("one participant"))));
}

TEST(Init, ACutRecordingIsNamedAndNotCalledMissing) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  for (const char* participant : {"p01", "p02"})
    std::filesystem::resize_file(own / participant / "walking.h5", 100'000);
  expect_refused(run_trilat(folder, {"init", own.string()}), "holds no recording that can be read: ");
}

TEST(Init, CalibrationsOfOtherNamesAreNamed) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  std::filesystem::rename(own / "calibration.json", own / "rig_may.json");
  expect_refused(run_trilat(folder, {"init", own.string()}),
                 "rig_may.json is a calibration: call the one of this rig calibration.json");
  std::filesystem::copy_file(own / "rig_may.json", own / "p01/calib.json");
  expect_refused(run_trilat(folder, {"init", own.string()}),
                 "p01/calib.json and rig_may.json are calibrations: call");
}

TEST(Init, WhatIsDoneInASessionWithoutANameIsSimulatedWhereItIs) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  for (const char* participant : {"p01", "p02"}) {
    std::filesystem::rename(own / participant / "walking.h5", own / participant / "session.h5");
    std::filesystem::rename(own / participant / "walking.csv", own / participant / "mocap.csv");
  }
  EXPECT_THAT(run_trilat(folder, {"init", own.string()}).out, HasSubstr("p01: simulated of p01, 4 sensors"));
  EXPECT_THAT(run_trilat(folder, {"init", own.string(), "--force", "--activity", "walking"}).out,
              HasSubstr("p01: walking of p01, 4 sensors"));
}

TEST(Init, SaysWhatIsMissingAndReplacesNothing) {
  const ScratchFolder folder;
  const auto own = own_folder(folder);
  std::filesystem::remove(own / "p01/walking.csv");  // without mocap it goes on
  std::filesystem::rename(own / "calibration.json", own / "kept");
  expect_refused(run_trilat(folder, {"init", own.string()}),
                 "has no calibration.json in its folder or above");
  std::filesystem::rename(own / "kept", own / "calibration.json");
  const Ended ended = run_trilat(folder, {"init", own.string()});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, HasSubstr("no motion capture: each sensor is predicted from the others"));
  EXPECT_EQ(run_trilat(folder, {"init", own.string(), "--force"}).code, 0);
  expect_refused(run_trilat(folder, {"init", (folder / "absent").string()}), "must be the folder");
  std::filesystem::create_directories(folder / "empty");
  expect_refused(run_trilat(folder, {"init", (folder / "empty").string()}), "holds no recording");
}

}  // namespace
}  // namespace trilat
