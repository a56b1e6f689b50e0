// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/item_store.h"
#include "datasets/results/stored_take.h"
#include "datasets/rig/calibration.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_writer.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/evaluate_take.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "reports/render/render.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/error_cells.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

constexpr const char* kMethods = R"("methods": [{"method": "linear"},
    {"method": "linear", "name": "linear all pairs", "reference": "all_pairs"}, {"method": "geometric"},
    {"method": "nonlinear"}, {"method": "nonlinear", "name": "nonlinear undamped", "damping": "none"},
    {"method": "ceres"}, {"method": "mean"}, {"method": "tracked_mean", "name": "tracked mean"},
    {"method": "single"}])";
constexpr const char* kFewMethods = R"("methods": [{"method": "linear"}, {"method": "mean"}])";

StudySpec study_with(const std::string& alignments, const char* methods = kMethods) {
  return study_of("\"alignments\": " + alignments + ", " + methods);
}

void expect_every_error_below(const ResultsSummary& summary, double limit_m) {
  EXPECT_EQ(summary.takes_failed, 0u);
  ASSERT_FALSE(error_cells(summary).empty());
  for (const ErrorCell& cell : error_cells(summary)) {
    if (cell.group == kAverageGroup) continue;
    const std::string what = cell.method + " " + cell.group + " " + cell.alignment;
    EXPECT_GT(cell.coverage(), 0.95) << what;
    EXPECT_LT(cell.max_m, limit_m) << what;
  }
}

// Limited by 32-bit floats in the session and six decimals in the export.
TEST(RunLaw, WithoutNoiseAndClockErrorsEveryMethodFindsTheTruth) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", synchronised(without_noise(walking_spec(2))));
  const ResultsSummary summary =
      execute_study(study_with(R"(["none"])"), campaign, folder / "results", {.cross_check = true});
  EXPECT_EQ(error_cells(summary).size(), 5u * 12u);  // four groups and their average
  expect_every_error_below(summary, 1e-5);
  ASSERT_FALSE(summary.cross_checks.empty());
  for (const CrossCheck& check : summary.cross_checks) {
    EXPECT_TRUE(check.passed()) << check.method << " " << check.worst_m;
    EXPECT_GT(check.samples, 50u);  // of every eighth instant
  }
}

TEST(RunLaw, APersonWhoStandsStillIsFoundWhateverTheClocks) {
  const ScratchFolder folder;
  // Long enough for the first and last instants, which not all sensors that run freely see, to be few.
  SimulationSpec spec = without_noise(walking_spec(1, 3.0));
  spec.activities[0].activity = Activity::standing;
  spec.mocap.marker_noise_sigma_m = 0.0;
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  expect_every_error_below(
      execute_study(study_with(R"(["none", "mean", "first"])"), campaign, folder / "results", {}), 2e-5);
}

// Clocks are recovered to 0.2 ms, the mocap's start is known to 5 ms, and a hand moves at 3 m/s.
TEST(RunLaw, ClockErrorsCostNoMoreThanTheMovementMeanwhile) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", without_noise(walking_spec(2, 3.0)));
  const char* methods = R"("methods": [{"method": "mean"}, {"method": "nonlinear"}])";
  expect_every_error_below(
      execute_study(study_with(R"(["none"])", methods), campaign, folder / "results", {}), 0.025);
}

TEST(Run, NoiseOfTheSensorsIsWhatASingleSensorShows) {
  const ScratchFolder folder;
  SimulationSpec spec = synchronised(without_noise(walking_spec(1, 20.0)));
  spec.body_tracker.jitter_sigma_m.fill(0.02);
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  const ResultsSummary summary =
      execute_study(study_with(R"(["none"])", R"("methods": [{"method": "single"}, {"method": "mean"}])"),
                    campaign, folder / "results", {});
  const double one_m = find_cell(summary, "single k1", "walking", "shoulder", "none")->rmse_m;
  const double all_m = find_cell(summary, "mean", "walking", "shoulder", "none")->rmse_m;
  // every instant is a frame here: nothing is interpolated, which would halve the variance at worst
  EXPECT_NEAR(one_m, 0.02 * std::sqrt(3.0), 0.05 * 0.02 * std::sqrt(3.0));
  EXPECT_NEAR(all_m, one_m / 2.0, 0.1 * one_m / 2.0);
}

