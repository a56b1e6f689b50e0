// SPDX-License-Identifier: MIT
#include "datasets/results/replay.h"

#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/hdf5/hdf5_file.h"
#include "datasets/skeleton/skeleton.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

ReplayTake hand_made_take() {
  ReplayTake take;
  take.id = "p01-walking";
  take.condition = "walking";
  take.sensors = {"k1", "k2"};
  take.world_from_sensor = {{}, {{std::sqrt(0.5), 0.0, std::sqrt(0.5), 0.0}, {1.0, 2.0, 3.0}}};
  take.reset(4, 2);
  take.joint_m[0] = 0.25f;
  take.state[0] = static_cast<std::uint8_t>(TrackingState::inferred);
  return take;
}

TEST(Replay, ComesBackAsItWasWritten) {
  const ScratchFolder folder;
  const ReplayTake take = hand_made_take();
  write_replay(folder.path(), take);
  const std::optional<ReplayTake> read = read_replay(folder.path());
  ASSERT_TRUE(read);
  const ReplayTake& back = *read;
  EXPECT_EQ(back.id, take.id);
  EXPECT_EQ(back.condition, take.condition);
  EXPECT_EQ(back.sensors, take.sensors);
  EXPECT_EQ(back.instants, 4u);
  EXPECT_NEAR((back.world_from_sensor[1] * Eigen::Vector3d::UnitX() -
               take.world_from_sensor[1] * Eigen::Vector3d::UnitX())
                  .norm(),
              0.0, 1e-12);
  EXPECT_EQ(back.joint_m[0], 0.25f);
  EXPECT_TRUE(std::isnan(back.joint_m[1]));
  EXPECT_EQ(back.state, take.state);
}

TEST(Replay, EqualTakesGiveEqualBytes) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "a");
  std::filesystem::create_directories(folder / "b");
  write_replay(folder / "a", hand_made_take());
  write_replay(folder / "b", hand_made_take());
  EXPECT_TRUE(read_file(folder / "a/replay.h5") == read_file(folder / "b/replay.h5"));
}

TEST(Replay, WithoutAFileThereIsNone) { EXPECT_FALSE(read_replay(ScratchFolder().path())); }

TEST(Replay, AnotherVersionOrFormatIsRefused) {
  const ScratchFolder folder;
  H5File file = H5File::create(folder / "replay.h5");
  file.set_text("format", "trilat.replay");
  file.set_integer("version", 3);
  file.close();
  EXPECT_THAT(message_of([&] { read_replay(folder.path()); }),
              HasSubstr("replay.h5: is another version; this program reads version 2"));
  write_file(folder / "replay.h5", "no HDF5");
  EXPECT_THAT(message_of([&] { read_replay(folder.path()); }), HasSubstr("replay.h5"));
}

TEST(Replay, AMatrixThatIsNoPoseIsRefused) {
  const ScratchFolder folder;
  ReplayTake take = hand_made_take();
  take.world_from_sensor[0].rotation.coeffs().setZero();
  write_replay(folder.path(), take);
  EXPECT_THAT(message_of([&] { read_replay(folder.path()); }), HasSubstr("world_from_sensor is no pose"));
}

}  // namespace
}  // namespace trilat
