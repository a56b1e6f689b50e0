// SPDX-License-Identifier: MIT
#include "pipeline/recording/recording_study.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/declared_parameters.h"
#include "datasets/results/studies/recording_summary.h"
#include "datasets/results/studies/timings.h"
#include "pipeline/recording/clock_methods.h"
#include "tests/pipeline/program.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

RecordingSpec spec_of(const std::string& members) {
  const std::string text =
      R"({"format": "trilat.study", "version": 1, "kind": "recording", "name": "test")" + members + "}";
  return parse_recording_spec(parse_json(text, "study.json"), "study.json");
}

std::string refusal(const std::string& members) {
  return message_of([&] { spec_of(members); });
}

TEST(RecordingSpec, ErrorsNameThePlaceAndWhatWouldBeRight) {
  EXPECT_EQ(refusal(""), "no error");
  EXPECT_THAT(refusal(R"(, "frame": 3)"), AllOf(HasSubstr("study.json /frame"), HasSubstr("frames")));
  EXPECT_THAT(refusal(R"(, "frames": 1)"), HasSubstr("/frames: must be 2 to 200000, is 1"));
  EXPECT_THAT(refusal(R"(, "networks": [])"), HasSubstr("/networks: must hold at least one"));
  EXPECT_THAT(refusal(R"(, "networks": [{"name": "a"}, {"name": "a"}])"),
              HasSubstr("/networks/1/name: stands there twice"));
  EXPECT_THAT(refusal(R"(, "networks": [{"name": "a", "asymmetry_s": -0.1}])"),
              HasSubstr("/networks/0/asymmetry_s: makes messages arrive before they are sent"));
  EXPECT_THAT(refusal(R"(, "networks": [{"name": "a", "lost_share": 1.1}])"),
              HasSubstr("/networks/0/lost_share"));
  EXPECT_THAT(refusal(R"(, "late_s": -0.1)"), HasSubstr("/late_s: must lie between 0 and 10"));
  EXPECT_THAT(refusal(R"(, "body_tracking_s": 2)"), HasSubstr("/body_tracking_s: must lie between"));
  EXPECT_THAT(refusal(R"(, "methods": [{"name": "a", "method": "kalman"}])"),
              HasSubstr("/methods/0/method: must be one that takes a frame by itself"));
  EXPECT_THAT(refusal(R"(, "methods": [{"name": "a", "method": "mean", "sensors": ["k9"]}])"),
              HasSubstr("k9"));
  EXPECT_THAT(refusal(R"(, "methods": [{"name": "a", "method": "mean", "occlusion": "printed"}])"),
              HasSubstr("/methods/0/occlusion: is of no use"));
}

TEST(RecordingSpec, WrittenOutInFullItReadsBackAsItself) {
  const RecordingSpec spec = spec_of(
      R"(, "seed": 3, "frames": 90, "networks": [{"name": "a", "jitter_s": 0.001, "jitter_back_s": 0.02}],
         "methods": [{"name": "mean", "method": "mean"}])");
  EXPECT_EQ(spec.networks[0].jitter_back_s, 0.02);
  for (const RecordingSpec& written : {spec, spec_of("")}) {
    const Json json = resolved_json(written);
    EXPECT_EQ(resolved_json(parse_recording_spec(json, "resolved.json")), json);
  }
}

// By right clocks nothing comes from the future; a machine's clock that is taken for the server's is off by
// up to a second, and its frames are dropped for it.
TEST(RecordingStudy, AWrongClockMakesTheQueueDropFramesThatCameInTime) {
  const ScratchFolder folder;
  run_study(recording_study(spec_of(R"(, "frames": 900, "runs": 2, "clock_offset_s": 1)")), folder / "out",
            {.threads = 1});
  const RecordingSummary summary = read_results<RecordingSummary>(folder / "out");
  ASSERT_EQ(summary.queues.size(), 6u * 2);  // the sensor's ticks do not tell when a frame was sent
  const auto counts = [&](ClockMethod method, std::size_t way) {
    return summary.queues.at(2 * static_cast<std::size_t>(method) + way).counts;
  };
  for (const QueueRow& row : summary.queues) EXPECT_EQ(row.counts.came, 900u * 4 * 2);
  EXPECT_EQ(counts(ClockMethod::corrected, 0).taken, 7200u);
  EXPECT_GT(counts(ClockMethod::none, 0).too_early, 0u);
  EXPECT_GT(counts(ClockMethod::none, 0).too_late, 0u);
  EXPECT_LT(counts(ClockMethod::none, 0).taken, 3600u);
  EXPECT_EQ(counts(ClockMethod::corrected, 1).too_early, 0u);
  EXPECT_LE(counts(ClockMethod::corrected, 1).taken, 7200u);
  EXPECT_EQ(summary.late_s, 1.0 / 30.0);
}

