// SPDX-License-Identifier: MIT
// Exports of other people's systems. The expected numbers were counted with Python's csv module.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/mocap/mocap_take.h"
#include "datasets/mocap/read_mocap.h"
#include "tests/support/paths.h"
#include "tests/support/whole_take.h"

namespace trilat {
namespace {

const std::filesystem::path kMocapFolder =
    std::filesystem::path(kSourceDir) / ".." / "shared" / "data" / "optitrack";

struct RealFile {
  const char* path;
  const char* format;
  const char* take_name;
  LengthUnit unit;
  double rate_hz;
  std::int64_t first_frame;
  std::int64_t frames;
  std::int64_t stated_frames;
  std::int64_t index_gaps;
  std::int64_t skipped_frames;
  double duration_s;
  double largest_time_error_s;
  const char* samples;  // of every asset, in order
};

void PrintTo(const RealFile& file, std::ostream* stream) { *stream << file.path; }

const std::vector<RealFile>& real_files() {
  static const std::vector<RealFile> files{
      {"cmu-hmv-s16/sample_optitrack_take.csv", "Motive CSV 1.21", "Take 2016-01-05 03.49.50 PM",
       LengthUnit::metre, 120.0, 0, 250, 250, 0, 0, 2.075, 0.000000333,
       "rigid_body:Rigid Body 1 250, rigid_body_marker:Rigid Body 1_1 250, rigid_body_marker:Rigid Body 1_2 "
       "250, rigid_body_marker:Rigid Body 1_3 250, marker:Unlabeled:108 250, marker:Unlabeled:110 250, "
       "marker:Unlabeled:111 250, marker:Rigid Body 1:Marker1 250, marker:Rigid Body 1:Marker2 250, "
       "marker:Rigid Body 1:Marker3 250, marker:Unlabeled:105 0, marker:Unlabeled:107 0, "
       "marker:Unlabeled:106 0"},
      {"ha5dzs/test_default.csv", "Motive CSV 1.23", "test", LengthUnit::millimetre, 360.0, 0, 1353, 1353, 0,
       0, 3.755555556, 0.000444444, ""},
      {"ha5dzs/test_markers_enabled.csv", "Motive CSV 1.23", "test", LengthUnit::millimetre, 360.0, 0, 1353,
       1353, 0, 0, 3.755555556, 0.000444444,
       "marker:Unlabeled 1036 1353, marker:Unlabeled 1037 1353, marker:Unlabeled 1038 1353, marker:Unlabeled "
       "1039 1353, marker:Unlabeled 1040 1353, marker:Unlabeled 1041 1353, marker:Unlabeled 1042 1353, "
       "marker:Unlabeled 1043 1353, marker:Unlabeled 1044 1353, marker:Unlabeled 1045 1353, marker:Unlabeled "
       "1046 1353, marker:Unlabeled 1047 1353, marker:Unlabeled 1048 1353, marker:Unlabeled 1049 1353, "
       "marker:Unlabeled 1050 1353, marker:Unlabeled 1051 1005, marker:Unlabeled 1052 1004, marker:Unlabeled "
       "1053 1"},
      {"parse_optitrack_csv/test.csv", "Motive CSV 1.23", "Take 2020-01-16 07.07.58 PM", LengthUnit::metre,
       120.0, 0, 499, 499, 0, 0, 4.15, 0.000000333,
       "rigid_body:ernesto_body 498, rigid_body_marker:ernesto_body:Marker1 498, "
       "rigid_body_marker:ernesto_body:Marker2 498, rigid_body_marker:ernesto_body:Marker3 498, "
       "rigid_body_marker:ernesto_body:Marker4 498, marker:ernesto_body:Marker1 499, "
       "marker:ernesto_body:Marker2 499, marker:ernesto_body:Marker3 499, marker:ernesto_body:Marker4 499"},
      {"pathviewr/hist_2020-03-07_Ard_her_20-317L_4jts_7wng_ROM_001.csv", "Motive CSV 1.23",
       "2020-03-07_Ard_her_20-317L_4jts_6fthr_ROM_001", LengthUnit::millimetre, 30.0, 0, 2032, 2032, 0, 0,
       67.7, 0.000000333,
       "marker:Ard_her_20-317L_4jt7wing:cmc 2032, marker:Ard_her_20-317L_4jt7wing:cmc_leading 2032, "
       "marker:Ard_her_20-317L_4jt7wing:elbow 2017, marker:Ard_her_20-317L_4jt7wing:humerus 2022, "
       "marker:Ard_her_20-317L_4jt7wing:humerus_leading 1928, marker:Ard_her_20-317L_4jt7wing:p10 1934, "
       "marker:Ard_her_20-317L_4jt7wing:p7 2031, marker:Ard_her_20-317L_4jt7wing:s1 1675, "
       "marker:Ard_her_20-317L_4jt7wing:s10 1979, marker:Ard_her_20-317L_4jt7wing:wrist 2026, "
       "marker:Ard_her_20-317L_4jt7wing:wrist_leading 2031"},
      {"pathviewr/pathviewr_motive_example_data.csv", "Motive CSV 1.23", "sept-18_mixed-group_16-30",
       LengthUnit::metre, 100.0, 72210, 934, 190951, 4, 31957, 328.9, 0.0,
       "rigid_body:device02 933, rigid_body:device03 932, rigid_body:device05 748"},
      {"pathviewr/projectile_vel_test.csv", "Motive CSV 1.23", "projectile_vel_test_002", LengthUnit::metre,
       100.0, 0, 826, 826, 0, 0, 8.25, 0.0,
       "marker:Unlabeled 2379 60, marker:Unlabeled 2380 13, marker:Unlabeled 2381 19, marker:Unlabeled 2382 "
       "93, marker:Unlabeled 2383 102"}};
  return files;
}

class MocapRealFile : public testing::TestWithParam<RealFile> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kMocapFolder / GetParam().path))
      GTEST_SKIP() << "the folder " << kMocapFolder.string() << " with " << GetParam().path
                   << " is not there";
  }
};

