// SPDX-License-Identifier: MIT
#include "datasets/mocap/read_mocap.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/mocap/mocap_text.h"
#include "tests/datasets/temporary_file.h"
#include "tests/support/scratch.h"
#include "tests/support/whole_take.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string keys(const std::string& version, const std::string& unit = "Meters") {
  return "Format Version," + version +
         ",Take Name,walk,Take Notes,,Capture Frame Rate,100.000000,Export Frame Rate,100.000000,Capture "
         "Start Time,2024-05-01 10.00.00.000 DU.,Total Frames in Take,9,Total Exported Frames,9,Rotation "
         "Type,Quaternion,Length Units," +
         unit + ",Coordinate Space,Global\n";
}

std::string repeat(const std::string& text, int count) {
  std::string result;
  for (int i = 0; i < count; ++i) result += text;
  return result;
}

// A rigid body with an error column, and a marker of the same name.
const std::string kHeadings = ",Type" + repeat(",Rigid Body", 8) + repeat(",Marker", 3) + "\n,Name" +
                              repeat(",Wand", 11) + "\n,ID" + repeat(",\"1F\"", 8) + repeat(",\"2A:77\"", 3) +
                              "\n,,Rotation,Rotation,Rotation,Rotation," +
                              "Position,Position,Position,Mean Marker Error" + repeat(",Position", 3) +
                              "\nFrame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z\n";
const std::string kRows =
    "0,0.000000,0,0,0,1,1.5,2.5,-3.5,0.0001,4,5,6\n"
    "1,0.010000,0,0,0,1,1.6,2.5,-3.5,0.0001,,,\n"
    "2,0.020000,,,,,,,,,4,5,7\n";

const std::string kMarkerHeadings =
    ",Type,Marker,Marker,Marker\n,Name,a,a,a\n,ID,\"1\",\"1\",\"1\"\n,,Position,Position,Position\n"
    "Frame,Time (Seconds),X,Y,Z\n";

WholeTake read(const std::string& text) { return whole_take(TemporaryFile(text).path()); }

struct Refusal {
  std::string place;
  std::string problem;
};

Refusal csv_refusal(const std::string& text) {
  const TemporaryFile file(text);
  try {
    whole_take(file.path());
  } catch (const InputError& error) {
    const std::string& place = error.place();
    const std::size_t size = file.path().string().size();
    if (place.starts_with(file.path().string()))
      return {std::string("F").append(place, size), error.problem()};
    return {place, error.problem()};
  }
  return {"", "was read"};
}

