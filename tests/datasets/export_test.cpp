// SPDX-License-Identifier: MIT
#include <numbers>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/export/samples_csv.h"
#include "datasets/export/session_export.h"
#include "datasets/session/session_writer.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == at)
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

std::array<double, 3> made_up_joint_m(int frame, int j) {
  return {0.01 * frame + 0.05 * (j % 5) - 0.1, 0.06 * (j / 5) - 0.15, 2.5 + 0.01 * j};
}

Body made_up_body(std::uint64_t id, int frame) {
  Body body;
  body.tracking_id = id;
  for (int j = 0; j < kJointCount; ++j) {
    const auto p = made_up_joint_m(frame, j);
    for (std::size_t axis = 0; axis < 3; ++axis)
      body.position_m[static_cast<std::size_t>(j)][axis] = static_cast<float>(p[axis]);
    body.orientation_xyzw[static_cast<std::size_t>(j)] = {0.0f, 0.0f, 0.0f, 1.0f};
    body.tracking_state[static_cast<std::size_t>(j)] = 2;
  }
  body.tracking_state[0] = 0;
  return body;
}

// Frames 5, 6 and 9 of sensor k1: body A in all but the second, where B alone is.
constexpr std::uint64_t kA = 72057594037931648u, kB = 7;
std::filesystem::path session_file(const ScratchFolder& folder, bool two_bodies = true) {
  SessionHeader header;
  header.sensors.push_back({.name = "k1", .serial = {}, .source = "test", .intrinsics = {}});
  SessionWriter writer(folder / "session.h5", header);
  const std::int64_t ticks[] = {1000, 334'333, 1'334'333}, numbers[] = {5, 6, 9};
  for (int i = 0; i < 3; ++i) {
    BodyFrame frame;
    frame.stamp = {numbers[i], ticks[i], 100 * ticks[i]};
    if (i != 1) frame.bodies.push_back(made_up_body(kA, i));
    if (i == 1 && two_bodies) frame.bodies.push_back(made_up_body(kB, i));
    writer.add_body_frame(0, frame);
  }
  writer.finish();
  return folder / "session.h5";
}

// x to world z, and 10 m up.
ExportOptions turned() {
  Calibration calibration;
  calibration.sensors.push_back(
      {"k1",
       {Eigen::Quaterniond(Eigen::AngleAxisd(-0.5 * std::numbers::pi, Eigen::Vector3d::UnitY())),
        {0, 10, 0}}});
  return {.calibration = calibration};
}

TEST(CsvExport, HasARowForEveryFrameBodyAndJointThatReadsBackExactly) {
  const ScratchFolder folder;
  const SessionReader session(session_file(folder));
  EXPECT_EQ(export_session_csv(session, folder / "a.csv", {}), 3 * kJointCount);
  const auto lines = split(read_file(folder / "a.csv"), '\n');
  ASSERT_THAT(lines, SizeIs(1 + 3 * kJointCount + 1));
  const auto names = split(lines[0], ',');
  const auto cells = split(lines[1 + 2 * kJointCount + 4], ',');
  ASSERT_EQ(names.size(), cells.size());
  EXPECT_THAT(std::vector(cells.begin(), cells.begin() + 8),
              ElementsAre("k1", "9", "1334333", "133433300", "0.1333333", std::to_string(kA), "shoulder_left",
                          "tracked"));
  EXPECT_EQ(std::stof(cells[8]), static_cast<float>(made_up_joint_m(2, 4)[0]));
  EXPECT_EQ(std::stof(cells[10]), static_cast<float>(made_up_joint_m(2, 4)[2]));
}

TEST(CsvExport, ACalibrationPutsBodiesIntoTheWorld) {
  const ScratchFolder folder;
  const SessionReader session(session_file(folder));
  export_session_csv(session, folder / "a.csv", turned());
  const auto cells = split(split(read_file(folder / "a.csv"), '\n')[1 + 4], ',');
  const auto p = made_up_joint_m(0, 4);
  EXPECT_NEAR(std::stod(cells[8]), -p[2], 1e-6);
  EXPECT_NEAR(std::stod(cells[9]), p[1] + 10.0, 1e-6);
  EXPECT_NEAR(std::stod(cells[10]), p[0], 1e-6);
  EXPECT_NEAR(std::stod(cells[12]), -std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(std::stod(cells[14]), std::sqrt(0.5), 1e-6);
}

TEST(CsvExport, RefusesACalibrationOfOtherSensors) {
  const ScratchFolder folder;
  const SessionReader session(session_file(folder));
  ExportOptions options = turned();
  options.calibration->sensors[0].name = "k2";
  EXPECT_THAT(message_of([&] { export_session_csv(session, folder / "a.csv", options); }), HasSubstr("k1"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.csv.partial"));
}

TEST(TrcExport, LaysOutMarkersAsOpenSimReadsThem) {
  const ScratchFolder folder;
  const SessionReader session(session_file(folder, false));
  const auto files = export_session_trc(session, folder / "walk.trc", {});
  ASSERT_THAT(files, SizeIs(1));
  EXPECT_EQ(files[0].rows, 3);
  const auto lines = split(read_file(folder / "walk.trc"), '\n');
  ASSERT_THAT(lines, SizeIs(6 + 3 + 1));
  EXPECT_EQ(lines[0], "PathFileType\t4\t(X/Y/Z)\twalk.trc");
  EXPECT_EQ(lines[2], "30\t30\t3\t25\tmm\t30\t1\t3");
  EXPECT_TRUE(lines[3].starts_with("Frame#\tTime\tspine_base\t\t\tspine_mid\t\t\t"));
  EXPECT_TRUE(lines[4].starts_with("\t\tX1\tY1\tZ1\tX2"));
  EXPECT_EQ(lines[5], "");
  for (const std::size_t row : {6, 7, 8}) EXPECT_THAT(split(lines[row], '\t'), SizeIs(2 + 3 * kJointCount));
  const auto cells = split(lines[8], '\t');
  EXPECT_EQ(cells[0], "5");
  EXPECT_EQ(cells[1], "0.133333");
  EXPECT_EQ(cells[2], "") << "a joint that is not tracked";
  EXPECT_EQ(cells[2 + 3 * 4], fmt::format("{:.3f}", 1e3 * made_up_joint_m(2, 4)[0]));
  for (std::size_t i = 2; i < 2 + 3 * kJointCount; ++i) EXPECT_EQ(split(lines[7], '\t')[i], "");
}

TEST(TrcExport, GivesEachBodyAFileAndOnlyItsOwnStretch) {
  const ScratchFolder folder;
  const SessionReader session(session_file(folder));
  const auto files = export_session_trc(session, folder / "walk.trc", {.millimetres = false});
  ASSERT_THAT(files, SizeIs(2));
  EXPECT_EQ(files[0].path, folder / "walk-7.trc");
  EXPECT_EQ(files[0].rows, 1);
  EXPECT_EQ(files[1].path, folder / "walk-72057594037931648.trc");
  EXPECT_EQ(files[1].rows, 3);
  EXPECT_THAT(read_file(files[0].path), HasSubstr("\tm\t"));
}

TEST(TrcExport, OneBodyOnRequest) {
  const ScratchFolder folder;
  const SessionReader session(session_file(folder));
  const auto files = export_session_trc(session, folder / "walk.trc", {.body = kB});
  ASSERT_THAT(files, SizeIs(1));
  EXPECT_EQ(files[0].path, folder / "walk.trc");
  EXPECT_THAT(message_of([&] { export_session_trc(session, folder / "x.trc", {.body = 8}); }),
              HasSubstr("no body 8"));
  EXPECT_THAT(message_of([&] { export_session_trc(session, folder / "x.trc", {.sensor = "k9"}); }),
              HasSubstr("k1"));
}

TEST(CsvExport, HoldsTruthAndEstimatesOfResults) {
  const ScratchFolder folder;
  SamplesHeader header{.joints = {"head", "neck"},
                       .methods = {"mean"},
                       .status_names = {"empty", "fine"},
                       .alignment = "none",
                       .takes = {{"walk", 1}}};
  {
    SamplesFile samples = SamplesFile::create(folder / "samples.h5", header);
    SampleBlock block;
    block.reset(0, 1, 2, 1);
    block.time_ns[0] = 42;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.truth_m[axis] = 1.0 + static_cast<double>(axis);
      block.estimate_m[axis] = 1.5;
    }
    block.status[0] = 1;
    samples.write(0, block);
    samples.finish();
  }
  EXPECT_EQ(export_samples_csv(SamplesFile::open(folder / "samples.h5"), folder / "a.csv"), 2);
  const auto lines = split(read_file(folder / "a.csv"), '\n');
  EXPECT_EQ(lines[1], "walk,42,head,1.000000,2.000000,3.000000,mean,fine,1.500000,1.500000,1.500000");
  EXPECT_EQ(lines[2], "walk,42,neck,,,,mean,empty,,,");
}

}  // namespace
}  // namespace trilat
