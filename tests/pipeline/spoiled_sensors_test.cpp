// SPDX-License-Identifier: MIT
// Sensors that deliver what they did not see: late, mirrored, of another person, at impossible places.
#include "tests/pipeline/error_cells.h"
#include "tests/pipeline/spoiled_takes.h"

namespace trilat {
namespace {

using namespace spoiled;

TEST(SpoiledSensors, OfThreeTheMirroredOneIsNamedAndNoOther) {
  const ScratchFolder folder;
  SimulationSpec spec = recorded_spec();
  spec.rig.heights_m.resize(3);
  Recorded recorded{simulate_into(folder / "campaign", spec), folder.path()};
  tracked(1, [](Eigen::Vector3f& point, std::size_t) { point.x() = -point.x(); })(recorded);
  const std::string notes =
      notes_of(execute_study(study_of(kMeanOfStatedClock), recorded.campaign, folder / "results", {}));
  expect_one_note(notes, {"k2 sees the person as in a mirror"});
  EXPECT_THAT(notes, testing::Not(testing::ContainsRegex("(k1|k3) sees")));
}

class LateClocks : public testing::TestWithParam<int> {};

// Also where the joints correlate well without shifting; and not the sensor's pose is blamed.
TEST_P(LateClocks, AreNamedWithTheirOffset) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(1, 34.0);
  spec.body_tracker = default_body_tracker();
  Recorded recorded{simulate_into(folder / "campaign", spec), folder.path()};
  delayed(1, GetParam())(recorded);
  const std::string notes =
      notes_of(execute_study(study_of(kMeanOfStatedClock), recorded.campaign, folder / "results", {}));
  const std::string about = "k2 shows movements ";
  const std::size_t at = notes.find(about);
  ASSERT_NE(at, std::string::npos) << notes;
  EXPECT_NEAR(std::stod(notes.substr(at + about.size())), 1e-3 * GetParam(), 0.03) << notes;
  EXPECT_EQ(notes.find("by the pose it has"), std::string::npos) << notes;
  EXPECT_EQ(std::ranges::count(notes, '\n'), 1) << notes;
}

INSTANTIATE_TEST_SUITE_P(Milliseconds, LateClocks, testing::Values(120, 150, 200, 300, 500, 800));

// Taken as the same person, that second would put the mean a third of a metre off.
TEST(SpoiledSensors, ABodyThatJumpsToAnotherPersonIsNotTaken) {
  const ScratchFolder folder;
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  const StudySpec study = study_of(kMean);
  const double sound_m = error_cells(execute_study(study, recorded.campaign, folder / "sound", {}))[0].max_m;
  jump_to_another(recorded);
  EXPECT_LT(error_cells(execute_study(study, recorded.campaign, folder / "jumping", {}))[0].max_m,
            sound_m + 0.1);
}

TEST(SpoiledSensors, AJointAtTheSensorIsNotTaken) {
  const ScratchFolder folder;
  Recorded recorded{simulate_into(folder / "campaign", recorded_spec()), folder.path()};
  const StudySpec study =
      study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}, {"method": "range_bearing"}])");
  joint_put(0, Joint::wrist_left, {0.0F, 0.0F, 1e8F})(recorded);
  const ResultsSummary summary = execute_study(study, recorded.campaign, folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  for (const ErrorCell& cell : error_cells(summary)) {
    if (cell.group == kAverageGroup) continue;
    EXPECT_LT(cell.max_m, 0.5) << cell.method << " " << cell.group;
  }
}

}  // namespace
}  // namespace trilat
