// SPDX-License-Identifier: MIT
// Truth that is nothing but markers: TRC.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "tests/datasets/temporary_file.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"
#include "tests/support/whole_take.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

WholeTake marker_take(const std::string& text) { return whole_take(TemporaryFile(text).path()); }
std::string marker_refusal(const std::string& text) {
  return message_of([&] { marker_take(text); });
}

std::string trc_text(const std::string& rows, const std::string& units = "mm",
                     const std::string& frames = "3",
                     const std::string& labels = "Frame#\tTime\ta\t\t\tb\t\t\n") {
  return "PathFileType\t4\t(X/Y/Z)\twalk.trc\n"
         "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames"
         "\n"
         "100\t200\t" +
         frames + "\t2\t" + units + "\t100\t1\t3\n" + labels + "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n" + rows;
}

const std::string kTrcRows =
    "1\t0.000\t1500\t250.5\t-1e2\t4\t5\t6\n"
    "2\t0.010\t1501\t250.5\t-1e2\t\t\t\n"
    "3\t0.020\tnan\tNaN\tNAN\t4\t5\t7\n";

void expect_two_markers(const WholeTake& take) {
  EXPECT_EQ(take.header.export_rate_hz, 100.0);
  EXPECT_EQ(take.header.length_unit, LengthUnit::millimetre);
  EXPECT_EQ(take.header.total_exported_frames, 3);
  ASSERT_EQ(take.header.assets.size(), 2u);
  EXPECT_EQ(key_of(take.header, 0), "marker:a");
  EXPECT_EQ(key_of(take.header, 1), "marker:b");
  ASSERT_EQ(take.frames.size(), 3u);
  EXPECT_EQ(take.frames[2].time - take.frames[0].time, Duration{20'000'000});
  EXPECT_TRUE(take.frames[0].poses[0].position_m.isApprox(Eigen::Vector3d(1.5, 0.2505, -0.1), 1e-15));
  EXPECT_TRUE(take.frames[2].poses[1].position_m.isApprox(Eigen::Vector3d(0.004, 0.005, 0.007), 1e-15));
  EXPECT_FALSE(take.frames[1].poses[1].has_position());
  EXPECT_FALSE(take.frames[2].poses[0].has_position());
  EXPECT_EQ(take.anomalies.repeated_frames, 0);
  EXPECT_EQ(take.anomalies.rows_with_extra_fields, 0);
}

TEST(TrcReader, GivesMarkersInMetresWithTheirGaps) {
  const WholeTake take = marker_take(trc_text(kTrcRows));
  expect_two_markers(take);
  EXPECT_EQ(take.header.format, "TRC");
  EXPECT_EQ(take.header.first_frame, 1);
  EXPECT_EQ(take.anomalies.not_finite_cells, 3);
}

TEST(TrcReader, GoesByTheUnitOfTheHeader) {
  const WholeTake take = marker_take(trc_text("1\t0\t1.5\t2\t3\t4\t5\t6\n", "m", "1"));
  EXPECT_EQ(take.frames.at(0).poses[0].position_m, Eigen::Vector3d(1.5, 2.0, 3.0));
  EXPECT_THAT(marker_refusal(trc_text(kTrcRows, "parsec")), AllOf(HasSubstr(":3"), HasSubstr("\"Units\"")));
}

TEST(TrcReader, RefusesMillimetresThatTheHeaderCallsMetres) {
  EXPECT_THAT(marker_refusal(trc_text(kTrcRows, "m")),
              AllOf(HasSubstr(":7"), HasSubstr("marker:a, position X"), HasSubstr("another unit")));
}

