// SPDX-License-Identifier: MIT
#include "datasets/mocap/read_mocap.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "datasets/mocap/mocap_text.h"
#include "tests/datasets/motive_texts.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using namespace motive;
using testing::HasSubstr;

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

TEST(ReadMocap, TakesTheTimeFromBehindATimeCode) {
  const WholeTake take = read(
      "Format Version,1.24,Take Name,walk,Length Units,Meters\n"
      "\n,,Type,Marker,Marker,Marker\n,,Name,a,a,a\n,,ID,1,1,1\n,,,"
      "Position,Position,Position\nFrame,TimeCode,Time (Seconds),X,Y,Z\n"
      "7,15:26:46:12.02,0.5,1,2,3\n8,15:26:46:12.03,0.51,1,2,3\n9,15:26:46:12.04,0.52,1,2,4\n");
  EXPECT_NEAR((take.frames.at(2).time - take.frames.at(0).time).seconds(), 0.02, 1e-9);
  EXPECT_EQ(take.frames.at(2).poses.at(0).position_m, Eigen::Vector3d(1, 2, 4));
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

TEST(ReadMocap, ReadsOnlyWhatIsWanted) {
  const TemporaryFile file(keys("1.23") + "\n" + kHeadings + "0,0,x,x,x,x,x,x,x,x,4,5,6\n");
  const MocapTake take = read_mocap(file.path(), {.assets = {{1}}});
  ASSERT_EQ(take.position_m.size(), 2u);
  EXPECT_TRUE(take.position_m[0].empty());
  EXPECT_EQ(take.position_m[1], std::vector{Eigen::Vector3d(4, 5, 6)});
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

}  // namespace
}  // namespace trilat
