// SPDX-License-Identifier: MIT
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/recording_study/clock_methods.h"
#include "pipeline/recording_study/execute_recording.h"
#include "pipeline/recording_study/frame_queue.h"
#include "pipeline/recording_study/spread_times.h"
#include "tests/pipeline/program.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;

RecordingSpec spec_of(const std::string& members) {
  const std::string text =
      R"({"format": "trilat.study", "version": 1, "kind": "recording", "capture_s": 0.5, "name": "test")" +
      members + "}";
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
  EXPECT_THAT(refusal(R"(, "late_s": -0.1)"), HasSubstr("/late_s: must lie between 0.0 and 10.0"));
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
      R"(, "seed": 3, "frames": 90, "networks": [{"name": "a", "jitter_s": 0.001}],
         "methods": [{"name": "mean", "method": "mean"}])");
  for (const RecordingSpec& written : {spec, spec_of("")}) {
    const Json json = resolved_json(written);
    EXPECT_EQ(resolved_json(parse_recording_spec(json, "resolved.json")), json);
  }
}

// One in each range, on their lower edges, and one that is no number.
TEST(SpreadTimes, RangesBeginOnTheirEdges) {
  const TimeSpread spread =
      spread_times({0.0, 0.002, 0.004, 0.011, 0.022, 0.033, std::numeric_limits<double>::quiet_NaN()});
  EXPECT_EQ(spread.n, 6u);
  EXPECT_THAT(spread.bins, Each(1u));
  EXPECT_EQ(spread_times({0.0019999, 0.0329999, 5.0}).bins, (TimeSpread{3, {1, 0, 0, 0, 1, 1}}.bins));
}

// 0 to 1000 ms in steps of one: quantiles are the numbers themselves.
TEST(SpreadTimes, QuantilesByPencil) {
  std::vector<double> times_s;
  for (int i = 1000; i >= 0; --i) times_s.push_back(1e-3 * i);
  const TimeSpread spread = spread_times(times_s);
  EXPECT_NEAR(spread.median_s, 0.5, 1e-12);
  EXPECT_NEAR(spread.p95_s, 0.95, 1e-12);
  EXPECT_NEAR(spread.p99_s, 0.99, 1e-12);
  EXPECT_NEAR(spread.p999_s, 0.999, 1e-12);
  EXPECT_NEAR(spread.max_s, 1.0, 1e-12);
  EXPECT_TRUE(std::isnan(spread_times({}).median_s));
}

// A client 10 ms ahead; a message takes 1 ms there and back; one frame, 2 ms on its way.
ClockTrial pencil_trial() {
  constexpr std::int64_t kMs = 1'000'000;
  ClockTrial trial;
  trial.exchanges = {{100 * kMs, 111 * kMs, 112 * kMs, 103 * kMs}};
  trial.frames = {{{0, 0, 60 * kMs}, {30 * kMs}, {50 * kMs}, {52 * kMs}},
                  {{1, 0, 210 * kMs}, {180 * kMs}, {200 * kMs}, {202 * kMs}}};
  return trial;
}

TEST(ClockMethods, TheErrorsOfAnExchangeByPencil) {
  const ClockTrial trial = pencil_trial();
  const auto second_ms = [&](ClockMethod method) { return 1e3 * clock_errors_s(trial, method)[1]; };
  EXPECT_NEAR(second_ms(ClockMethod::none), 10.0, 1e-9);
  EXPECT_NEAR(second_ms(ClockMethod::first_exchange), 0.0, 1e-9);
  EXPECT_NEAR(second_ms(ClockMethod::corrected), 0.0, 1e-9);
  // D = 1 ms, E = -10 ms: 202 - 1 + 10 = 211 ms, where 210 is the client's time and 200 the server's
  EXPECT_NEAR(second_ms(ClockMethod::printed_client), 1.0, 1e-9);
  EXPECT_NEAR(second_ms(ClockMethod::printed), 11.0, 1e-9);
}

TEST(ClockMethods, BeforeAnyExchangeThePrintedOnesHaveNoAnswer) {
  const ClockTrial trial = pencil_trial();
  EXPECT_TRUE(std::isnan(clock_errors_s(trial, ClockMethod::printed)[0]));
  EXPECT_TRUE(std::isnan(clock_errors_s(trial, ClockMethod::printed_client)[0]));
  ClockTrial silent = trial;
  silent.exchanges.clear();
  for (std::size_t m = 1; m < clock_method_names().size(); ++m)
    EXPECT_TRUE(std::isnan(clock_errors_s(silent, static_cast<ClockMethod>(m))[1])) << m;
}

// A client 10 ms ahead, asked every 100 ms. Exchange 0 takes 1 ms each way; the others 1 ms back but 1 + k ms
// there, so that by them the client seems to be k / 2 ms further ahead. Frames are sent as soon as they are
// made and take 1 ms.
ClockTrial slower_and_slower(std::int64_t exchanges, const std::vector<std::int64_t>& frames_ms) {
  constexpr std::int64_t kMs = 1'000'000;
  ClockTrial trial;
  for (std::int64_t k = 0; k < exchanges; ++k) {
    const std::int64_t t1 = 100 * k, t2 = t1 + 1 + k;
    trial.exchanges.push_back({t1 * kMs, (t2 + 10) * kMs, (t2 + 10) * kMs, (t2 + 1) * kMs});
  }
  for (std::int64_t at : frames_ms)
    trial.frames.push_back({{0, 0, (at + 10) * kMs}, {at * kMs}, {at * kMs}, {(at + 1) * kMs}});
  return trial;
}