const ClockErrorRow& row_of(const RecordingSummary& summary, ClockMethod method) {
  return summary.clocks.at(static_cast<std::size_t>(method));
}

TEST(RecordingStudy, ATinyOneReadsBack) {
  const ScratchFolder folder;
  const RecordingSpec spec = spec_of(
      R"(, "frames": 900, "runs": 2, "methods": [{"name": "linear", "method": "linear"},
         {"name": "single", "method": "single"}])");
  run_study(recording_study(spec), folder / "1", {});
  const RecordingSummary summary = read_results<RecordingSummary>(folder / "1");
  ASSERT_EQ(summary.clocks.size(), clock_method_names().size());
  EXPECT_EQ(row_of(summary, ClockMethod::none).asked, 900u * 4 * 2);
  EXPECT_LT(row_of(summary, ClockMethod::corrected).error.max_s, 0.0005);
  EXPECT_LT(row_of(summary, ClockMethod::corrected_ticks).error.max_s, 0.0005);
  EXPECT_EQ(row_of(summary, ClockMethod::corrected).below_2ms, 1.0);
  // What a live system can do lies between the fit of all exchanges and the latest exchange alone.
  EXPECT_GT(row_of(summary, ClockMethod::corrected_causal).error.p95_s,
            row_of(summary, ClockMethod::corrected).error.p95_s);
  EXPECT_LT(row_of(summary, ClockMethod::corrected_causal).error.p95_s,
            row_of(summary, ClockMethod::printed_client).error.p95_s);
  EXPECT_GT(row_of(summary, ClockMethod::none).error.median_s,
            row_of(summary, ClockMethod::first_exchange).error.median_s);
  EXPECT_GT(row_of(summary, ClockMethod::printed).error.median_s, 0.005);
  const ClockErrorRow& none = row_of(summary, ClockMethod::none);
  ASSERT_EQ(none.units.size(), 4u * 2);
  std::uint64_t below_4ms = 0;
  for (const ClockUnit& unit : none.units) {
    EXPECT_EQ(unit.asked, 900u);
    EXPECT_EQ(unit.answered, 900u);
    // A machine's clock is off by much the same all the time.
    EXPECT_TRUE(unit.below_4ms == 0 || unit.below_4ms == 900u) << unit.below_4ms;
    below_4ms += unit.below_4ms;
  }
  EXPECT_EQ(below_4ms, none.error.bins[0] + none.error.bins[1]);
  EXPECT_EQ(summary.fits.at(0).within_bound_share, 1.0);
  const auto timings = read_beside<StageTimings>(folder / "1");
  ASSERT_TRUE(timings.has_value());
  ASSERT_EQ(timings->stages.size(), 2 * 5u);  // linear, and each single sensor
  for (const StageTiming& stage : timings->stages) EXPECT_EQ(stage.time.n, 900u);
  for (std::size_t m = 0; m < 5; ++m) {
    EXPECT_LT(timings->stages[m].time.median_s, 0.005);
    EXPECT_EQ(timings->stages[5 + m].name, kDepthToJoints);
    EXPECT_EQ(timings->stages[5 + m].method, timings->stages[m].method);
    EXPECT_GT(timings->stages[5 + m].time.median_s, 0.005 + timings->stages[m].time.median_s);
  }
  EXPECT_FALSE(read_declared_parameters(folder / "1").empty());
}

TEST(RecordingVerb, PrintsTablesOrOneJsonDocumentOrThePlan) {
  const ScratchFolder folder;
  const std::string results = folder / "results";
  const std::string study = file_with(
      folder, "study.json",
      R"({"format": "trilat.study", "version": 1, "kind": "recording", "name": "clocks", "frames": 300, "runs": 1,
          "methods": [{"method": "mean"}]})");
  const Ended plan = run_trilat(folder, {"run", study, "--dry-run", "--json"});
  EXPECT_EQ(only_json(plan)["samples_of_each_network"], 1200);
  EXPECT_FALSE(std::filesystem::exists(folder / "results"));
  const Ended text = run_trilat(folder, {"run", study, "-o", results});
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_THAT(text.out, AllOf(HasSubstr("Table IV, clock errors, simulated"), HasSubstr("measured on")));
  const Ended json = run_trilat(folder, {"run", study, "-o", results, "--json"});
  EXPECT_EQ(only_json(json)["simulated"], true);
  EXPECT_EQ(run_trilat(folder, {"report", results, "-o", folder / "report"}).code, 0);
  EXPECT_THAT(read_file(folder / "report/tables/assumptions/results.csv"), HasSubstr("arrival jitter"));
  expect_refused(run_trilat(folder, {"run", study, "-o", results, "--cross-check"}), "--cross-check: is for");
  expect_refused(run_trilat(folder, {"run", study, "-o", results, "--campaign", "c"}),
                 "--campaign: is of no use");
}

}  // namespace
}  // namespace trilat
