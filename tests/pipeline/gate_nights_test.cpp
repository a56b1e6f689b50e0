// SPDX-License-Identifier: MIT
// Whether the gate cries wolf, and whether it sees the wolf: over 400 simulated nights, each as long as in
// the paper, 35 s, or over few short ones.
#include <algorithm>
#include <cstdio>

#include <gmock/gmock.h>

#include "pipeline/gate/compare_results.h"
#include "tests/pipeline/simulated_nights.h"
#include "tests/support/trials.h"

namespace trilat {
namespace {

std::vector<GateFinding> judged(const SimulatedNights& nights, std::uint64_t number,
                                const NightModel& model) {
  const SimulatedNights::Night night = nights.night(number, model);
  GateReport report;
  if (model.same_recordings)
    compare_takes("simulated", night.before, night.now, night.takes, {}, report);
  else
    compare_unpaired("simulated", night.before, night.now, {}, report);
  adjust_p_values({}, report);
  return report.findings;
}

// How many nights have an alarm; `method`: about that one, or any when empty.
std::uint64_t nights_with_alarm(std::uint64_t seed, std::uint64_t nights, NightModel model,
                                const std::string& method = "") {
  model.duration_s = runs_all_trials() ? 35.0 : 10.0;
  const SimulatedNights simulated(seed);
  std::uint64_t alarms = 0;
  for (std::uint64_t n = 0; n < nights; ++n) {
    const auto findings = judged(simulated, n, model);
    alarms += std::ranges::any_of(
        findings, [&](const GateFinding& f) { return f.alarm && (method.empty() || f.method == method); });
  }
  return alarms;
}

void say(const char* what, std::uint64_t alarms, std::uint64_t nights) {
  std::printf("%s: an alarm in %llu of %llu simulated nights\n", what,
              static_cast<unsigned long long>(alarms), static_cast<unsigned long long>(nights));
}

TEST(Nights, SameRecordingsWithoutAnyChangeGiveNoAlarm) {
  const std::uint64_t nights = trials(400), alarms = nights_with_alarm(1, nights, {});
  say("16 persons, same recordings, nothing changed", alarms, nights);
  EXPECT_EQ(alarms, 0u);
}

TEST(Nights, SameRecordingsAndAMethodThreePercentWorseGiveOneAlways) {
  for (const std::size_t participants : {1, 4, 16}) {
    const std::uint64_t nights = trials(400);
    const std::uint64_t alarms =
        nights_with_alarm(1, nights, {.participants = participants, .worse = 0.03}, "nonlinear");
    say("same recordings, a method 3 % worse", alarms, nights);
    EXPECT_EQ(alarms, nights);
  }
}

TEST(Nights, OtherRecordingsOfTheSamePersonsGiveAnAlarmInOneOfAHundredAtMost) {
  const std::uint64_t nights = trials(400);
  for (const std::size_t participants : {8, 16}) {
    const std::uint64_t alarms =
        nights_with_alarm(1, nights, {.participants = participants, .same_recordings = false});
    say("other recordings, nothing changed", alarms, nights);
    EXPECT_LE(alarms, nights / 100);
  }
}

TEST(Nights, OtherRecordingsAndAMethodFifteenPercentWorseGiveOneInNinetyFiveOfAHundred) {
  const std::uint64_t nights = trials(400);
  const std::uint64_t alarms =
      nights_with_alarm(2, nights, {.same_recordings = false, .worse = 0.15}, "nonlinear");
  say("16 persons, other recordings, a method 15 % worse", alarms, nights);
  EXPECT_GE(100 * alarms, 95 * nights);
}

}  // namespace
}  // namespace trilat
