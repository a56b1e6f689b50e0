// SPDX-License-Identifier: MIT
#include "datasets/rig/calibration.h"

#include <functional>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

// A calibration of two sensors with all that one can hold.
Calibration full_calibration() {
  SensorPose pose;
  pose.name = "k1";
  pose.world_from_sensor = world_from_sensor_looking_at({1.0, 2.0, 3.0}, {0.1, 0.2, 0.3});
  pose.position_sigma_m = 0.004;
  pose.rotation_sigma_rad = 0.002;
  Eigen::Matrix<double, 6, 6> root;
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) root(row, column) = 1e-3 / (1.0 + row + 2.0 * column);
  pose.covariance = root * root.transpose();
  pose.depth_offset_m = -0.0123;
  pose.depth_offset_sigma_m = 0.0021;
  pose.residual_rms_m = 0.0008;
  pose.used = 48;
  pose.left_out = 2;
  SensorPose other = pose;
  other.name = "k2";
  other.world_from_sensor.translation_m.x() += 2.0;
  other.covariance.reset();
  Calibration calibration;
  calibration.method = "wand";
  calibration.world = "wand";
  calibration.sensors = {pose, other};
  calibration.positions = 50;
  calibration.reduced_chi2 = 1.25;
  calibration.rejected = {{"k1", 7, 12.5, 0.031}, {"k2", 9, 15.75, 0.0}};
  calibration.sources = {{"session.h5", "abc"}, {"mocap.csv", "def"}};
  calibration.program = "0.1.0";
  return calibration;
}

// Each number of a sensor by itself, the others zero: none is left out because another is.
TEST(Calibration, EveryNumberOfASensorIsWrittenWithoutTheOthers) {
  using Member = std::function<double(SensorPose&, double)>;  // sets it, and gives what is there
  const auto real = [](double SensorPose::*member) {
    return
        [member](SensorPose& pose, double value) { return value > 0 ? pose.*member = value : pose.*member; };
  };
  const auto count = [](std::uint64_t SensorPose::*member) {
    return [member](SensorPose& pose, double value) {
      if (value > 0) pose.*member = 1;
      return 0.25 * static_cast<double>(pose.*member);
    };
  };
  const std::vector<Member> members{real(&SensorPose::position_sigma_m),
                                    real(&SensorPose::rotation_sigma_rad),
                                    real(&SensorPose::depth_offset_m),
                                    real(&SensorPose::residual_rms_m),
                                    real(&SensorPose::depth_offset_sigma_m),
                                    count(&SensorPose::used),
                                    count(&SensorPose::left_out)};
  const ScratchFolder folder;
  for (std::size_t wanted = 0; wanted < members.size(); ++wanted) {
    Calibration calibration;
    calibration.method = "laser";
    calibration.sensors.emplace_back().name = "k1";
    members[wanted](calibration.sensors[0], 0.25);
    write_calibration(folder / "calibration.json", calibration);
    Calibration read = read_calibration(folder / "calibration.json");
    for (std::size_t k = 0; k < members.size(); ++k)
      EXPECT_EQ(members[k](read.sensors.at(0), 0.0), k == wanted ? 0.25 : 0.0) << wanted << " " << k;
  }
}

TEST(Calibration, CovariancesEvidenceAndSourcesAreReadBackToTheBit) {
  const ScratchFolder folder;
  const Calibration written = full_calibration();
  write_calibration(folder / "calibration.json", written);
  const Calibration read = read_calibration(folder / "calibration.json");
  ASSERT_EQ(read.sensors.size(), 2u);
  ASSERT_TRUE(read.sensors[0].covariance);
  EXPECT_EQ(*read.sensors[0].covariance, *written.sensors[0].covariance);
  EXPECT_FALSE(read.sensors[1].covariance);
  EXPECT_EQ(read.sensors[0].depth_offset_m, -0.0123);
  EXPECT_EQ(read.sensors[0].depth_offset_sigma_m, 0.0021);
  EXPECT_EQ(read.sensors[0].residual_rms_m, 0.0008);
  EXPECT_EQ(read.sensors[0].used, 48u);
  EXPECT_EQ(read.sensors[0].left_out, 2u);
  EXPECT_EQ(read.world, "wand");
  EXPECT_EQ(read.positions, 50u);
  EXPECT_EQ(read.reduced_chi2, 1.25);
  EXPECT_EQ(read.program, "0.1.0");
  ASSERT_EQ(read.rejected.size(), 2u);
  EXPECT_EQ(read.rejected[0].sensor, "k1");
  EXPECT_EQ(read.rejected[0].position, 7u);
  EXPECT_EQ(read.rejected[0].time_s, 12.5);
  EXPECT_EQ(read.rejected[1].off_by_m, 0.0);
  ASSERT_EQ(read.sources.size(), 2u);
  EXPECT_EQ(read.sources[1].file, "mocap.csv");
  EXPECT_EQ(read.sources[1].sha256, "def");
}