TEST(Run, EqualSeedsGiveEqualCampaignsAndOtherSeedsOthers) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(2);
  simulate_into(folder / "a", spec);
  simulate_into(folder / "b", spec);
  spec.seed += 1;
  simulate_into(folder / "c", spec);
  for (const char* file : {"p01-walking/session.h5", "p02-walking/mocap.csv", "p02-walking/truth.json"}) {
    EXPECT_EQ(read_file(folder / "a" / file), read_file(folder / "b" / file)) << file;
    EXPECT_NE(read_file(folder / "a" / file), read_file(folder / "c" / file)) << file;
  }
}

// A campaign of four takes on one rig, of which one can be spoilt.
struct Spoilt {
  ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(4));
  Take& take = campaign.takes[1];

  ResultsSummary evaluated() {
    return execute_study(study_with(R"(["mean"])", kFewMethods), campaign, folder / "results", {});
  }
  // The one note of the one take that failed.
  std::string failure() {
    const ResultsSummary summary = evaluated();
    EXPECT_EQ(summary.takes, 4u);
    EXPECT_EQ(summary.takes_failed, 1u);
    std::string text;
    for (const TakeNote& note : summary.notes) {
      if (!note.failed) continue;
      EXPECT_EQ(note.take, take.id);
      text += note.place + ": " + note.text;
    }
    const auto cell = find_cell(summary, "mean", "walking", "head", "mean");
    EXPECT_TRUE(cell);
    if (cell) {
      EXPECT_GT(cell->answered, 3 * 25u);
      EXPECT_LE(cell->asked, 3 * 31u);
      EXPECT_LT(cell->mae_m, 0.1);
    }
    return text;
  }
  void use_session(const std::string& name) { take.session = folder / name; }
};

// Copies a session, frame by frame.
void rewrite_session(const std::filesystem::path& from, const std::filesystem::path& to, std::size_t sensors,
                     const std::function<void(BodyFrame&)>& change) {
  const SessionReader session(from);
  SessionHeader header = session.header();
  header.sensors.resize(sensors);
  SessionWriter writer(to, header);
  for (std::size_t s = 0; s < sensors; ++s) {
    for (BodyFrame& frame : session.body_frames(s, 0, session.counts(s).body_frames)) {
      change(frame);
      writer.add_body_frame(s, frame);
    }
    for (const ClockExchange& exchange : session.clock_exchanges(s)) writer.add_clock_exchange(s, exchange);
  }
  writer.finish();
}

struct BrokenTake {
  const char* name;
  std::function<void(Spoilt&)> spoil;
  const char* said;  // a regular expression
};
void PrintTo(const BrokenTake& broken, std::ostream* out) { *out << broken.name; }

void spoil_calibration(Spoilt& spoilt, const std::function<void(Calibration&)>& change) {
  Calibration calibration = read_calibration(spoilt.take.calibration);
  change(calibration);
  write_calibration(spoilt.folder / "spoilt.json", calibration);
  spoilt.take.calibration = spoilt.folder / "spoilt.json";
}
void spoil_session(Spoilt& spoilt, std::size_t sensors, const std::function<void(BodyFrame&)>& change) {
  rewrite_session(spoilt.take.session, spoilt.folder / "spoilt.h5", sensors, change);
  spoilt.use_session("spoilt.h5");
}

