// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_rays.h"

#include <cmath>

#include <gmock/gmock.h>

#include "datasets/rig/calibration.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/tracking_summary.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/error_cells.h"
#include "tests/pipeline/rewritten_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kEstimated =
    R"("methods": [{"method": "mean"}, {"method": "range_bearing", "calibration": "stated"}])";

// One simulated take with white errors, equal in all directions, as methods see it.
struct ViewedTake {
  explicit ViewedTake(double bias_m = 0.0) {
    SimulationSpec spec = walking_spec(1, 8.0);
    spec.body_tracker.own_bias_sigma_m.fill(bias_m);
    spec.body_tracker.jitter_sigma_m.fill(0.03);
    campaign = simulate_into(folder.path() / "campaign", spec);
    plan = make_plan(study_of(kEstimated), campaign);
    data = load_take(plan, plan.takes[0], {});
  }
  ScratchFolder folder;
  Campaign campaign;
  Plan plan;
  PreparedTake data;
};

TEST(TakeRays, AnInstantIsJudgedWithTheSigmasOfTheOtherHalf) {
  ViewedTake take;
  const std::size_t instants = take.data.time.size();
  estimate_sigmas(take.plan, take.plan.takes[0], take.data);
  const RaySigma first = sigma_at(take.data, false, 0, 0),
                 second = sigma_at(take.data, false, instants - 1, 0);
  EXPECT_NEAR(first.range_m, 0.025, 0.01);
  for (std::size_t i = 0; i < instants / 2; ++i)  // the first sensor errs by a metre along its z axis
    for (Eigen::Vector3f& joint_m : take.data.bodies.at(i, 0).joint_in_sensor_m)
      joint_m.z() += i % 2 == 0 ? 1.0f : -1.0f;
  take.data.sigma = {};
  estimate_sigmas(take.plan, take.plan.takes[0], take.data);
  EXPECT_EQ(sigma_at(take.data, false, 0, 0).range_m, first.range_m);
  EXPECT_GT(sigma_at(take.data, false, instants - 1, 0).range_m, 5.0 * second.range_m);
}

// A sensor that stands turned by 4 degrees is found and told, and methods whose calibration is estimated do
// as well as with the true one.
TEST(TakeRays, ATurnedSensorIsFoundAndTakenAway) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", walking_spec(1, 8.0));
  const StudySpec study = study_of(
      R"("methods": [{"method": "mean"}, {"name": "corrected", "method": "mean", "calibration": "estimated"}, {"method": "range_bearing"}],
         "alignments": ["none"])");
  const ResultsSummary straight = execute_study(study, campaign, folder / "straight", {});
  const std::filesystem::path file = campaign.takes[0].calibration;
  Calibration calibration = read_calibration(file);
  RigidTransform& pose = calibration.sensors[1].world_from_sensor;
  pose.rotation = Eigen::AngleAxisd(0.07, Eigen::Vector3d::UnitY()) * pose.rotation;
  write_calibration(file, calibration);
  const ResultsSummary turned = execute_study(study, campaign, folder / "turned", {});
  const auto error_m = [](const ResultsSummary& s, const char* method) {
    return find_cell(s, method, "walking", kAverageGroup, "none")->mae_m;
  };
  EXPECT_GT(error_m(turned, "mean"), error_m(straight, "mean") + 0.01);
  EXPECT_LT(error_m(turned, "corrected"), error_m(straight, "corrected") + 0.005);
  EXPECT_LT(error_m(turned, "range_bearing"), error_m(straight, "range_bearing") + 0.005);
  std::vector<CheckRow> rows = read_json_file<TrackingSummary>(folder / "turned")->checks;
  std::erase_if(rows, [](const CheckRow& row) { return row.what != "turned"; });
  ASSERT_EQ(rows.size(), calibration.sensors.size());
  EXPECT_NEAR(rows[1].value, 0.07, 0.02);
  EXPECT_TRUE(rows[1].beyond);
  EXPECT_THAT(turned.notes, Contains(Field(&TakeNote::text, HasSubstr("is turned by "))));
  EXPECT_THAT(straight.notes, Not(Contains(Field(&TakeNote::text, HasSubstr("is turned by ")))));
}

// A sensor whose ranges are all 12 cm too long, or too short.
TEST(TakeRays, ASensorThatMeasuresTooFarOrTooNearIsNamed) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", walking_spec(1, 8.0));
  const StudySpec study =
      study_of(R"("methods": [{"method": "mean", "calibration": "estimated"}], "alignments": ["none"])");
  for (const float more_m : {0.12f, -0.12f}) {
    Campaign changed = campaign;
    change_session(changed.takes[0], folder / "changed.h5", {[&](std::size_t s, BodyFrame& frame) {
                     for (Body& body : frame.bodies)
                       for (std::array<float, 3>& joint_m : body.position_m)
                         if (s == 1)
                           for (float& axis_m : joint_m) axis_m *= 1.0f + more_m / 2.0f;
                     return true;
                   }});
    const ResultsSummary summary = execute_study(study, changed, folder / "results", {});
    EXPECT_THAT(summary.notes,
                Contains(Field(&TakeNote::text, AllOf(HasSubstr("k2 measures"),
                                                      HasSubstr(more_m > 0.0f ? "too far" : "too near")))));
  }
}

}  // namespace
}  // namespace trilat