TEST(MotionCaptureFiles, TakeRowsThatEndWithATabAndALastOneWithoutALineEnd) {
  std::string rows = "1\t0\t1\t2\t3\t4\t5\t6\t\r\n2\t0.01\t1\t2\t3\t4\t5\t6.5";
  const WholeTake take = marker_take(trc_text(rows, "mm", "2"));
  ASSERT_EQ(take.frames.size(), 2u);
  EXPECT_DOUBLE_EQ(take.frames[1].poses[1].position_m.z(), 0.0065);
  EXPECT_EQ(take.anomalies.rows_with_extra_fields, 0);
  EXPECT_FALSE(take.anomalies.truncated_last_row);
}

TEST(MotionCaptureFiles, RefuseFewerFramesThanTheHeaderPromises) {
  EXPECT_THAT(marker_refusal(trc_text(kTrcRows, "mm", "5")),
              AllOf(HasSubstr("after 3"), HasSubstr("promises 5")));
  const std::string cut = kTrcRows.substr(0, kTrcRows.rfind('\t'));
  EXPECT_THAT(marker_refusal(trc_text(cut)), AllOf(HasSubstr("after 2"), HasSubstr("promises 3")));
}

TEST(MotionCaptureFiles, RefuseADecimalComma) {
  EXPECT_THAT(marker_refusal(trc_text("1\t0,0\t1,5\t2\t3\t4\t5\t6\n", "mm", "1")),
              AllOf(HasSubstr(":7"), HasSubstr("comma")));
}

TEST(TrcReader, RefusesHeadersThatContradictThemselves) {
  EXPECT_THAT(marker_refusal(trc_text(kTrcRows, "mm", "3", "Frame#\tTime\ta\tb\n")),
              AllOf(HasSubstr(":4"), HasSubstr("column 4 has \"b\"")));
  EXPECT_THAT(marker_refusal(trc_text(kTrcRows, "mm", "3", "1\t0\t1\t2\t3\n")),
              HasSubstr("\"Frame#, Time\""));
  EXPECT_THAT(marker_refusal(trc_text(kTrcRows, "mm", "-1")), HasSubstr("\"NumFrames\" is \"-1\""));
  EXPECT_THAT(marker_refusal("PathFileType\t4\t(X/Z/Y)\tx\n"), HasSubstr("(X/Y/Z)"));
  EXPECT_THAT(marker_refusal("PathFileType\t4\t(X/Y/Z)\tx\n"), HasSubstr("ends before"));
}

TEST(TrcReader, TheRowOfNamesDecides) {
  const WholeTake three = marker_take(
      trc_text("1\t0\t1\t2\t3\t4\t5\t6\t7\t8\t9\n", "mm", "1", "Frame#\tTime\ta\t\t\tb\t\t\tc\n"));
  EXPECT_EQ(three.header.assets.size(), 3u);
  EXPECT_DOUBLE_EQ(three.frames.at(0).poses[2].position_m.z(), 0.009);
  // after markers were taken out
  std::string text = trc_text(kTrcRows);
  text.replace(text.find("X1\tY1\tZ1"), 8, "X5\tY5\tZ5");
  expect_two_markers(marker_take(text));
  // without the row of axes
  text = trc_text(kTrcRows);
  const std::size_t axes = text.find("\t\tX1");
  text.erase(axes, text.find('\n', axes) + 1 - axes);
  expect_two_markers(marker_take(text));
}

TEST(TrcReader, TakesTheHeadersOfOpenCapAndOfOpenSimsExamples) {
  std::string text = trc_text(kTrcRows);
  text.replace(0, text.find('\n'), "PathFileType  4\t(X/Y/Z) /some (old) folder");
  expect_two_markers(marker_take(text));
  text.replace(text.find("100\t200\t3\t2\tmm\t"), 15, "100\t\t200\t\t3\t\t2\t\tmm\t");
  expect_two_markers(marker_take(text));
}

TEST(TrcReader, SaysThatTabsMustStandBetweenTheCells) {
  std::string text = trc_text(kTrcRows);
  for (char& c : text)
    if (c == '\t') c = ' ';
  EXPECT_THAT(marker_refusal(text), AllOf(HasSubstr(":2"), HasSubstr("tabs must stand there")));
}

