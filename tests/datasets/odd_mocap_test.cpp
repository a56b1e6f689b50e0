// SPDX-License-Identifier: MIT
// Exports with rows, headers or assets that cannot be taken as they are.
#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/datasets/motive_texts.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using namespace motive;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(ReadMocap, TreatsEverySpellingOfNoNumberAsMissing) {
  const WholeTake take = read(keys("1.23") + "\n" + kMarkerHeadings +
                              "0,0,NAN,nan,NaN\n1,0.01,-1.#IND0000,#IND,1.#QNAN\n"
                              "2,0.02,inf,-Infinity,1.#INF\n3,0.03,NA,N/A,#N/A\n4,0.04,None,null,None\n"
                              "5,0.05, 1 ,\"2\",+3e0\n");
  for (int i = 0; i < 5; ++i)
    EXPECT_FALSE(take.frames.at(static_cast<std::size_t>(i)).poses[0].has_position());
  EXPECT_EQ(take.frames.at(5).poses[0].position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(take.anomalies.not_finite_cells, 15);
}

// A quote amid a cell is an inch sign; one at its start holds commas and line ends.
TEST(ReadMocap, QuotesInNotesOpenNoCellUnlessTheyBeginIt) {
  for (const char* notes : {"a ball of 3\" on a stick", "\"say \"\"go\"\", then\nwalk\"", "\"\""}) {
    std::string text = keys("1.23");
    text.replace(text.find("Take Notes,,"), 12, std::string("Take Notes,") + notes + ",");
    EXPECT_EQ(read(text + "\n" + kHeadings + kRows).frames.size(), 3u) << notes;
  }
}

TEST(ReadMocap, DropsHalfAPositionAndCountsIt) {
  const WholeTake take =
      read(keys("1.23") + "\n" + kHeadings + "0,0,0,0,,1,1,2,3,,4,,6\n1,0.01,0,0,0,2,1,2,3,,4,5,6\n");
  EXPECT_TRUE(take.frames.at(0).poses[0].has_position());
  EXPECT_FALSE(take.frames[0].poses[1].has_position());
  EXPECT_EQ(take.anomalies.partial_poses, 1);
}

TEST(ReadMocap, RotationsAreNotReadAndAssetsWithNothingElseHaveNoPosition) {
  const WholeTake take =
      read(keys("1.23") + "\n,Type" + repeat(",Bone", 3) + "\n,Name" + repeat(",b", 3) + "\n,ID" +
           repeat(",1", 3) + "\n,,Rotation,Rotation,Rotation\nFrame,Time (Seconds),X,Y,Z\n0,0,a,b,c\n");
  ASSERT_EQ(take.header.assets.size(), 1u);
  EXPECT_FALSE(take.header.assets[0].has_position);
  EXPECT_FALSE(take.frames.at(0).poses[0].has_position());
}

TEST(ReadMocap, RefusesTheRowsOfArenaWithTheLineThatConvertsThem) {
  for (const char* first : {"comment,\"own\"", "righthanded", "info,version,1.1", "frame,0,0,0,0"})
    EXPECT_THAT(csv_refusal(std::string(first) + "\n").problem,
                AllOf(HasSubstr("in the rows of Arena"), HasSubstr("python3 -m trilat.convert arena "),
                      HasSubstr(".motive.csv")));
}