TEST(Calibration, WhatIsUnknownStaysUnknownAndOffsetsAreKeptWithoutCounts) {
  const ScratchFolder folder;
  Calibration written = full_calibration();
  written.positions = 0;
  written.reduced_chi2.reset();
  written.rejected[0].off_by_m.reset();
  written.sensors[1].used = 0;
  write_calibration(folder / "calibration.json", written);
  const Calibration read = read_calibration(folder / "calibration.json");
  EXPECT_FALSE(read.reduced_chi2);
  ASSERT_EQ(read.rejected.size(), 2u);
  EXPECT_FALSE(read.rejected[0].off_by_m);
  EXPECT_EQ(read.sensors[1].depth_offset_m, -0.0123);
  EXPECT_EQ(read.sensors[1].depth_offset_sigma_m, 0.0021);
  ASSERT_EQ(read.sources.size(), 2u);
  EXPECT_EQ(read.program, "0.1.0");
}

// The full calibration with one thing in it spoilt.
class SpoiltCalibration : public testing::Test {
 protected:
  std::string refusal(const std::function<void(Json&)>& spoil) {
    Json json = json_of(full_calibration());
    spoil(json);
    write_file(folder_ / "cal.json", json_text(json, 2));
    return message_of([&] { read_calibration(folder_ / "cal.json"); });
  }
  ScratchFolder folder_;
};

TEST_F(SpoiltCalibration, UnspoiltItIsNotRefused) {
  EXPECT_EQ(refusal([](Json&) {}), "no error");
}

TEST_F(SpoiltCalibration, TwoSensorsInOnePlaceAreNamed) {
  const std::string message =
      refusal([](Json& json) { json["sensors"][1]["position_m"] = json["sensors"][0]["position_m"]; });
  EXPECT_THAT(message, HasSubstr("cal.json /sensors: has \"k1\" and \"k2\" in one place"));
  EXPECT_EQ(refusal([](Json& json) {
              json["sensors"][1]["position_m"] = json["sensors"][0]["position_m"];
              json["sensors"][1]["position_m"][1] = 2.011;
            }),
            "no error");
}

TEST_F(SpoiltCalibration, ACovarianceMustBeOne) {
  EXPECT_THAT(refusal([](Json& json) { json["sensors"][0]["covariance"][0] = -1e-6; }),
              HasSubstr("/sensors/0/covariance: is not a covariance"));
  // The second row's off-diagonal beyond what its variances allow: a correlation above one.
  EXPECT_THAT(refusal([](Json& json) { json["sensors"][0]["covariance"][1] = 1.0; }),
              HasSubstr("/sensors/0/covariance: is not a covariance"));
  EXPECT_THAT(refusal([](Json& json) { json["sensors"][0]["covariance"].erase(20); }),
              HasSubstr("/sensors/0/covariance: must be a list of 21"));
  EXPECT_THAT(refusal([](Json& json) { json["sensors"][0]["covariance"][3] = nullptr; }),
              HasSubstr("/sensors/0/covariance"));
}

TEST_F(SpoiltCalibration, ADepthOffsetOfMetresIsMillimetresTakenForMetres) {
  EXPECT_THAT(refusal([](Json& json) { json["sensors"][1]["depth_offset_m"] = 10.0; }),
              HasSubstr("/sensors/1/depth_offset_m: must lie between -0.5 and 0.5, is 10.0; as centimetres "
                        "it would be 0.1"));
  EXPECT_THAT(refusal([](Json& json) { json["sensors"][1]["depth_offset_m"] = -10.0; }),
              HasSubstr("/sensors/1/depth_offset_m"));
}

TEST_F(SpoiltCalibration, NothingThatIsCountedOrASpreadIsNegative) {
  for (const char* key : {"used", "left_out", "residual_rms_m", "depth_offset_sigma_m", "rotation_sigma_rad"})
    EXPECT_THAT(refusal([&](Json& json) { json["sensors"][0][key] = -1; }),
                HasSubstr(std::string("cal.json /sensors/0/") + key + ": must"))
        << key;
  for (const char* key : {"positions", "reduced_chi2"})
    EXPECT_THAT(refusal([&](Json& json) { json[key] = -1; }), HasSubstr(std::string("cal.json /") + key));
  EXPECT_THAT(refusal([](Json& json) { json["rejected"][1]["off_by_m"] = -0.1; }),
              HasSubstr("/rejected/1/off_by_m: must not be less than 0"));
}

TEST_F(SpoiltCalibration, KeysNobodyKnowsAreNamed) {
  EXPECT_THAT(refusal([](Json& json) { json["scale"] = 1; }), HasSubstr("scale"));
  EXPECT_THAT(refusal([](Json& json) { json["sensors"][0]["colour"] = 1; }), HasSubstr("/sensors/0/colour"));
  EXPECT_THAT(refusal([](Json& json) { json["rejected"][0]["why"] = 1; }), HasSubstr("/rejected/0/why"));
  EXPECT_THAT(refusal([](Json& json) { json["sources"][0]["size"] = 1; }), HasSubstr("/sources/0/size"));
}

}  // namespace
}  // namespace trilat