std::string made_rows(std::size_t count, const std::function<std::pair<int, double>(int)>& frame_and_time) {
  std::string rows;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    const auto [frame, time_s] = frame_and_time(i);
    rows += fmt::format("{}\t{:.4f}\t{}\t2\t3\t4\t5\t6\n", frame, time_s, i);
  }
  return trc_text(rows, "mm", std::to_string(count));
}

TEST(TrcReader, TimesInTheFileWinOverARateThatContradictsThem) {
  const WholeTake wrong = marker_take(made_rows(40, [](int i) { return std::pair{i + 1, 0.02 * i}; }));
  EXPECT_EQ((wrong.frames[3].time - wrong.frames[0].time).ns, 60'000'000);
  EXPECT_EQ(wrong.header.taken_as,
            "its rows are 0.02 s apart, 50 Hz, and its header states 100 Hz: the times count");
  // every second frame under its old number, and the rate of what is left
  const WholeTake halved = marker_take(made_rows(40, [](int i) { return std::pair{2 * i + 1, 0.01 * i}; }));
  EXPECT_EQ((halved.frames[3].time - halved.frames[0].time).ns, 30'000'000);
  std::string text = made_rows(40, [](int i) { return std::pair{i + 1, 0.04 * i}; });
  text.replace(text.find("\n100\t"), 5, "\n0\t");
  const WholeTake unstated = marker_take(text);
  EXPECT_EQ((unstated.frames[3].time - unstated.frames[0].time).ns, 120'000'000);
  EXPECT_THAT(unstated.header.taken_as, HasSubstr("25 Hz, and its header states no rate"));
  const WholeTake right = marker_take(made_rows(40, [](int i) { return std::pair{i + 7, 0.01 * i}; }));
  EXPECT_EQ(right.header.taken_as, "");
  for (const double step_s : {0.001, 0.1, 0.5}) {
    const WholeTake rounded = marker_take(made_rows(300, [=](int i) {
      return std::pair{i + 1, step_s * std::round(0.01 * i / step_s)};
    }));
    EXPECT_EQ(rounded.header.taken_as, "");
    EXPECT_EQ((rounded.frames[7].time - rounded.frames[0].time).ns, 70'000'000);
    EXPECT_EQ(rounded.anomalies.printed_time_differs, 0);
  }
}

// The rate of 100 Hz that the header states counts.
TEST(TrcReader, TimesInAnotherUnitOrThatSayNothingAreSaid) {
  const auto said = [](const std::function<std::pair<int, double>(int)>& frame_and_time) {
    const WholeTake take = marker_take(made_rows(40, frame_and_time));
    EXPECT_EQ(take.frames.size(), 40u);
    EXPECT_EQ((take.frames[3].time - take.frames[0].time).ns, 30'000'000);
    EXPECT_EQ(take.anomalies.printed_time_differs, 0);
    return take.header.taken_as;
  };
  EXPECT_EQ(said([](int i) {
              return std::pair{i + 1, 10.0 * i};
            }),
            "its times are milliseconds: its header's rate of 100 Hz counts");
  EXPECT_EQ(said([](int i) {
              return std::pair{i + 1, 1e4 * i + 5e6};
            }),
            "its times are microseconds: its header's rate of 100 Hz counts");
  EXPECT_EQ(said([](int i) {
              return std::pair{i + 1, 1e7 * i};
            }),
            "its times are nanoseconds: its header's rate of 100 Hz counts");
  EXPECT_EQ(said([](int i) {
              return std::pair{i + 1, 1.0 + i};
            }),
            "its times count frames: its header's rate of 100 Hz counts");
  EXPECT_EQ(said([](int i) {
              return std::pair{i, i + 500.0};
            }),
            "its times count frames: its header's rate of 100 Hz counts");
  EXPECT_EQ(said([](int i) {
              return std::pair{i + 1, 0.0};
            }),
            "its times are all 0: its header's rate of 100 Hz counts");
}

