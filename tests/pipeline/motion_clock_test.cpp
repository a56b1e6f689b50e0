// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>

#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/take/truth_track.h"
#include "pipeline/accuracy/tracking_summary.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/rewritten_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

constexpr const char* kByMotion =
    R"("alignments": ["none"], "clock": "motion", "methods": [{"method": "mean"}])";

// The clocks' row of a walk whose mocap is stated so much too late; `others`: somebody else is in view, too.
ClockOffsetRow clock_of(const SimulationSpec& spec, double late_s, const SessionChange& change = {},
                        bool others = false) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", spec);
  Take& take = campaign.takes[0];
  take.mocap_start_host_ns += std::llround(late_s * 1e9);
  change_session(take, folder / "changed.h5", change);
  if (others) add_bodies_of(take, simulate_other_person(folder / "other", spec), folder / "two.h5");
  const ResultsSummary summary = execute_study(study_of(kByMotion), campaign, folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  const auto tracking = read_json_file<TrackingSummary>(folder / "results");
  EXPECT_EQ(tracking->clocks.size(), 1u);
  return tracking->clocks.at(0);
}

TEST(MotionClock, IsFoundThoughMarkersAreLostNowAndThen) {
  SimulationSpec spec = synchronised(walking_spec(1, 20.0));
  spec.mocap.gap_share = 0.05;
  const ClockOffsetRow clock = clock_of(spec, 0.080);
  EXPECT_EQ(clock.status, "found");
  EXPECT_NEAR(clock.offset_s, 0.080, 0.005);
  EXPECT_LT(clock.low_s, clock.high_s);
}

TEST(MotionClock, IsFoundThoughTwoSensorsAreBlindForSeconds) {
  const ClockOffsetRow clock =
      clock_of(synchronised(walking_spec(1, 20.0)), -0.050, {[](std::size_t sensor, BodyFrame& frame) {
                 if (sensor < 2 && frame.stamp.sequence > 200 && frame.stamp.sequence < 350)
                   frame.bodies.clear();
                 return true;
               }});
  EXPECT_EQ(clock.status, "found");
  EXPECT_NEAR(clock.offset_s, -0.050, 0.005);
}

TEST(MotionClock, IsThatOfThePersonWithTheMarkersThoughOthersMoveToo) {
  SimulationSpec spec = synchronised(walking_spec(1, 20.0));
  spec.body_tracker = exact_body_tracker();
  const ClockOffsetRow clock = clock_of(spec, 0.080, {}, true);
  EXPECT_EQ(clock.status, "found");
  EXPECT_NEAR(clock.offset_s, 0.080, 0.005);
}

// A stride of this walk takes 1.1 s, and its speeds repeat themselves: only the place tells strides apart.
TEST(MotionClock, IsFoundThoughItIsStridesAway) {
  for (const double late_s : {0.45, -0.8, 1.1, 2.0, -2.0}) {
    const ClockOffsetRow clock = clock_of(synchronised(walking_spec(1, 20.0)), late_s);
    EXPECT_EQ(clock.status, "found") << late_s;
    EXPECT_NEAR(clock.offset_s, late_s, 0.005);
  }
}

TEST(MotionClock, BeyondTheSearchNoStrideIsTakenForIt) {
  for (const double late_s : {3.4, -4.4, 5.5}) {
    const ClockOffsetRow clock = clock_of(synchronised(walking_spec(1, 20.0)), late_s);
    EXPECT_NE(clock.status, "found") << late_s << ": " << clock.offset_s;
    EXPECT_FALSE(clock.applied) << late_s;
  }
}

// Of a walk whose mocap is stated so much too late.
std::string notes_of(const SimulationSpec& spec, double late_s, const char* clock) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", spec);
  campaign.takes[0].mocap_start_host_ns += std::llround(late_s * 1e9);
  const StudySpec study = study_of(
      std::string(R"("alignments": ["none"], "methods": [{"method": "mean"}], "clock": ")") + clock + '"');
  std::string text;
  for (const TakeNote& note : execute_study(study, campaign, folder / "results", {}).notes)
    text += note.text + '\n';
  return text;
}

TEST(MotionClock, AStartThatIsOffIsToldWithWhatItCosts) {
  const SimulationSpec spec = synchronised(walking_spec(1, 20.0));
  EXPECT_THAT(notes_of(spec, 0.2, "check"), testing::AllOf(testing::HasSubstr("earlier than stated"),
                                                           testing::HasSubstr("mocap_start_host_ns")));
  EXPECT_THAT(notes_of(spec, -2.0, "check"), testing::HasSubstr("later than stated"));
  EXPECT_THAT(notes_of(spec, 0.2, "motion"), testing::HasSubstr("was applied"));
  EXPECT_THAT(notes_of(spec, 4.4, "check"),
              testing::HasSubstr("write \"mocap_start_host_ns\": 1000000000000, or write"));
}

// One period fits as well as another, also at the end of the search.
TEST(MotionClock, ArmsThatSwingOnTheSpotAreNoWarning) {
  SimulationSpec spec = walking_spec(6, 15.0);
  spec.activities[0].activity = Activity::arm_swing;
  spec.body_tracker = default_body_tracker();
  EXPECT_EQ(notes_of(spec, 0.0, "check"), "");
}

TEST(MotionClock, TheLagOfTrackersIsNoWarning) {
  SimulationSpec spec = walking_spec(2, 20.0);
  spec.body_tracker = default_body_tracker();
  EXPECT_EQ(notes_of(spec, 0.0, "check"), "");
}

}  // namespace
}  // namespace trilat