TEST(ReadMocap, LivesWithCutAndOverlongRows) {
  const WholeTake take =
      read(keys("1.23") + "\n" + kHeadings + "0,0,0,0,0,1,1,2,3\n1,0.01,0,0,0,1,1,2,3,,4,5,6,7\n2,0.02\n\n");
  ASSERT_EQ(take.frames.size(), 3u);
  EXPECT_EQ(take.frames[0].poses[0].position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(take.frames[0].poses[1].has_position());
  EXPECT_EQ(take.frames[1].poses[1].position_m, Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(take.frames[2].poses[0].has_position());
  EXPECT_EQ(take.anomalies.rows_with_extra_fields, 1);
}

// Without a rate in the header the printed times are all there is.
TEST(ReadMocap, DropsRowsWhoseTimeDoesNotAdvanceWhereTimesAreAllThereIs) {
  std::string head = keys("1.23");
  for (const std::string key : {"Capture Frame Rate", "Export Frame Rate"})
    if (const std::size_t at = head.find(key); at != std::string::npos)
      head.erase(at, head.find(',', head.find(',', at) + 1) + 1 - at);
  const WholeTake take =
      read(head + "\n" + kMarkerHeadings + "0,0,1,2,3\n1,0.01,1,2,4\n2,0.01,9,9,9\n3,0.02,1,2,5\n");
  ASSERT_EQ(take.frames.size(), 3u);
  EXPECT_EQ(take.frames[2].poses[0].position_m.z(), 5.0);
  EXPECT_EQ(take.anomalies.repeated_frames, 1);
}

TEST(ReadMocap, DropsRowsWhoseFrameDoesNotAdvance) {
  const WholeTake take = read(keys("1.23") + "\n" + kMarkerHeadings +
                              "3,0,1,2,3\n3,0,9,9,9\n4,0.01,1,2,4\n2,0,9,9,9\n5,0.02,1,2,5\n");
  ASSERT_EQ(take.frames.size(), 3u);
  EXPECT_EQ(take.frames[2].poses[0].position_m.z(), 5.0);
  EXPECT_EQ(take.anomalies.repeated_frames, 2);
}

TEST(ReadMocap, DoesNotTrustTheRowInWhichTheFileEnds) {
  const std::string whole = keys("1.23") + "\n" + kMarkerHeadings + "0,0,1,2,3\n";
  EXPECT_FALSE(read(whole).anomalies.truncated_last_row);
  const WholeTake cut = read(whole + "1,0.01,1,2");
  EXPECT_EQ(cut.frames.size(), 1u);
  EXPECT_TRUE(cut.anomalies.truncated_last_row);
  const WholeTake cut_in_number = read(whole + "1,0.01,1,2,-");
  ASSERT_EQ(cut_in_number.frames.size(), 2u);
  EXPECT_FALSE(cut_in_number.frames[1].poses[0].has_position());
  EXPECT_TRUE(cut_in_number.anomalies.truncated_last_row);
  EXPECT_EQ(read(keys("1.23") + "\n" + kMarkerHeadings + "12").frames.size(), 0u);
  EXPECT_EQ(read(keys("1.23") + "\n" + kMarkerHeadings + "12,0,1,2,3").frames.at(0).time.ns, 0);
}

TEST(ReadMocap, SaysInWhichUnitTheTimesAre) {
  const auto refused = [](const std::function<double(int)>& time) {
    std::string text = keys("1.23") + "\n" + kMarkerHeadings;
    for (int i = 0; i < 40; ++i) text += fmt::format("{},{:.6f},1,2,3\n", i, time(i));
    return csv_refusal(text).problem;
  };
  EXPECT_THAT(refused([](int i) { return 10.0 * i; }),
              HasSubstr("As milliseconds both agree: divide the times by 1000"));
  EXPECT_THAT(refused([](int i) { return 1e4 * i; }), HasSubstr("As microseconds both agree"));
  EXPECT_THAT(refused([](int i) { return 1.0 * i; }),
              HasSubstr("As frame numbers both agree: divide the times by the rate"));
  EXPECT_THAT(refused([](int i) { return 0.02 * i; }), Not(HasSubstr("agree")));
  for (const double step_s : {0.1, 0.02, 0.05})  // as a spreadsheet rounds them
    EXPECT_EQ(refused([step_s](int i) { return step_s * std::round(0.01 * i / step_s); }), "was read")
        << step_s;
  // every hundredth frame, of a file whose true rate is 1 % lower
  std::string sparse = keys("1.23") + "\n" + kMarkerHeadings;
  for (int i = 0; i < 40; ++i) sparse += fmt::format("{},{:.6f},1,2,3\n", 100 * i, 1.01 * i);
  EXPECT_THAT(csv_refusal(sparse).problem, HasSubstr("by the times the rate is 99.0099 Hz"));
  EXPECT_THAT(refused([](int) { return 0.5; }),
              HasSubstr("the times of all rows are 0.5; write frame / rate"));
}

TEST(ReadMocap, NamesTheLineAndTheAssetOfABadCell) {
  const Refusal text = csv_refusal(keys("1.23") + "\n" + kHeadings + kRows + "3,0.03,0,0,0,1,1,abc,3\n");
  EXPECT_EQ(text.place, "F:11");
  EXPECT_THAT(text.problem,
              AllOf(HasSubstr("column 8"), HasSubstr("rigid_body:Wand, position Y"), HasSubstr("\"abc\"")));
  const Refusal far = csv_refusal(keys("1.23") + "\n" + kHeadings + "0,0,0,0,0,1,1,1,1,,4,5,1001\n");
  EXPECT_EQ(far.place, "F:8");
  EXPECT_THAT(far.problem, AllOf(HasSubstr("marker:Wand, position Z"), HasSubstr("100 m")));
  const Refusal frame = csv_refusal(keys("1.23") + "\n" + kHeadings + "0.5,0,0,0,0,1,1,1,1\n");
  EXPECT_EQ(frame.place, "F:8");
  EXPECT_THAT(frame.problem, HasSubstr("frame number"));
  EXPECT_THAT(csv_refusal(keys("1.23") + "\n" + kMarkerHeadings + "0,1e300,1,2,3\n").problem,
              HasSubstr("column 2 (time)"));
}

TEST(ReadMocap, SaysWhichHeaderValueIsWrong) {
  const Refusal unit = csv_refusal(keys("1.23", "Furlongs") + "\n" + kHeadings);
  EXPECT_EQ(unit.place, "F:1");
  EXPECT_THAT(unit.problem, AllOf(HasSubstr("\"Length Units\" is \"Furlongs\""), HasSubstr("Feet")));
  std::string rate = keys("1.23");
  rate.replace(rate.find("Export Frame Rate,100"), 21, "Export Frame Rate,-10");
  EXPECT_THAT(csv_refusal(rate + "\n" + kHeadings).problem, HasSubstr("Export Frame Rate"));
}

TEST(ReadMocap, RefusesPositionColumnsThatAreNotComplete) {
  const Refusal refusal = csv_refusal(
      keys("1.23") +
      "\n,Type,Marker,Marker\n,Name,a,a\n,ID,1,1\n,,Position,Position\nFrame,Time (Seconds),X,Y\n0,0,1,2\n");
  EXPECT_EQ(refusal.place, "F:7");
  EXPECT_THAT(refusal.problem, HasSubstr("marker \"a\""));
}

TEST(ReadMocap, RefusesWhatIsNoExportWithOneClearMessage) {
  EXPECT_EQ(csv_refusal("").place, "F:1");
  EXPECT_THAT(csv_refusal("").problem, HasSubstr("empty"));
  for (const std::string& text : {std::string("hello\nworld\n"), std::string("\x89HDF\r\n\x1a\n\0\0\0\0", 12),
                                  std::string(5000, '\0'), std::string("HIERARCHY\nROOT Hips\n")}) {
    EXPECT_EQ(csv_refusal(text).place, "F:1");
    EXPECT_THAT(
        csv_refusal(text).problem,
        testing::ContainsRegex(
            "is neither motion capture|is HDF5|is a binary file|begins with zeros|is text in UTF-16|is BVH"));
  }
  EXPECT_THAT(csv_refusal("0,0.000000,1,2,3\n").problem, HasSubstr("header switched on"));
  EXPECT_THAT(csv_refusal("Format Version;1.23;Take Name\n").problem, HasSubstr("semicolons"));
  EXPECT_THAT(csv_refusal(keys("1.23") + "\n0,0,1\n").problem, HasSubstr("Frame,Time"));
  EXPECT_THROW(read_mocap("/nowhere/take.csv"), InputError);
}

TEST(ReadMocap, RefusesALineThatNeverEnds) {
  const Refusal refusal =
      csv_refusal(keys("1.23") + "\n" + kMarkerHeadings + "0,0,1,2,3\n" + std::string(18u << 20, '1') + "\n");
  EXPECT_EQ(refusal.place, "F:9");
  EXPECT_THAT(refusal.problem, HasSubstr("16 MiB"));
}

TEST(MocapAssets, AreFoundByNameAndTypeAndListedWhenNot) {
  const MocapHeader header = read(keys("1.23") + "\n" + kHeadings + kRows).header;
  EXPECT_EQ(find_asset(header, "rigid_body:Wand", "map.json /head"), 0u);
  EXPECT_EQ(find_asset(header, "marker:Wand", "map.json /head"), 1u);
  EXPECT_EQ(find_asset(header, "Wand#2A:77", "map.json /head"), 1u);
  try {
    find_asset(header, "Wand", "map.json /head");
    FAIL() << "an ambiguous name was taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.place(), "map.json /head");
    EXPECT_THAT(error.problem(), HasSubstr("rigid_body:Wand, marker:Wand"));
  }
  try {
    find_asset(header, "Wind", "map.json /head");
    FAIL() << "an unknown name was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.problem(),
                AllOf(HasSubstr("\"Wind\""), HasSubstr("rigid_body:Wand"), Not(HasSubstr("more"))));
  }
}

TEST(MocapAssets, ALongListIsCut) {
  MocapHeader header;
  for (int i = 0; i < 27; ++i)
    header.assets.push_back({.type = AssetType::marker,
                             .name = std::string("m").append(std::to_string(i)),
                             .id = {},
                             .parent = {}});
  try {
    find_asset(header, "x", "map");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.problem(), AllOf(HasSubstr("marker:m19 and 7 more"), Not(HasSubstr("m20"))));
  }
}

// Bones of a local export are relative to their parents; its markers and rigid bodies are not.
TEST(MocapHeader, BonesOfALocalExportAreNoPlaces) {
  const auto refused = [](AssetType type, const char* space) {
    MocapHeader header;
    header.coordinate_space = space;
    header.assets = {{type, "a", "", "", true}};
    return message_of([&] { assets_of_joint(header, {"a"}, "mapping.json /joints/head"); });
  };
  for (const AssetType type : {AssetType::bone, AssetType::bone_marker}) {
    EXPECT_THAT(refused(type, "Local"), HasSubstr("relative to its parent"));
    EXPECT_EQ(refused(type, "Global"), "no error");
  }
  for (const AssetType type : {AssetType::marker, AssetType::rigid_body, AssetType::rigid_body_marker})
    EXPECT_EQ(refused(type, "Local"), "no error");
}

}  // namespace
}  // namespace trilat