void expect_wand(const WholeTake& take) {
  ASSERT_EQ(take.header.assets.size(), 2u);
  EXPECT_EQ(key_of(take.header, 0), "rigid_body:Wand");
  EXPECT_EQ(key_of(take.header, 1), "marker:Wand");
  ASSERT_EQ(take.frames.size(), 3u);
  EXPECT_EQ(take.frames[0].poses[0].position_m, Eigen::Vector3d(1.5, 2.5, -3.5));
  EXPECT_EQ(take.frames[1].poses[0].position_m, Eigen::Vector3d(1.6, 2.5, -3.5));
  EXPECT_FALSE(take.frames[2].poses[0].has_position());
  EXPECT_EQ(take.frames[0].poses[1].position_m, Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(take.frames[1].poses[1].has_position());
  EXPECT_EQ(take.frames[2].poses[1].position_m, Eigen::Vector3d(4, 5, 7));
  EXPECT_EQ(take.frames[2].time.ns, 20'000'000);
}

TEST(ReadMocap, ReadsEveryVersionWithLabelledRows) {
  for (const char* version : {"1.22", "1.23", "1.24", "1.25"}) {
    const WholeTake take = read(keys(version) + "\n" + kHeadings + kRows);
    expect_wand(take);
    EXPECT_EQ(take.header.format, std::string("Motive CSV ") + version);
  }
}

TEST(ReadMocap, KeepsWhatTheHeaderSays) {
  const MocapHeader header = read(keys("1.23") + "\n" + kHeadings + kRows).header;
  EXPECT_EQ(header.take_name, "walk");
  EXPECT_EQ(header.take_notes, "");
  EXPECT_EQ(header.capture_start_text, "2024-05-01 10.00.00.000 DU.");
  EXPECT_EQ(header.capture_rate_hz, 100.0);
  EXPECT_EQ(header.export_rate_hz, 100.0);
  EXPECT_EQ(header.total_exported_frames, 9);
  EXPECT_FALSE(header.capture_start_frame);
  EXPECT_EQ(header.coordinate_space, "Global");
  EXPECT_EQ(header.assets[1].id, "2A:77");
}

TEST(ReadMocap, ReadsVersionsWhoseRowsHaveNoLabels) {
  for (const char* version : {"1.2", "1.21"}) {
    const std::string rows =
        "\n,,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid "
        "Body,Marker,Marker,Marker\n," +
        repeat(",Wand", 11) + "\n," + repeat(",\"1F\"", 11) +
        "\n,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Error Per "
        "Marker,Position,Position,Position\n"
        "Frame,Time,X,Y,Z,W,X,Y,Z,,X,Y,Z\n";
    expect_wand(read(keys(version) + rows + kRows));
  }
}

TEST(ReadMocap, FindsTheColumnsBehindATimeCode) {
  const WholeTake take = read(keys("1.24") +
                              "\n,Type,,Marker,Marker,Marker\n,Name,,a,a,a\n,ID,,\"1\",\"1\",\"1\"\n,,,"
                              "Position,Position,Position\nFrame,Time (Seconds),TimeCode,X,Y,Z\n"
                              "7,0.07,15:26:46:12.02,1,2,3\n");
  EXPECT_EQ(take.frames.at(0).poses.at(0).position_m, Eigen::Vector3d(1, 2, 3));
}

TEST(ReadMocap, KeepsTheParentsOfBones) {
  const WholeTake take =
      read(keys("1.25") +
           "\n,Type,Bone,Bone,Bone\n,Name,P:Head,P:Head,P:Head\n,ID,1,1,1\n,Parent,P:Neck,P:Neck,P:Neck\n,,"
           "Position,Position,Position\nFrame,Time (Seconds),X,Y,Z\n0,0,1,2,3\n");
  EXPECT_EQ(take.header.assets.at(0).type, AssetType::bone);
  EXPECT_EQ(take.header.assets[0].parent, "P:Neck");
}

TEST(ReadMocap, ReadsWhatASpreadsheetHasSaved) {
  std::string text = std::string("\xEF\xBB\xBF").append(keys("1.23"));
  text.insert(text.size() - 1, ",,,,");
  text += ",,,,,,,,,,,,,,,,\n" + kHeadings + kRows + ",,,,,,\n";
  std::string crlf;
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const WholeTake take = read(crlf);
  expect_wand(take);
  EXPECT_EQ(take.header.coordinate_space, "Global");
  EXPECT_EQ(take.anomalies.rows_with_extra_fields, 0);
}

TEST(ReadMocap, TakesCommasInTheTakeName) {
  std::string text = keys("1.23") + "\n" + kHeadings + kRows;
  text.replace(text.find("walk"), 4, "walk, then run");
  EXPECT_EQ(read(text).header.take_name, "walk,then run");
  text.replace(text.find("walk, then run"), 14, "\"walk, then run\"");
  EXPECT_EQ(read(text).header.take_name, "walk, then run");
}

TEST(ReadMocap, ConvertsEveryUnitToMetres) {
  const std::vector<std::pair<std::string, double>> units{
      {"Meters", 1.0}, {"Centimeters", 0.01}, {"Millimeters", 0.001}, {"Inches", 0.0254}, {"Feet", 0.3048}};
  for (const auto& [unit, metres] : units) {
    const WholeTake take = read(keys("1.23", unit) + "\n" + kMarkerHeadings + "0,0,10,20,-5\n");
    EXPECT_TRUE(
        take.frames.at(0).poses.at(0).position_m.isApprox(Eigen::Vector3d(10, 20, -5) * metres, 1e-15))
        << unit;
  }
}

TEST(ReadMocap, MakesTimeFromTheFrameIndexNotFromRoundedDecimals) {
  std::string head = keys("1.23");
  head.replace(head.find("Export Frame Rate,100.000000"), 28, "Export Frame Rate,360.000000");
  const WholeTake take =
      read(head + "\n" + kMarkerHeadings + "0,0.000,1,2,3\n1,0.003,1,2,3\n2,0.006,1,2,3\n");
  EXPECT_EQ(take.frames.at(1).time.ns, 2'777'778);
  EXPECT_EQ(take.frames.at(2).time.ns, 5'555'556);
  EXPECT_EQ(take.anomalies.printed_time_differs, 0);
}

TEST(ReadMocap, FrameTimesAreExactAfterADay) {
  EXPECT_EQ(duration_of_frames(0, 120'000'000).ns, 0);
  EXPECT_EQ(duration_of_frames(1, 120'000'000).ns, 8'333'333);
  EXPECT_EQ(duration_of_frames(2, 120'000'000).ns, 16'666'667);
  EXPECT_EQ(duration_of_frames(86'400LL * 120 + 1, 120'000'000).ns, 86'400'008'333'333);
  EXPECT_EQ(duration_of_frames(29'970'030, 29'970'030).ns, 1'000'000'000'000'000);
}

TEST(ReadMocap, TimeIsZeroAtTheFirstExportedFrameAndGapsStayGaps) {
  const WholeTake take = read(keys("1.23") + "\n" + kMarkerHeadings +
                              "72210,722.1,1,2,3\n72211,722.11,1,2,3\n"
                              "72300,723,1,2,3\n");
  EXPECT_EQ(take.header.first_frame, 72210);
  ASSERT_EQ(take.frames.size(), 3u);
  EXPECT_EQ(take.frames[0].time.ns, 0);
  EXPECT_EQ(take.frames[2].index, 72300);
  EXPECT_EQ(take.frames[2].time.ns, 900'000'000);
  EXPECT_EQ(take.anomalies.printed_time_differs, 0);
}

TEST(ReadMocap, CountsPrintedTimesThatDoNotFitTheRate) {
  const WholeTake take =
      read(keys("1.23") + "\n" + kMarkerHeadings + "0,0,1,2,3\n1,0.02,1,2,3\n2,0.04,1,2,3\n");
  EXPECT_EQ(take.frames.at(2).time.ns, 20'000'000);
  EXPECT_EQ(take.anomalies.printed_time_differs, 1);
}

// Every time is frame / 100 Hz, but one is 0.4 ms late.
TEST(ReadMocap, TellsTheLargestErrorOfThePrintedTimes) {
  const WholeTake take = read(keys("1.23") + "\n" + kHeadings + "10,0.1,,,,,,,,,,,\n15,0.15,,,,,,,,,,,\n" +
                              "16,0.1604,,,,,,,,,,,\n20,0.2,,,,,,,,,,,\n");
  EXPECT_NEAR(take.anomalies.largest_time_error_s, 0.0004, 1e-12);
  EXPECT_TRUE(std::isnan(read(keys("1.23") + "\n" + kHeadings).anomalies.largest_time_error_s));
}

TEST(ReadMocap, UsesPrintedTimesOnlyWhenNoRateIsStated) {
  std::string head = keys("1.23");
  head.erase(head.find("Capture Frame Rate"),
             head.find("Capture Start Time") - head.find("Capture Frame Rate"));
  const WholeTake take = read(head + "\n" + kMarkerHeadings + "5,1.5,1,2,3\n6,1.75,1,2,3\n");
  EXPECT_TRUE(std::isnan(take.header.export_rate_hz));
  EXPECT_EQ(take.frames.at(1).time.ns, 250'000'000);
  EXPECT_EQ(csv_refusal(head + "\n" + kMarkerHeadings + "5,,1,2,3\n").place, "F:8");
}

TEST(ReadMocap, ReadsAnExportWithoutAnyAsset) {
  const WholeTake take = read(keys("1.23") +
                              "\n,Type\n,Name\n,ID\n,\nFrame,Time (Seconds)\n"
                              "0,0.000000\n1,0.010000\n");
  EXPECT_TRUE(take.header.assets.empty());
  EXPECT_EQ(take.frames.size(), 2u);
}

TEST(ReadMocap, ReadsAHeaderWithoutRows) {
  EXPECT_TRUE(read(keys("1.23") + "\n" + kMarkerHeadings).frames.empty());
}

TEST(ReadMocap, GivesUnnamedColumnsAName) {
  const WholeTake take = read(keys("1.23") +
                              "\n,Type,Marker,Marker,Marker\n,Name,,,\n,ID,,,\n,,Position,Position,"
                              "Position\nFrame,Time (Seconds),X,Y,Z\n0,0,1,2,3\n");
  EXPECT_EQ(key_of(take.header, 0), "marker:column 3");
}

TEST(ReadMocap, KeepsTwoAssetsOfOneTypeAndNameApart) {
  const std::string text = keys("1.23") + "\n,Type" + repeat(",Marker", 9) + "\n,Name" + repeat(",a", 9) +
                           "\n,ID" + repeat(",1", 3) + repeat(",2", 6) + "\n," + repeat(",Position", 9) +
                           "\nFrame,Time (Seconds)" + repeat(",X,Y,Z", 3) + "\n0,0,1,1,1,2,2,2,3,3,3\n";
  const WholeTake take = read(text);
  ASSERT_EQ(take.header.assets.size(), 3u);
  EXPECT_EQ(take.frames.at(0).poses[2].position_m.x(), 3.0);
  EXPECT_EQ(find_asset(take.header, "a#1", "map"), 0u);
  EXPECT_THROW(find_asset(take.header, "marker:a#2", "map"), InputError);
}

TEST(ReadMocap, TreatsEverySpellingOfNoNumberAsMissing) {
  const WholeTake take = read(keys("1.23") + "\n" + kMarkerHeadings +
                              "0,0,NAN,nan,NaN\n1,0.01,-1.#IND0000,#IND,1.#QNAN\n"
                              "2,0.02,inf,-Infinity,1.#INF\n3,0.03, 1 ,\"2\",+3e0\n");
  for (int i = 0; i < 3; ++i)
    EXPECT_FALSE(take.frames.at(static_cast<std::size_t>(i)).poses[0].has_position());
  EXPECT_EQ(take.frames.at(3).poses[0].position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(take.anomalies.not_finite_cells, 9);
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

TEST(ReadMocap, ReadsOnlyWhatIsWanted) {
  const TemporaryFile file(keys("1.23") + "\n" + kHeadings + "0,0,x,x,x,x,x,x,x,x,4,5,6\n");
  const MocapTake take = read_mocap(file.path(), {.assets = {{1}}});
  ASSERT_EQ(take.position_m.size(), 2u);
  EXPECT_TRUE(take.position_m[0].empty());
  EXPECT_EQ(take.position_m[1], std::vector{Eigen::Vector3d(4, 5, 6)});
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
    EXPECT_THAT(csv_refusal(text).problem,
                testing::ContainsRegex("is neither motion capture|is HDF5|is text in UTF-16|is BVH"));
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

TEST(ReadMocap, PlainDecimalsAreReadAsTheLibraryReadsThem) {
  for (const char* text : {"0", "-0.000001", "3.717927", "-2659.741943", "123456789012345", ".5", "5.", "0.1",
                           "0.30000000000000", "-0"}) {
    double value = 1.0;
    const std::string_view view(text);
    ASSERT_EQ(parse_plain_decimal(view.data(), view.data() + view.size(), value), view.data() + view.size())
        << text;
    EXPECT_EQ(value, std::strtod(text, nullptr)) << text;
  }
  for (const char* text :
       {"", "-", ".", "1e3", "1234567890123456", "99999999999999999999999999", "1.5x", " 1", "+1", "nan"}) {
    double value = 1.0;
    const std::string_view view(text);
    EXPECT_EQ(parse_plain_decimal(view.data(), view.data() + view.size(), value), nullptr) << text;
  }
}

void expect_same(const WholeTake& a, const WholeTake& b) {
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].index, b.frames[i].index);
    EXPECT_EQ(a.frames[i].time, b.frames[i].time);
    for (std::size_t j = 0; j < a.header.assets.size(); ++j) {
      EXPECT_EQ(a.frames[i].poses[j].has_position(), b.frames[i].poses[j].has_position());
      if (a.frames[i].poses[j].has_position()) {
        EXPECT_EQ(a.frames[i].poses[j].position_m, b.frames[i].poses[j].position_m);
      }
    }
  }
}

WholeTake read_in_blocks(const std::string& text, std::size_t block_bytes) {
  const TemporaryFile file(text);
  return whole_take(file.path(), {.block_bytes = block_bytes});
}

TEST(ReadMocap, ReadsTheSameInBlocksOfAnySize) {
  for (const std::string& text : {keys("1.23") + "\n" + kHeadings + kRows}) {
    const WholeTake whole = read(text);
    for (const std::size_t block_bytes : {1u, 2u, 3u, 7u, 64u, 1000u})
      expect_same(read_in_blocks(text, block_bytes), whole);
  }
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
