// SPDX-License-Identifier: MIT
#include <string>

#include <gmock/gmock.h>

#include "datasets/mocap/mocap_reader.h"
#include "tests/datasets/made_up_c3d.h"
#include "tests/datasets/temporary_file.h"
#include "tests/support/scratch.h"
#include "tests/support/whole_take.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

MocapTake c3d_take(const MadeUpC3d& file) { return read_mocap(TemporaryFile(file.text()).path()); }
std::string c3d_refusal(const MadeUpC3d& file) {
  return message_of([&] { c3d_take(file); });
}

void expect_points(const MocapTake& take) {
  EXPECT_EQ(take.header.format, "C3D");
  EXPECT_EQ(take.header.export_rate_hz, 100.0);
  EXPECT_EQ(take.header.total_exported_frames, 2);
  ASSERT_EQ(take.header.assets.size(), 2u);
  EXPECT_EQ(key_of(take.header, 1), "marker:b");
  ASSERT_EQ(take.frames.size(), 2u);
  EXPECT_EQ(take.frames[1].time, MocapTime{10'000'000});
  EXPECT_EQ(take.frames[1].index, 2);
  EXPECT_TRUE(take.frames[1].poses[0].position_m.isApprox(Eigen::Vector3d(1.501, 0.25, -0.1), 1e-9));
  EXPECT_TRUE(take.frames[0].poses[1].position_m.isApprox(Eigen::Vector3d(0.004, 0.005, 0.006), 1e-9));
  EXPECT_FALSE(take.frames[1].poses[1].has_position());
}

TEST(C3dReader, GivesThePointsOfEveryProcessorAsRealAndAsInteger) {
  for (const C3dProcessor processor : {C3dProcessor::intel, C3dProcessor::dec, C3dProcessor::mips})
    for (const float scale : {-1.0f, 1.0f}) expect_points(c3d_take({.processor = processor, .scale = scale}));
}

TEST(C3dReader, StepsOverAnalogSamples) { expect_points(c3d_take({.analog = 12})); }

TEST(C3dReader, ScalesIntegersAndGoesByTheUnit) {
  const MocapTake fine = c3d_take({.scale = 0.5f});
  EXPECT_TRUE(fine.frames.at(0).poses[0].position_m.isApprox(Eigen::Vector3d(0.75, 0.125, -0.05), 1e-12));
  const MocapTake metres =
      c3d_take({.units = "m", .frames = {{1, 2, 3, 0, 4, 5, 6, 0}, {1, 2, 3, 0, 4, 5, 6, 0}}});
  EXPECT_EQ(metres.frames.at(0).poses[1].position_m, Eigen::Vector3d(4.0, 5.0, 6.0));
}

TEST(C3dReader, ReadsOnlyTheAssetsThatAreAskedFor) {
  const TemporaryFile file(MadeUpC3d{}.text());
  MocapReader reader(file.path());
  reader.read_only({1});
  MocapFrame frame;
  ASSERT_TRUE(reader.next(frame));
  EXPECT_FALSE(frame.poses.at(0).has_position());
  EXPECT_TRUE(frame.poses.at(1).has_position());
}

TEST(C3dReader, FindsLabelsBeyondThe255th) {
  MadeUpC3d file{.labels = {}, .points = 300, .frames = {2, std::vector<float>(1200, 1.0f)}};
  for (int i = 0; i < 299; ++i) file.labels.push_back("L" + std::to_string(i));
  const MocapTake take = c3d_take(file);
  ASSERT_EQ(take.header.assets.size(), 300u);
  EXPECT_EQ(take.header.assets[298].name, "L298");
  EXPECT_EQ(take.header.assets[299].name, "marker 300");
}

TEST(C3dReader, TakesFramesBeyondTheHeadersWordFromTrial) {
  const MocapTake take = c3d_take({.first = 65535, .last = 65535, .long_first = {2, 1}, .long_last = {3, 1}});
  EXPECT_EQ(take.frames.size(), 2u);
  EXPECT_EQ(take.frames.at(0).index, 65538);
}

TEST(C3dReader, RefusesAnalogChannelsOnly) {
  EXPECT_THAT(c3d_refusal({.labels = {}, .points = 0, .analog = 12, .frames = {{}, {}}}),
              HasSubstr("analog channels only"));
  EXPECT_THAT(c3d_refusal({.labels = {}, .points = 0, .frames = {}}), HasSubstr("no points"));
}

TEST(C3dReader, RefusesMoreFramesThanThereAre) {
  EXPECT_THAT(c3d_refusal({.last = 3}), AllOf(HasSubstr("promises 3 frames"), HasSubstr("room for 2")));
  EXPECT_THAT(c3d_refusal({.last = 9}), AllOf(HasSubstr("promises 9 frames"), HasSubstr("room for 2")));
}

TEST(C3dReader, RefusesMillimetresCalledMetresAndUnknownUnits) {
  EXPECT_THAT(c3d_refusal({.units = "m"}), AllOf(HasSubstr("frame 1, marker:a"), HasSubstr("another unit")));
  EXPECT_THAT(c3d_refusal({.units = "V"}), HasSubstr("POINT:UNITS is \"V\""));
}

TEST(C3dReader, RefusesAScaleThatMakesNoNumber) {
  EXPECT_THAT(c3d_refusal({.scale = 0.0f}), HasSubstr("POINT:SCALE is 0"));
}

TEST(C3dReader, AFileThatIsCutAnywhereIsRefusedWithOneError) {
  const std::string whole = MadeUpC3d{}.text();
  for (std::size_t size = 2; size < whole.size(); size += 7) {
    const TemporaryFile file(whole.substr(0, size));
    EXPECT_THROW(read_mocap(file.path()), InputError) << size;
  }
}

TEST(C3dReader, APointThatIsNotFiniteIsMissingAndCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const MocapTake take = c3d_take({.frames = {{1, 2, 3, 0, nan, 5, 6, 0}, {1, 2, 3, 0, 4, 5, 6, 0}}});
  EXPECT_FALSE(take.frames.at(0).poses[1].has_position());
  EXPECT_EQ(take.anomalies.not_finite_cells, 1);
}

}  // namespace
}  // namespace trilat