TEST(TrcReader, FramesThatAreMissingAmidAFileAreNoEarlyEnd) {
  const auto holed = [](int first, int from, int count) {
    std::string text = made_rows(60, [first](int i) { return std::pair{i + first, 0.01 * i}; });
    const auto at = [&](int frame) { return text.find(fmt::format("\n{}\t", frame)) + 1; };
    text.erase(at(from), at(from + count) - at(from));
    return marker_refusal(text);
  };
  EXPECT_THAT(holed(1, 21, 15),
              HasSubstr("has 45 of the 60 frames that its header promises; the first that is "
                        "missing is 21. Write the count"));
  EXPECT_THAT(holed(100, 130, 1), HasSubstr("has 59 of the 60 frames"));
  EXPECT_THAT(holed(100, 130, 1), HasSubstr("the first that is missing is 130"));
  const std::string text = made_rows(60, [](int i) { return std::pair{i + 1, 0.01 * i}; });
  EXPECT_THAT(marker_refusal(text.substr(0, text.find("\n50\t") + 1)),
              HasSubstr("the file ends after 49 frames"));
}

TEST(TrcReader, RefusesTimesThatDriftAwayFromTheRate) {
  EXPECT_THAT(
      marker_refusal(made_rows(2000,
                               [](int i) {
                                 return std::pair{i + 1, 0.0101 * i};
                               })),
      HasSubstr("rows are more than a frame off what frame number and rate give: by the times the rate is "
                "99.0099 Hz, and the header states 100 Hz"));
}

TEST(TrcReader, RefusesRowsThatAreShuffledAndCountsThoseThatRepeat) {
  EXPECT_THAT(marker_refusal(made_rows(60,
                                       [](int i) {
                                         return std::pair{i * 7 % 60 + 1, 0.01 * (i * 7 % 60)};
                                       })),
              HasSubstr("of 60 rows stand behind rows of later frames; sort the rows by frame"));
  const WholeTake twice = marker_take(made_rows(60, [](int i) {
    return std::pair{i / 2 + 1, 0.01 * (i / 2)};
  }));
  EXPECT_EQ(twice.anomalies.repeated_frames, 30);
  const WholeTake joined = marker_take(made_rows(60, [](int i) {
    return std::pair{i % 30 + 1, 0.01 * (i % 30)};
  }));
  EXPECT_EQ(joined.anomalies.repeated_frames, 30);
}

TEST(TrcReader, SaysThatCommasAreNoTabs) {
  std::string text = trc_text(kTrcRows);
  std::ranges::replace(text, '\t', ',');
  EXPECT_THAT(marker_refusal(text), AllOf(HasSubstr(":2"), HasSubstr("has commas between its cells; tabs")));
}

