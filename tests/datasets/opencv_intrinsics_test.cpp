// SPDX-License-Identifier: MIT
#include "datasets/calibration/opencv_intrinsics.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::filesystem::path kFolder =
    std::filesystem::path(kSourceDir) / ".." / "shared" / "data" / "kinect-calibration" / "iai_kinect2";

std::string matrix(const std::string& name, int rows, int columns, const std::string& numbers) {
  return name + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
         "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ " + numbers + " ]\n";
}
const std::string kHead = "%YAML:1.0\n";
const std::string kCamera = "366.5, 0., 255., 0., 365.5, 205., 0., 0., 1.";
const std::string kLens = "0.09, -0.27, 0.0015, -0.0005, 0.1";

std::string file_of(const std::string& camera, int lens_count, const std::string& lens) {
  return kHead + matrix("cameraMatrix", 3, 3, camera) + matrix("distortionCoefficients", 1, lens_count, lens);
}

class OpenCvIntrinsics : public testing::Test {
 protected:
  DepthIntrinsics read(const std::string& text) {
    write_file(folder_ / "calib.yaml", text);
    return read_opencv_intrinsics(folder_ / "calib.yaml", 512, 424);
  }
  std::string complaint(const std::string& text) {
    return message_of([&] { read(text); });
  }
  ScratchFolder folder_;
};

TEST_F(OpenCvIntrinsics, TakesEveryNumberToItsPlace) {
  const DepthIntrinsics in = read(file_of(kCamera, 5, kLens));
  EXPECT_EQ(in.width_px, 512);
  EXPECT_EQ(in.height_px, 424);
  EXPECT_EQ(in.fx_px, 366.5);
  EXPECT_EQ(in.fy_px, 365.5);
  EXPECT_EQ(in.cx_px, 255.0);
  EXPECT_EQ(in.cy_px, 205.0);
  EXPECT_EQ(in.k1, 0.09);
  EXPECT_EQ(in.k2, -0.27);
  EXPECT_EQ(in.p1, 0.0015);
  EXPECT_EQ(in.p2, -0.0005);
  EXPECT_EQ(in.k3, 0.1);
}

TEST_F(OpenCvIntrinsics, TakesFourCoefficientsAndEightWhoseLastAreZero) {
  EXPECT_EQ(read(file_of(kCamera, 4, "0.09, -0.27, 0.0015, -0.0005")).k3, 0.0);
  EXPECT_EQ(read(file_of(kCamera, 8, kLens + ", 0., 0., 0.")).k3, 0.1);
  EXPECT_THAT(complaint(file_of(kCamera, 8, kLens + ", 0.2, 0., 0.")), HasSubstr("beyond k1 k2 p1 p2 k3"));
  EXPECT_THAT(complaint(file_of(kCamera, 3, "0.1, 0.2, 0.3")), HasSubstr("3 distortion coefficients"));
}

TEST_F(OpenCvIntrinsics, TakesTheOtherCommonNamesAndPlainLists) {
  EXPECT_EQ(
      read(kHead + matrix("camera_matrix", 3, 3, kCamera) + matrix("distortion_coefficients", 5, 1, kLens))
          .k3,
      0.1);
  EXPECT_EQ(
      read(kHead + "camera_matrix: [ " + kCamera + " ]\ndistortion_coefficients: [ " + kLens + " ]\n").fx_px,
      366.5);
}

TEST_F(OpenCvIntrinsics, SaysThatTheseAreTheColourCameras) {
  const std::string colour = "1059.9, 0., 954.9, 0., 1053.9, 523.7, 0., 0., 1.";
  EXPECT_THAT(complaint(file_of(colour, 5, kLens)),
              AllOf(HasSubstr("calib.yaml"), HasSubstr("look like the colour camera's intrinsics (fx 1059)"),
                    HasSubstr("depth camera's are wanted")));
}

TEST_F(OpenCvIntrinsics, NamesWhatAFileHoldsInsteadOfACameraMatrix) {
  EXPECT_THAT(complaint(kHead + "depthShift: -13.4\n"), HasSubstr("holds depthShift but no camera matrix"));
  EXPECT_THAT(
      complaint(kHead + matrix("rotation", 3, 3, kCamera) + matrix("translation", 3, 1, "1., 2., 3.")),
      HasSubstr("holds rotation, translation but no camera matrix"));
  EXPECT_THAT(complaint(kHead + matrix("cameraMatrix", 3, 3, kCamera)),
              HasSubstr("holds cameraMatrix but no distortion coefficients"));
}

