// SPDX-License-Identifier: MIT
// What a simulation assumes goes from the campaign into its results and from there into the report.
#include <algorithm>
#include <mutex>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/simulation_assumptions.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "reports/write_report.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

StudySpec mean_study() { return study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}])"); }

SimulationSpec tracked(double lag_s) {
  SimulationSpec spec = walking_spec(1);
  spec.body_tracker = default_body_tracker();
  spec.body_tracker.lag_s = lag_s;
  return spec;
}

std::string value_of(const std::vector<SimulationAssumption>& parameters, const std::string& name) {
  const auto found = std::ranges::find_if(parameters, [&](const auto& p) { return p.name == name; });
  return found == parameters.end() ? "no " + name : found->value;
}

TEST(Assumptions, AreInTheCampaignItsResultsAndTheReport) {
  const ScratchFolder folder;
  const double usual_s = default_body_tracker().lag_s;
  const Campaign usual = simulate_into(folder / "usual", tracked(usual_s));
  const Campaign slow = simulate_into(folder / "slow", tracked(0.0765));
  execute_study(mean_study(), usual, folder / "a", {});
  execute_study(mean_study(), usual, folder / "b", {});
  execute_study(mean_study(), slow, folder / "c", {});
  EXPECT_EQ(read_file(folder / "usual/simulator.json"), read_file(folder / "a/simulator.json"));
  write_report({folder / "a", folder / "b", folder / "c"}, folder / "report");
  const std::string page = read_file(folder / "report/report.html");
  EXPECT_THAT(page, HasSubstr("What the simulation behind a, b assumes"));
  EXPECT_THAT(page, HasSubstr("What the simulation behind c assumes"));
  EXPECT_THAT(read_file(folder / "report/tables/assumptions/c.csv"),
              testing::ContainsRegex("0\\.0765.*set in the simulation"));
  EXPECT_THAT(read_file(folder / "report/tables/assumptions/a.csv"), Not(HasSubstr("0.0765")));
}

TEST(Assumptions, OfACampaignThatIsSimulatedAgainAreTheNewOnes) {
  const ScratchFolder folder;
  simulate_into(folder / "campaign", tracked(0.01));
  const std::string first = read_file(folder / "campaign/simulator.json");
  simulate_into(folder / "campaign", walking_spec(1));
  EXPECT_NE(read_file(folder / "campaign/simulator.json"), first);
}

TEST(Assumptions, NameEveryPartOfASimulation) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(1, 1.0);
  spec.rig.arc_start_rad = 0.5;
  simulate_into(folder / "campaign", spec);
  const auto parameters = read_simulation_assumptions(folder / "campaign");
  for (const char* name :
       {"rig radius", "sensor heights", "arc of the rig", "start of the arc", "error of the calibration",
        "frame rate", "range", "focal length between units", "image centre between units", "frames lost",
        "clock drift", "participants", "marker noise"})
    EXPECT_THAT(value_of(parameters, name), Not(HasSubstr("no "))) << name;
  EXPECT_THAT(value_of(parameters, "start of the arc"), testing::StartsWith("28.6"));
}

struct RecordedSession {
  ScratchFolder folder;
  SimulationSpec spec = tracked(0.02);
  RecordedSession() {
    simulate_into(folder / "real", walking_spec(1, 2.0));
    spec.activities.clear();
    spec.participants = 1;
    spec.recorded =
        RecordedSpec{folder / "real/p01-walking/mocap.csv", folder / "real/p01-walking/mapping.json"};
  }
};

TEST(Assumptions, OfARecordedTakeNameTheRecordingInPlaceOfThePersonAndTheMocap) {
  RecordedSession recorded;
  const Campaign campaign = simulate_into(recorded.folder / "campaign", recorded.spec);
  const auto parameters = read_simulation_assumptions(recorded.folder / "campaign");
  EXPECT_EQ(value_of(parameters, "motion"), "recorded take");
  EXPECT_EQ(value_of(parameters, "participants"), "1");
  EXPECT_EQ(value_of(parameters, "marker noise"), "no marker noise");
  execute_study(mean_study(), campaign, recorded.folder / "results", {});
  EXPECT_EQ(read_simulation_assumptions(recorded.folder / "results"), parameters);
}

}  // namespace
}  // namespace trilat