TEST(MotionCaptureFiles, FilesOfOtherSystemsAreRefusedByTheirNames) {
  const std::pair<std::string, const char*> files[] = {
      {"NO_OF_FRAMES\t3\nNO_OF_MARKERS\t2\n", "is Qualisys' TSV, which is not read; export C3D"},
      {"version https://git-lfs.github.com/spec/v1\noid sha256:1\n",
       "is a pointer of Git LFS; `git lfs pull`"},
      {std::string("Kaydara FBX Binary  \0\x1A", 22), "is FBX, which is not read"},
      {"\xD0\xCF\x11\xE0\xA1\xB1", "is a spreadsheet; save the table as CSV"},
      {"<!DOCTYPE html>\n<html>\n", "is a web page, saved in place of the file"},
      {"Trajectories\n100\n", "is a CSV of Vicon Nexus"},
      {"HIERARCHY\nROOT Hips\n", "is BVH, whose joints are angles"},
      {"<?xml version=\"1.0\"?>\n", "is XML, such as Xsens' MVNX"},
      {"[{\"frame\": 1}]\n", "is JSON, and no motion capture; write a row for each time and joint instead"},
      {"{\n  \"people\": [{\"pose_keypoints_2d\": [1, 2, 0.5]}]}\n",
       "is JSON of OpenPose, whose key points are pixels"},
      {"{\n  \"bone_list\": [],\n  \"joint_names\": [\"PELVIS\"]}\n",
       "`python3 -m trilat.convert azure-kinect` makes one"},
      {"\x1A\x45\xDF\xA3 and so on", "is a video (Matroska), as the Azure Kinect's recorder writes"},
      {"EVENTS1 and so on", "is a recording of Kinect Studio, which is not read"},
      {"\x89PNG\r\n", "is a picture"},
      {std::string(64, '\0'), "begins with zeros; was it copied whole?"},
      {std::string("\x7F\x02\x03\0\x01", 5), "is a binary file of an unknown format"},
      {"\xFF\xFEt\0i\0", "is text in UTF-16"},
      {std::string("t\0i\0m\0e\0", 8), "is text in UTF-16"},
      {"PK\x03\x04 and so on", "is a spreadsheet or an archive; unpack it, or save the table as CSV"},
      {"\x89HDF\r\n", "is HDF5"},
      {"time_s;joint;x_m;y_m;z_m\n", "has semicolons between its cells"},
      {"time_s\tjoint\tx_m\ty_m\tz_m\n", "has tabs between its cells"},
      {"Format Version\t1.23\tTake Name\twalk\n", "has tabs between its cells"},
      {",Type,Marker,Marker,Marker\n", "is Motive's CSV without its first rows"},
      {"Frame,Time (Seconds),X,Y,Z\n0,0,1,2,3\n", "is Motive's CSV without its first rows"},
      {"frame,nose_x,nose_y,nose_z\n0,1,2,3\n",
       "has three columns a joint (frame, nose_x, nose_y, nose_z, ...)"},
      {"time_s,HipX,HipY,HipZ\n0,1,2,3\n", "has three columns a joint"},
      {"time_s,aX,aY,aZ\n0,1,2,3\n", "has three columns a joint"},
      {"seconds,who\r1,2\r", "ends its lines by carriage returns alone"},
      {"Format Version,1.23,Take Name,walk\r\r,Type,Marker\r", "ends its lines by carriage returns alone"},
      {"PathFileType\t4\t(X/Y/Z)\twalk.trc\rDataRate\tCameraRate\r",
       "ends its lines by carriage returns alone"},
      {"time_s,joint,x_m,y_m,z_m\r0,head,1,2,3\r", "ends its lines by carriage returns alone"},
      {"time_s,HipX,HipY,HipZ\r0,1,2,3\r", "ends its lines by carriage returns alone"},
      {"frame,joint,x_m,y_m,z_m\n0,head,1,2,3\n",
       "a CSV of joints, whose first row is time_s,joint,x_m,y_m,z_m"},
      {"frame,time,hip\n0,0,1\n", "a CSV of joints, whose first row is time_s,joint,x_m,y_m,z_m"},
      {"hello\n", "is neither motion capture (Motive's CSV"}};
  for (const auto& [text, said] : files) EXPECT_THAT(marker_refusal(text), HasSubstr(said));
}

TEST(MotionCaptureFiles, FilesOfOtherSystemsAreRefusedByTheirEndings) {
  const ScratchFolder folder;
  const struct {
    const char *name, *text, *said;
  } files[] = {{"walk.sto", "Marker\nversion=1\n", "is a table of OpenSim"},
               {"walk.mot", "walk\nversion=1\n", "is a motion of OpenSim, whose joints are angles"},
               {"01.ASF", ":version 1.10\n", "is a skeleton of Acclaim"},
               {"01.amc", "#!OML:ASF\n", "is a motion of Acclaim"},
               {"a.skeleton", "1\n1\n", "`python3 -m trilat.convert ntu` makes a session of it"},
               {"a.csv", "1\n1\n", "is neither motion capture"}};
  for (const auto& [name, text, said] : files) {
    write_file(folder / name, text);
    EXPECT_THAT(message_of([&] { read_mocap(folder / name); }), HasSubstr(said));
  }
}

