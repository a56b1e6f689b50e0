// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "evaluators/solvers/point_estimate.h"
#include "pipeline/errors/condition_errors.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

constexpr double kMovedRate_hz = 30.0;
constexpr std::uint64_t kInstants = 41, kStarts = 20;

// A joint that rests and from the middle on goes faster by 1 m/s every second.
double truth_x_m(std::uint64_t i) {
  const double since_s = i < kStarts ? 0.0 : static_cast<double>(i - kStarts) / kMovedRate_hz;
  return 0.5 * since_s * since_s;
}

// Off by 1 cm up to the start, and by 3 cm from there on.
StoredTake take_in(const ScratchFolder& folder) {
  TakeHead head{"a", "walking", kInstants, {"head"}, {"nonlinear"}, {"mocap"}, {}};
  for (int s = 0; s < kSolveStatusCount; ++s)
    head.status_names.emplace_back(name_of(static_cast<SolveStatus>(s)));
  {
    StoredTake take = StoredTake::create(folder / "take.h5", head);
    SampleBlock block;
    block.reset(0, kInstants, 1, 1);
    for (std::uint64_t i = 0; i < kInstants; ++i) {
      block.time_ns[i] = static_cast<std::int64_t>(i);
      block.truth_m[3 * i] = truth_x_m(i);
      block.truth_m[3 * i + 1] = block.truth_m[3 * i + 2] = 0.0;
      block.estimate_m[3 * i] = static_cast<float>(truth_x_m(i));
      block.estimate_m[3 * i + 1] = i <= kStarts ? 0.01F : 0.03F;
      block.estimate_m[3 * i + 2] = 0.0F;
      block.status[i] = static_cast<std::uint8_t>(SolveStatus::converged);
    }
    take.write(0, block);
    take.finish();
  }
  return StoredTake::open(folder / "take.h5");
}

// Accelerations are known from the third instant to the third last, 37 of them; in the half of 19 that is
// smaller are those up to the start.
TEST(Movement, HalvesAndSpeedsByPencil) {
  const ScratchFolder folder;
  TakeErrors table;
  table.laid_over = {{}};
  const std::vector<MovementRow> rows = movement_of(take_in(folder), table, 0, kMovedRate_hz);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].calm, 19u);
  EXPECT_EQ(rows[0].abrupt, 18u);
  EXPECT_NEAR(rows[0].calm_m, 0.19, 1e-6);
  EXPECT_NEAR(rows[0].abrupt_m, 0.54, 1e-6);
  EXPECT_EQ(rows[0].speeds, 39u);
  EXPECT_NEAR(rows[0].speed_m_s, 0.5 * kMovedRate_hz * (truth_x_m(40) + truth_x_m(39)), 1e-12);
}

TEST(Movement, ErrorsAreThoseOfTheStudysFirstAlignment) {
  const ScratchFolder folder;
  TakeErrors table;
  table.laid_over = {{}};
  table.laid_over[0].shift_m = {0.0, -0.01, 0.0};
  const MovementRow row = movement_of(take_in(folder), table, 0, kMovedRate_hz).at(0);
  EXPECT_NEAR(row.calm_m, 0.0, 1e-6);
  EXPECT_NEAR(row.abrupt_m, 0.36, 1e-6);
}

}  // namespace
}  // namespace trilat
