// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_writer.h"

#include <cmath>
#include <string>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "tests/datasets/temporary_file.h"
#include "tests/support/whole_take.h"

namespace trilat {
namespace {

MocapHeader two_assets() {
  MocapHeader header;
  header.take_name = "walk, \"slow\"";
  header.take_notes = "first\nsecond";
  header.capture_start_text = "2024-05-01 10.00.00.000 AM";
  header.capture_rate_hz = 240.0;
  header.export_rate_hz = 120.0;
  header.capture_start_frame = 77;
  header.total_exported_frames = 2;
  header.length_unit = LengthUnit::millimetre;
  header.assets.push_back(
      {.type = AssetType::rigid_body, .name = "Wand", .id = "1F", .parent = "Root", .has_position = true});
  header.assets.push_back({.type = AssetType::marker,
                           .name = "Wand:Marker, 1",
                           .id = "9F:D8",
                           .parent = {},
                           .has_position = true});
  return header;
}

const std::vector<Eigen::Vector3d> kPositions_m{{1.2345678, -0.5, 0.0000004},
                                                Eigen::Vector3d::Constant(kNaN)};

TEST(MocapWriter, WritesTheLayoutOfMotive) {
  const TemporaryFile file;
  OptitrackCsvWriter writer(file.path(), two_assets());
  writer.write(12, kPositions_m);
  writer.write(13, kPositions_m);
  writer.finish();
  EXPECT_EQ(
      read_file(file.path()),
      "Format Version,1.25,Take Name,\"walk, \"\"slow\"\"\",Take Notes,\"first second\",Capture Frame "
      "Rate,240.000000,Export Frame Rate,120.000000,Capture Start Time,2024-05-01 10.00.00.000 AM,Capture "
      "Start Frame,77,Total Exported Frames,2,Rotation Type,Quaternion,Length Units,Millimeters,Coordinate "
      "Space,Global\n"
      "\n"
      ",Type,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker\n"
      ",Name,Wand,Wand,Wand,\"Wand:Marker, 1\",\"Wand:Marker, 1\",\"Wand:Marker, 1\"\n"
      ",ID,\"1F\",\"1F\",\"1F\",\"9F:D8\",\"9F:D8\",\"9F:D8\"\n"
      ",Parent,Root,Root,Root,,,\n"
      ",,Position,Position,Position,Position,Position,Position\n"
      "Frame,Time (Seconds),X,Y,Z,X,Y,Z\n"
      "12,0.100000,1234.567800,-500.000000,0.000400,,,\n"
      "13,0.108333,1234.567800,-500.000000,0.000400,,,\n");
}

TEST(MocapWriter, WhatIsWrittenIsReadBackInEveryUnit) {
  for (const LengthUnit unit : {LengthUnit::metre, LengthUnit::centimetre, LengthUnit::millimetre,
                                LengthUnit::inch, LengthUnit::foot}) {
    const TemporaryFile file;
    MocapHeader header = two_assets();
    header.length_unit = unit;
    OptitrackCsvWriter writer(file.path(), header);
    writer.write(12, kPositions_m);
    writer.write(20, kPositions_m);
    writer.finish();
    const WholeTake take = whole_take(file.path());
    EXPECT_EQ(take.header.format, "Motive CSV 1.25");
    EXPECT_EQ(take.header.take_name, header.take_name);
    EXPECT_EQ(take.header.take_notes, "first second");
    EXPECT_EQ(take.header.capture_rate_hz, 240.0);
    EXPECT_EQ(take.header.export_rate_hz, 120.0);
    EXPECT_EQ(take.header.capture_start_frame, 77);
    EXPECT_EQ(take.header.length_unit, unit);
    EXPECT_EQ(take.header.first_frame, 12);
    ASSERT_EQ(take.header.assets.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(take.header.assets[i].type, header.assets[i].type);
      EXPECT_EQ(take.header.assets[i].name, header.assets[i].name);
      EXPECT_EQ(take.header.assets[i].id, header.assets[i].id);
      EXPECT_EQ(take.header.assets[i].parent, header.assets[i].parent);
    }
    ASSERT_EQ(take.frames.size(), 2u);
    EXPECT_EQ(take.frames[1].time.ns, 66'666'667);
    EXPECT_TRUE(take.frames[0].poses[0].position_m.isApprox(kPositions_m[0], 1e-6));
    EXPECT_FALSE(take.frames[0].poses[1].has_position());
    EXPECT_EQ(take.anomalies.printed_time_differs, 0);
  }
}

TEST(MocapWriter, HasTheFinalNameOnlyWhenFinished) {
  const TemporaryFile file;
  {
    OptitrackCsvWriter writer(file.path(), two_assets());
    writer.write(0, kPositions_m);
    EXPECT_FALSE(std::filesystem::exists(file.path()));
    EXPECT_TRUE(std::filesystem::exists(partial_name(file.path())));
  }
  EXPECT_FALSE(std::filesystem::exists(file.path()));
  EXPECT_FALSE(std::filesystem::exists(partial_name(file.path())));
}

TEST(MocapWriter, RefusesToFinishWithAnotherNumberOfFramesThanStated) {
  const TemporaryFile file;
  OptitrackCsvWriter writer(file.path(), two_assets());
  writer.write(0, kPositions_m);
  EXPECT_THROW(writer.finish(), InternalError);
}

TEST(MocapWriter, NamesTheFileThatCannotBeWritten) {
  try {
    OptitrackCsvWriter writer("/nowhere/take.csv", two_assets());
    FAIL() << "a file was made in a folder that is not there";
  } catch (const InputError& error) {
    EXPECT_EQ(error.place(), "/nowhere/take.csv");
  }
}

}  // namespace
}  // namespace trilat
