// SPDX-License-Identifier: MIT
#include "pipeline/recording/recording_study.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/declared_parameters.h"
#include "datasets/results/timings.h"
#include "pipeline/recording/clock_methods.h"
#include "pipeline/recording/recording_summary.h"
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

}  // namespace
}  // namespace trilat
