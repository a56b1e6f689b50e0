// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/rig_gdop.h"

#include <cmath>

#include <gmock/gmock.h>

namespace trilat {
namespace {

RigidTransform standing_at(double x_m, double y_m, double z_m) {
  RigidTransform sensor;
  sensor.translation_m = {x_m, y_m, z_m};
  return sensor;
}

// A sensor in the origin that looks along z.
TEST(RigGdop, ASensorSeesWhatLiesInItsFieldAndRange) {
  const RigidTransform sensor;
  EXPECT_TRUE(is_in_view(sensor, {0.0, 0.0, 0.5}));
  EXPECT_FALSE(is_in_view(sensor, {0.0, 0.0, 0.49}));
  EXPECT_FALSE(is_in_view(sensor, {0.0, 0.0, 4.51}));
  EXPECT_FALSE(is_in_view(sensor, {0.0, 0.0, -1.0}));
  EXPECT_TRUE(is_in_view(sensor, {1.41, 0.0, 2.0}));  // 2 tan 35.3 degrees = 1.416
  EXPECT_FALSE(is_in_view(sensor, {1.42, 0.0, 2.0}));
  EXPECT_TRUE(is_in_view(sensor, {0.0, -1.15, 2.0}));  // 2 tan 30 degrees = 1.155
  EXPECT_FALSE(is_in_view(sensor, {0.0, -1.16, 2.0}));
}

// Seen from three sides at right angles the directions are the axes' own, so gdop is the root of 3.
TEST(RigGdop, ThreeRightAnglesGiveTheRootOfThree) {
  Plan plan;
  plan.rig = {"k1", "k2", "k3"};
  PlannedTake take;
  take.take.id = "t1";
  take.ok = true;
  // all look at the point (0, 1, 0) from 2 m: along z, along x and from above
  RigidTransform along_z = standing_at(0.0, 1.0, -2.0), along_x = standing_at(-2.0, 1.0, 0.0),
                 down = standing_at(0.0, 3.0, 0.0);
  along_x.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * 3.14159265358979, Eigen::Vector3d::UnitY()));
  down.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * 3.14159265358979, Eigen::Vector3d::UnitX()));
  take.world_from_sensor = {along_z, along_x, down};
  plan.takes = {PlannedTake{}, take};  // the first cannot be evaluated
  const auto map = rig_gdop(plan);
  ASSERT_TRUE(map);
  EXPECT_EQ(map->take, "t1");
  ASSERT_EQ(map->gdop.size(), map->x_m.size() * map->z_m.size());
  double nearest_m = 1e9, gdop = kNaN;
  bool any_unseen = false;
  for (std::size_t r = 0; r < map->z_m.size(); ++r)
    for (std::size_t c = 0; c < map->x_m.size(); ++c) {
      const double value = map->gdop[r * map->x_m.size() + c], off_m = std::hypot(map->x_m[c], map->z_m[r]);
      any_unseen |= std::isnan(value);
      if (off_m >= nearest_m) continue;
      nearest_m = off_m;
      gdop = value;
    }
  EXPECT_LT(nearest_m, 0.05);
  EXPECT_NEAR(gdop, std::sqrt(3.0), 0.02);
  EXPECT_TRUE(any_unseen);
}

TEST(RigGdop, WithoutATakeThereIsNoMap) { EXPECT_FALSE(rig_gdop(Plan{})); }

}  // namespace
}  // namespace trilat