TEST_F(OpenCvIntrinsics, RefusesWhatNoSuchCameraHas) {
  EXPECT_THAT(complaint(file_of("36., 0., 255., 0., 365.5, 205., 0., 0., 1.", 5, kLens)),
              HasSubstr("focal length"));
  EXPECT_THAT(complaint(file_of(".Nan, 0., 255., 0., 365.5, 205., 0., 0., 1.", 5, kLens)),
              HasSubstr("not finite"));
  EXPECT_THAT(complaint(file_of("366., 5., 255., 0., 365.5, 205., 0., 0., 1.", 5, kLens)),
              HasSubstr("not of the form"));
  EXPECT_THAT(complaint(file_of(kCamera, 5, "9., 0., 0., 0., 0.")), HasSubstr("distortion coefficient"));
  EXPECT_THAT(complaint(kHead + matrix("cameraMatrix", 2, 2, "1., 2., 3., 4.") +
                        matrix("distortionCoefficients", 1, 5, kLens)),
              HasSubstr("4 numbers, not 9"));
}

TEST_F(OpenCvIntrinsics, GivesOneClearErrorForFilesOfAnotherKind) {
  for (const std::string& text :
       {std::string(), std::string("hello"), std::string("%YAML:1.0\n"),
        std::string("%YAML:1.0\n---\n[[[:\n\t"), std::string("%YAML:1.0\ncameraMatrix: 5\n"),
        std::string("%YAML:1.0\ncameraMatrix: [ a, b ]\n"), kHead + "cameraMatrix: [ 365.4, . 5240,.8 ]\n",
        std::string("{ \"cameraMatrix\": "), std::string("<?xml version=\"1.0\"?>\n<x>"),
        std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16), std::string(100000, '['),
        "%YAML:1.0\n" + std::string(5000, '['), file_of(kCamera, 5, kLens).substr(0, 120)}) {
    const std::string message = complaint(text);
    EXPECT_THAT(message, HasSubstr("calib.yaml")) << text.substr(0, 40);
    EXPECT_THAT(message, testing::Not(HasSubstr("no error"))) << text.substr(0, 40);
  }
}

TEST_F(OpenCvIntrinsics, ReadsCommentsWindowsLinesAndTheMarkOfADocument) {
  const std::string text = "%YAML:1.0\r\n---\r\n# of k1\r\ncamera_matrix: [ " + kCamera +
                           " ]\r\ndistortion_coefficients: [ 0.1,\r\n   0., 0., 0.,\r\n   0.1 ]\r\n";
  EXPECT_EQ(read(text).fx_px, 366.5);
}

TEST_F(OpenCvIntrinsics, NamesAFileThatIsNotThere) {
  EXPECT_THAT(message_of([&] { read_opencv_intrinsics(folder_ / "none.yaml", 512, 424); }),
              HasSubstr("none.yaml"));
  EXPECT_THAT(message_of([&] { read_opencv_intrinsics(folder_.path(), 512, 424); }),
              HasSubstr(folder_.path().string()));
}

class RealKinectCalibration : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kFolder))
      GTEST_SKIP() << "the folder " << kFolder.string() << " with calib_ir.yaml files is not there";
  }
};

TEST_F(RealKinectCalibration, TheInfraredFilesAreRead) {
  const DepthIntrinsics a = read_opencv_intrinsics(kFolder / "196605135147" / "calib_ir.yaml", 512, 424);
  EXPECT_EQ(a.fx_px, 366.94757270064110);
  EXPECT_EQ(a.cy_px, 207.69853575457685);
  EXPECT_EQ(a.p2, -0.00050751483524871712);
  EXPECT_EQ(a.k3, 0.10523948765859192);
  const DepthIntrinsics b = read_opencv_intrinsics(kFolder / "299150235147" / "calib_ir.yaml", 512, 424);
  EXPECT_EQ(b.fy_px, 367.14380707081017);
  EXPECT_EQ(b.k2, -0.31461678804886056);
}

TEST_F(RealKinectCalibration, TheColourPoseAndDepthFilesAreRefusedForWhatTheyAre) {
  const auto complaint = [](const char* unit, const char* file) {
    return message_of([&] { read_opencv_intrinsics(kFolder / unit / file, 512, 424); });
  };
  EXPECT_THAT(complaint("196605135147", "calib_color.yaml"),
              HasSubstr("colour camera's intrinsics (fx 1059)"));
  EXPECT_THAT(complaint("299150235147", "calib_color.yaml"),
              HasSubstr("colour camera's intrinsics (fx 1066)"));
  EXPECT_THAT(complaint("196605135147", "calib_pose.yaml"), HasSubstr("holds rotation, translation"));
  EXPECT_THAT(complaint("196605135147", "calib_depth.yaml"),
              HasSubstr("holds depthShift but no camera matrix"));
}

}  // namespace
}  // namespace trilat