const BrokenTake kBrokenTakes[] = {
    {"truncated session",
     [](Spoilt& s) {
       const std::string bytes = read_file(s.take.session);
       std::ofstream(s.folder / "cut.h5", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
       s.use_session("cut.h5");
     },
     "cut\\.h5"},
    {"missing session", [](Spoilt& s) { s.use_session("absent.h5"); }, "absent\\.h5: does not exist"},
    {"missing mocap", [](Spoilt& s) { s.take.mocap = s.folder / "absent.csv"; },
     "absent\\.csv: cannot be opened"},
    {"mocap that is no export",
     [](Spoilt& s) {
       write_file(s.folder / "other.csv", "a,b,c\n1,2,3\n");
       s.take.mocap = s.folder / "other.csv";
     },
     "other\\.csv"},
    {"session of one sensor", [](Spoilt& s) { spoil_session(s, 1, [](BodyFrame&) {}); },
     "spoilt\\.h5.*k2.*it has k1"},
    {"session without any body",
     [](Spoilt& s) { spoil_session(s, 4, [](BodyFrame& frame) { frame.bodies.clear(); }); },
     "spoilt\\.h5: no sensor ever sees a joint"},
    {"session of nothing but NaN",
     [](Spoilt& s) {
       spoil_session(s, 4, [](BodyFrame& frame) {
         for (Body& body : frame.bodies)
           for (auto& point : body.position_m) point.fill(std::numeric_limits<float>::quiet_NaN());
       });
     },
     "spoilt\\.h5: no sensor ever sees a joint"},
    {"calibration that lacks a sensor",
     [](Spoilt& s) { spoil_calibration(s, [](Calibration& c) { c.sensors.pop_back(); }); },
     "spoilt\\.json: has no pose for sensor \"k4\"; it has k1, k2, k3"},
    {"calibration in another world than the truth",
     [](Spoilt& s) { spoil_calibration(s, [](Calibration& c) { c.world = "wand"; }); },
     "spoilt\\.json /world: is \"wand\", but the ground truth is in OptiTrack's"}};

class RunWithABrokenFile : public testing::TestWithParam<BrokenTake> {};
INSTANTIATE_TEST_SUITE_P(Files, RunWithABrokenFile, testing::ValuesIn(kBrokenTakes));

TEST_P(RunWithABrokenFile, FailsThatTakeAlone) {
  Spoilt spoilt;
  GetParam().spoil(spoilt);
  EXPECT_THAT(spoilt.failure(), testing::ContainsRegex(GetParam().said));
}

TEST(RunWithABrokenTake, AMappingToAnAssetThatDoesNotExistListsThoseThatDo) {
  Spoilt spoilt;
  write_mapping(spoilt.folder / "mapping.json", {{{Joint::head, {"hat"}}}});
  spoilt.take.mapping = spoilt.folder / "mapping.json";
  const std::string failure = spoilt.failure();
  EXPECT_THAT(failure, testing::AllOf(HasSubstr("mapping.json /joints/head: "), HasSubstr("\"hat\"")));
  EXPECT_THAT(failure, HasSubstr("head_1"));
  EXPECT_THAT(failure, HasSubstr("and 8 more"));
}

TEST(RunWithABrokenTake, NoOverlapInTimeNamesBothIntervals) {
  Spoilt spoilt;
  spoilt.take.mocap_start_host_ns += 100'000'000'000;
  const std::string failure = spoilt.failure();
  EXPECT_THAT(failure, HasSubstr("mocap.csv: holds no ground truth for the time of the session"));
  EXPECT_THAT(failure,
              testing::ContainsRegex("the session runs from -(100|99)\\.[0-9]+ s to -(99|98)\\.[0-9]+ s"));
  EXPECT_THAT(failure, HasSubstr("the export from 0 s to 1.000 s"));
}

TEST(RunWithABrokenTake, ASessionBehindTheEndOfTheExportNamesBothIntervals) {
  Spoilt spoilt;
  spoilt.take.mocap_start_host_ns -= 100'000'000'000;
  const std::string failure = spoilt.failure();
  EXPECT_THAT(failure, testing::ContainsRegex("the session runs from 100\\.[0-9]+ s to 10[01]\\.[0-9]+ s"));
  EXPECT_THAT(failure, HasSubstr("the export from 0 s to 1.000 s"));
}

// A start of the export in another unit than nanoseconds is tried before it is named.
TEST(RunWithABrokenTake, AStartInAnotherUnitIsNamedWithTheNumberToWrite) {
  const auto failure_at = [](std::int64_t divide_by, std::int64_t later_ns = 0) {
    Spoilt spoilt;
    spoilt.take.mocap_start_host_ns = (spoilt.take.mocap_start_host_ns + later_ns) / divide_by;
    return spoilt.failure();
  };
  EXPECT_THAT(failure_at(1'000),
              testing::ContainsRegex("session's time if [0-9]+ were microseconds: write [0-9]+000$"));
  EXPECT_THAT(failure_at(1'000'000),
              testing::ContainsRegex("session's time if [0-9]+ were milliseconds: write [0-9]+000000$"));
  EXPECT_THAT(
      failure_at(1'000'000'000, 500'000'000),
      testing::ContainsRegex("session's time if (999|1000) were seconds: write (999|1000)000000000$"));
  for (const std::int64_t later_ns : {100'000'000'000, -100'000'000'000})
    EXPECT_THAT(
        failure_at(1, later_ns),
        testing::ContainsRegex("the recording's clock ran from [0-9]+ to [0-9]+ ns: what did it show at the "
                               "export's first frame"));
  EXPECT_THAT(failure_at(1'000, 100'000'000'000), testing::Not(HasSubstr("were microseconds")));
}

// The rig is not what a broken first take happens to have.
TEST(RunWithABrokenTake, AFirstTakeOfOneSensorFailsAlone) {
  Spoilt spoilt;
  Take& first = spoilt.campaign.takes[0];
  rewrite_session(first.session, spoilt.folder / "one.h5", 1, [](BodyFrame&) {});
  first.session = spoilt.folder / "one.h5";
  const ResultsSummary summary = spoilt.evaluated();
  EXPECT_EQ(summary.takes_failed, 1u);
  ASSERT_FALSE(summary.notes.empty());
  EXPECT_THAT(summary.notes[0].place + summary.notes[0].text, HasSubstr("one.h5"));
  EXPECT_GT(find_cell(summary, "linear", "walking", "head", "mean")->coverage(), 0.9);
}

TEST(RunWithABrokenTake, NaNAndInfinityHereAndThereCostOnlyTheirOwnSamples) {
  Spoilt spoilt;
  const double good_m = find_cell(spoilt.evaluated(), "mean", "walking", "head", "mean")->mae_m;
  rewrite_session(spoilt.take.session, spoilt.folder / "nan.h5", 4, [](BodyFrame& frame) {
    for (Body& body : frame.bodies) {
      if (frame.stamp.sequence % 5 == 0) body.position_m[3][1] = std::numeric_limits<float>::quiet_NaN();
      if (frame.stamp.sequence % 5 == 2) body.position_m[3][2] = std::numeric_limits<float>::infinity();
    }
  });
  spoilt.use_session("nan.h5");
  const ResultsSummary summary = spoilt.evaluated();
  EXPECT_EQ(summary.takes_failed, 0u);
  EXPECT_LT(find_cell(summary, "mean", "walking", "head", "mean")->mae_m, 2.0 * good_m);
}

TEST(RunWithABrokenTake, ItHasNoItemAndTheOthersHave) {
  Spoilt spoilt;
  spoilt.take.mocap = spoilt.folder / "absent.csv";
  spoilt.failure();
  const std::vector<ResultTake> takes = result_takes(spoilt.folder / "results");
  ASSERT_EQ(takes.size(), 4u);
  for (std::size_t t = 0; t < takes.size(); ++t) EXPECT_EQ(takes[t].folder.empty(), t == 1) << t;
}

TEST(Run, ACampaignWhereEveryTakeIsBrokenSaysWhy) {
  Spoilt spoilt;
  for (Take& take : spoilt.campaign.takes) take.session = spoilt.folder / "absent.h5";
  EXPECT_THAT(message_of([&] { spoilt.evaluated(); }), HasSubstr("absent.h5"));
}

}  // namespace
}  // namespace trilat