TEST(ClockMethods, TheCausalOneTakesTheLeastDelayOfTheLastEightExchangesThatTheServerHas) {
  // Answers come at 2, 103, 204, …; at 1 none has come, at 710 eight have, and from 810 on the first is too
  // old.
  const auto errors_s =
      clock_errors_s(slower_and_slower(10, {0, 50, 150, 709, 811, 950}), ClockMethod::corrected_causal);
  EXPECT_TRUE(std::isnan(errors_s[0]));
  EXPECT_NEAR(errors_s[1], 0.0, 1e-12);
  EXPECT_NEAR(errors_s[2], 0.0, 1e-12);
  EXPECT_NEAR(errors_s[3], 0.0, 1e-12);
  EXPECT_NEAR(errors_s[4], -0.0005, 1e-12);
  EXPECT_NEAR(errors_s[5], -0.001, 1e-12);
}

TEST(ClockMethods, TheCausalOneDoesNotChangeByWhatComesLater) {
  const RecordingSpec spec = spec_of(R"(, "frames": 300)");
  ClockTrial trial = simulate_clocks(spec, {}, 0, 1);
  const auto all_s = clock_errors_s(trial, ClockMethod::corrected_causal);
  std::erase_if(trial.exchanges,
                [&](const ClockExchange& e) { return e.t4_ns > trial.frames[150].received.ns; });
  trial.frames.resize(151);
  const auto first_s = clock_errors_s(trial, ClockMethod::corrected_causal);
  for (std::size_t f = 1; f < first_s.size(); ++f) EXPECT_EQ(first_s[f], all_s[f]) << f;
  EXPECT_NE(clock_errors_s(trial, ClockMethod::corrected)[100], 0.0);
}

TEST(ClockTrial, NetworksAreComparedOnTheSameDraws) {
  const RecordingSpec spec = spec_of(R"(, "frames": 60)");
  NetworkSpec other;
  other.asymmetry_s = 0.002;
  const ClockTrial a = simulate_clocks(spec, {}, 0, 1), b = simulate_clocks(spec, other, 0, 1);
  ASSERT_EQ(a.exchanges.size(), b.exchanges.size());
  EXPECT_NEAR(static_cast<double>(b.exchanges[3].t2_ns - a.exchanges[3].t2_ns), 2e6, 200.0);
  EXPECT_EQ(a.frames[10].stamp.arrival_ns, b.frames[10].stamp.arrival_ns);
  EXPECT_NE(a.frames[10].stamp.arrival_ns, simulate_clocks(spec, {}, 1, 1).frames[10].stamp.arrival_ns);
}

TEST(ClockTrial, ALoadedWayBackLeavesTheWayThereAlone) {
  const RecordingSpec spec = spec_of(R"(, "frames": 60, "networks": [{"name": "a", "jitter_back_s": 0.02}])");
  ASSERT_EQ(spec.networks[0].jitter_back_s, 0.02);
  const ClockTrial a = simulate_clocks(spec, {}, 0, 1), b = simulate_clocks(spec, spec.networks[0], 0, 1);
  double there_ns = 0.0, back_ns = 0.0;
  for (std::size_t i = 0; i < a.exchanges.size(); ++i) {
    there_ns = std::max(there_ns, std::abs(static_cast<double>(b.exchanges[i].t2_ns - a.exchanges[i].t2_ns)));
    back_ns = std::max(back_ns, static_cast<double>(b.exchanges[i].t4_ns - a.exchanges[i].t4_ns));
  }
  EXPECT_EQ(there_ns, 0.0);
  EXPECT_GT(back_ns, 1e7);
}

TEST(ClockTrial, ASensorExposesAtTheRateOfItsOwnClock) {
  const RecordingSpec spec = spec_of(R"(, "frames": 18000)");
  double slowest_s = 0.0;
  for (std::uint64_t sensor = 0; sensor < 4; ++sensor) {
    const ClockTrial trial = simulate_clocks(spec, {}, 0, sensor);
    const TrialFrame &first = trial.frames.front(), &last = trial.frames.back();
    const double by_sensor_s =
        1e-9 *
        static_cast<double>((last.stamp.device_ticks - first.stamp.device_ticks) * trial.sensor.tick_ns);
    const double by_server_s = 1e-9 * static_cast<double>(last.exposure.ns - first.exposure.ns);
    EXPECT_NEAR(by_sensor_s, 17999.0 / 30.0, 2e-6);
    EXPECT_NEAR(by_server_s, 17999.0 / 30.0, 1.001 * 30e-6 * 600.0);
    slowest_s = std::max(slowest_s, std::abs(by_server_s - 17999.0 / 30.0));
  }
  EXPECT_GT(slowest_s, 0.001);
}