TEST_P(MocapRealFile, HoldsWhatWasCountedByHand) {
  const RealFile& expected = GetParam();
  const MocapTake take = read_mocap(kMocapFolder / expected.path);
  const MocapHeader& header = take.header;
  EXPECT_EQ(header.format, expected.format);
  EXPECT_EQ(header.take_name, expected.take_name);
  EXPECT_EQ(header.length_unit, expected.unit);
  EXPECT_EQ(header.first_frame, expected.first_frame);
  EXPECT_EQ(header.total_exported_frames, expected.stated_frames);

  const MocapSummary summary = summarize_mocap(take);
  EXPECT_EQ(summary.frames, expected.frames);
  EXPECT_EQ(summary.rate_hz, expected.rate_hz);
  EXPECT_EQ(summary.index_gaps, expected.index_gaps);
  EXPECT_EQ(summary.skipped_frames, expected.skipped_frames);
  EXPECT_NEAR(summary.duration_s, expected.duration_s, 1e-9);
  EXPECT_NEAR(take.anomalies.largest_time_error_s, expected.largest_time_error_s, 1.5e-9);
  std::string samples;
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    const AssetSummary& asset = summary.assets.at(i);
    samples += fmt::format("{}{} {}", i == 0 ? "" : ", ", key_of(header, i), asset.samples);
    EXPECT_EQ(asset.samples + asset.missing, expected.frames);
    EXPECT_EQ(asset.no_measurement.sum(), 0);
  }
  EXPECT_EQ(samples, expected.samples);
}

TEST_P(MocapRealFile, HoldsNothingOdd) {
  const MocapAnomalies anomalies = whole_take(kMocapFolder / GetParam().path).anomalies;
  EXPECT_EQ(anomalies.repeated_frames, 0);
  EXPECT_EQ(anomalies.rows_with_extra_fields, 0);
  EXPECT_EQ(anomalies.not_finite_cells, 0);
  EXPECT_EQ(anomalies.partial_poses, 0);
  EXPECT_EQ(anomalies.printed_time_differs, 0);
  EXPECT_FALSE(anomalies.truncated_last_row);
}

INSTANTIATE_TEST_SUITE_P(Optitrack, MocapRealFile, testing::ValuesIn(real_files()), [](const auto& file) {
  std::string name = file.param.path;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

WholeTake real_take(const char* path) { return whole_take(kMocapFolder / path); }

TEST(MocapRealFiles, PosesHaveTheNumbersThatAreWritten) {
  if (!std::filesystem::exists(kMocapFolder))
    GTEST_SKIP() << "the folder " << kMocapFolder.string() << " is not there";
  const WholeTake body = real_take("parse_optitrack_csv/test.csv");
  const WholeTake::Pose& first = body.frames.at(0).poses.at(0);
  EXPECT_EQ(first.position_m, Eigen::Vector3d(3.717927, 0.045963, -2.209530));
  EXPECT_EQ(
      body.frames[0].poses.at(find_asset(body.header, "marker:ernesto_body:Marker4", "test")).position_m,
      Eigen::Vector3d(3.644273, 0.032218, -2.070455));

  const WholeTake wing = real_take("pathviewr/hist_2020-03-07_Ard_her_20-317L_4jts_7wng_ROM_001.csv");
  EXPECT_TRUE(wing.frames.at(0).poses.at(10).position_m.isApprox(
      Eigen::Vector3d(0.019194016, 0.268596893, 0.050769268), 1e-12));
}

}  // namespace
}  // namespace trilat