TEST(MotionCaptureFiles, AC3dIsNamedWithTheConverter) {
  const ScratchFolder folder;
  const std::string file = folder / "walk.c3d";
  write_file(file, std::string{2, 0x50}.append(510, '\0'));
  EXPECT_EQ(message_of([&] { read_mocap(file); }), file + ": is C3D; python3 -m trilat.convert c3d " + file +
                                                       " -o " + std::string(folder / "walk.csv"));
}

TEST(MotionCaptureFiles, TheLineThatConvertsCanBePastedWhateverThePath) {
  const ScratchFolder folder;
  const struct {
    const char *name, *text, *line;
  } cases[] = {{"my walk.c3d", "\x02\x50", " c3d '{}/my walk.c3d' -o '{}/my walk.csv'"},
               {"Ann's.c3d", "\x02\x50", " c3d '{}/Ann'\\''s.c3d' -o '{}/Ann'\\''s.csv'"},
               {"walk (2).csv", "righthanded\n", " arena '{}/walk (2).csv' -o '{}/walk (2).motive.csv'"},
               {"$HOME.csv", "frame,0,0,0,0\n", " arena '{}/$HOME.csv' -o '{}/$HOME.motive.csv'"},
               {"plain_1.csv", "lefthanded\n", " arena {}/plain_1.csv -o {}/plain_1.motive.csv"}};
  for (const auto& one : cases) {
    write_file(folder / one.name, std::string(one.text).append(510, '\0'));
    const std::string at = folder.path().string();
    EXPECT_THAT(message_of([&] { read_mocap(folder / one.name); }),
                HasSubstr("python3 -m trilat.convert" + fmt::format(fmt::runtime(one.line), at, at)));
  }
}

// Files of other people's systems.
const std::filesystem::path kMarkerFolder =
    std::filesystem::path(kSourceDir) / ".." / "shared" / "data" / "markers-other" / "opensim-core";

class MarkerRealFiles : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kMarkerFolder))
      GTEST_SKIP() << "the folder " << kMarkerFolder << " is not there";
  }
};

TEST_F(MarkerRealFiles, OddFilesAreReadAsTheyAre) {
  struct Odd {
    const char* name;
    std::size_t markers, frames;
    double last_x_m;  // of the last marker in the last frame
    std::int64_t missing;
  };
  for (const Odd& odd :
       {Odd{"exampleFormat.trc", 3, 5, -0.0517, 2}, Odd{"dataWithEformat.trc", 14, 5, -0.164, 0},
        Odd{"dataWithBlanksForMissingMarkers.trc", 40, 464, 1.77061169, 15'005}}) {
    const WholeTake take = whole_take(kMarkerFolder / odd.name);
    EXPECT_EQ(take.header.assets.size(), odd.markers) << odd.name;
    ASSERT_EQ(take.frames.size(), odd.frames) << odd.name;
    EXPECT_NEAR(take.frames.back().poses.back().position_m.x(), odd.last_x_m, 1e-9) << odd.name;
    std::int64_t missing = 0;
    for (const WholeTake::Frame& frame : take.frames)
      for (const WholeTake::Pose& pose : frame.poses) missing += !pose.has_position();
    EXPECT_EQ(missing, odd.missing) << odd.name;
  }
  const WholeTake any_case = whole_take(kMarkerFolder / "dataWithNaNsOfDifferentCases.trc");
  EXPECT_EQ(any_case.frames.size(), 5u);
  EXPECT_EQ(any_case.anomalies.not_finite_cells, 15);
}

}  // namespace
}  // namespace trilat