TEST(ClockTrial, ALateFrameHoldsUpThoseBehindIt) {
  const RecordingSpec spec = spec_of(R"(, "frames": 300, "networks": [{"name": "a", "jitter_back_s": 0.2}])");
  const ClockTrial trial = simulate_clocks(spec, spec.networks[0], 0, 1);
  std::size_t held_up = 0;
  for (std::size_t f = 1; f < trial.frames.size(); ++f) {
    EXPECT_GE(trial.frames[f].received.ns, trial.frames[f - 1].received.ns) << f;
    held_up += trial.frames[f].received == trial.frames[f - 1].received;
  }
  EXPECT_GT(held_up, 100u);
}

struct QueuePencil {
  std::vector<TrialFrame> frames;
  std::vector<double> errors_s;
};

QueuePencil pencil_queue() {
  constexpr std::int64_t kMs = 1'000'000;
  const double none = std::numeric_limits<double>::quiet_NaN();
  QueuePencil pencil;
  const auto add = [&](std::int64_t sent, std::int64_t received, double error_s) {
    pencil.frames.push_back({{}, {}, {sent * kMs}, {received * kMs}});
    pencil.errors_s.push_back(error_s);
  };
  add(10, 12, 0.0);
  add(40, 61, 0.0);  // the server's frame at 60 began while it was on its way
  add(70, 72, 0.0);
  add(85, 86, 0.0);  // the frame at 90 is that of the one before
  add(100, 101, 0.0);
  add(130, 131, 0.1);  // seems to come from the future
  add(140, 141, none);
  add(150, 180, 0.0);  // just as old as is allowed
  return pencil;
}

TEST(FrameQueue, AServerWithFramesOfItsOwnDropsWhatIsOlderThanAFrameByPencil) {
  const auto [frames, errors_s] = pencil_queue();
  const Duration ms30 = duration_from_s(0.03);
  EXPECT_EQ(run_queue(frames, errors_s, {ms30, ms30}), (QueueCounts{8, 1, 1, 2, 4}));
}

TEST(FrameQueue, TakenAsTheyComeFramesAreAsOldAsTheirDelay) {
  const auto [frames, errors_s] = pencil_queue();
  EXPECT_EQ(run_queue(frames, errors_s, {duration_from_s(0.03), {0}}), (QueueCounts{8, 1, 1, 0, 6}));
  EXPECT_EQ(run_queue(frames, errors_s, {duration_from_s(0.02), {0}}), (QueueCounts{8, 1, 1, 2, 4}));
}

// By right clocks nothing comes from the future; a machine's clock that is taken for the server's is off by
// up to a second, and its frames are dropped for it.
TEST(RecordingStudy, AWrongClockMakesTheQueueDropFramesThatCameInTime) {
  const ScratchFolder folder;
  ExecuteRecordingOptions options;
  options.threads = 1;
  const RecordingSummary summary =
      execute_recording(spec_of(R"(, "frames": 900, "runs": 2, "clock_offset_s": 1)"), folder / "out",
                        options)
          .summary;
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

TEST(RecordingStudy, ATinyOneReadsBackAndIsTheSameForAnyNumberOfThreads) {
  const ScratchFolder folder;
  const RecordingSpec spec = spec_of(
      R"(, "frames": 900, "runs": 2, "methods": [{"name": "linear", "method": "linear"},
         {"name": "single", "method": "single"}])");
  for (int threads : {1, 2}) {
    ExecuteRecordingOptions options;
    options.threads = threads;
    execute_recording(spec, folder / std::to_string(threads), options);
  }
  EXPECT_EQ(read_file(folder / "1" / "summary.json"), read_file(folder / "2" / "summary.json"));
  EXPECT_EQ(read_file(folder / "1" / "manifest.json"), read_file(folder / "2" / "manifest.json"));
  const RecordingSummary summary = read_recording_summary(folder / "1");
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
  const auto timings = read_stage_timings(folder / "1");
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

TEST(RecordingStudy, AskedToStopLeavesWhatItHasAside) {
  const ScratchFolder folder;
  ExecuteRecordingOptions options;
  options.stop_requested = [] { return true; };
  EXPECT_TRUE(execute_recording(spec_of(""), folder / "out", options).summary.interrupted);
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  EXPECT_TRUE(read_recording_summary(folder / "out.partial").interrupted);
}

TEST(RecordingVerb, PrintsTablesOrOneJsonDocumentOrThePlan) {
  const ScratchFolder folder;
  const std::string results = folder / "results";
  const std::string study = file_with(
      folder, "study.json",
      R"({"format": "trilat.study", "version": 1, "kind": "recording", "capture_s": 0.5, "name": "clocks", "frames": 300, "runs": 1,
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
  EXPECT_THAT(read_file(folder / "report/report.md"), HasSubstr("arrival jitter"));
  expect_refused(run_trilat(folder, {"run", study, "-o", results, "--cross-check"}), "--cross-check: is for");
  expect_refused(run_trilat(folder, {"run", study, "-o", results, "--campaign", "c"}),
                 "--campaign: is of no use");
}

}  // namespace
}  // namespace trilat
