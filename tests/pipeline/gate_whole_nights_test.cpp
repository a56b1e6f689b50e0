// SPDX-License-Identifier: MIT
// The whole gate over simulated nights of one baseline after another: cells, speed and the drifts of a
// history that grows. TRILAT_NIGHTS says how many, and makes them 35 s long as in the paper, not 10.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include <gmock/gmock.h>

#include "evaluators/metrics/ratio_change.h"
#include "pipeline/gate/judge_cells.h"
#include "pipeline/gate/judge_history.h"
#include "pipeline/gate/judge_speed.h"
#include "tests/pipeline/simulated_nights.h"
#include "tests/pipeline/simulated_speed.h"

namespace trilat {
namespace {

constexpr std::uint64_t kNightsOfABaseline = 50;

void add_cells(const PairedStudy& study, HistoryEntry& entry) {
  for (std::size_t m = 0; m < study.methods.size(); ++m)
    for (std::size_t g = 0; g < study.groups.size(); ++g) {
      const std::size_t cell = study.axes.cell(0, 0, g, m);
      double sum_m = 0.0, both = 0.0;
      PairedCounts counts;
      for (const PairedTake& take : study.takes) {
        const auto column = [&](std::size_t c) {
          return take.sums.col(static_cast<Eigen::Index>(cell * PairedColumns::count + c)).sum();
        };
        sum_m += column(PairedColumns::before) + column(PairedColumns::difference);
        both += column(PairedColumns::both);
        counts.merge(take.cells[cell]);
      }
      const std::string key = series_of(study.study, study.methods[m], "walking", study.groups[g]);
      entry.error_m[key] = sum_m / both;
      entry.coverage[key] = static_cast<double>(counts.answered_now()) / static_cast<double>(counts.asked);
    }
}

struct Alarms {
  std::uint64_t cells = 0, speed = 0, drift = 0, nights = 0;
};

// The nights of one baseline; which part of the gate raises an alarm.
class BaselineNights {
 public:
  BaselineNights(std::uint64_t number, const NightModel& model)
      : number_(number), model_(model), baseline_speed_(measured_speed_baseline(number)) {}

  void judge(std::uint64_t night, Alarms& alarms) {
    const PairedStudy study = simulated_.night(number_, model_, night);
    std::vector<std::string> same;
    if (model_.same_inputs) same.push_back(study.study);
    std::vector<GateFinding> findings =
        judge_cells(compared_cells(study, {300, model_.same_inputs}), {}, same);
    const bool cells = any_alarm(findings);
    const SpeedFile tonight = measured_speed_night(speed_number(night));
    int rerun = 0;
    const auto of_speed =
        judge_speed(tonight, baseline_speed_, {}, [&] {
          return measured_speed_night(speed_number(night) + static_cast<std::uint64_t>(++rerun));
        }).findings;
    const bool speed = any_alarm(of_speed);
    findings.insert(findings.end(), of_speed.begin(), of_speed.end());
    HistoryEntry entry;
    entry.time = std::to_string(night);
    add_cells(study, entry);
    for (const SolverSpeed& s : tonight.solvers) entry.speed[s.solver] = quantile_of(s.ratios, 0.25);
    const bool drift = any_alarm(judge_history(history_, entry, {}, findings).drifts);
    history_.entries.push_back(entry);
    alarms.cells += cells;
    alarms.speed += speed;
    alarms.drift += drift;
    alarms.nights += cells || speed || drift;
  }

 private:
  static bool any_alarm(const std::vector<GateFinding>& findings) {
    return std::any_of(findings.begin(), findings.end(), [](const GateFinding& f) { return f.alarm; });
  }
  std::uint64_t speed_number(std::uint64_t night) const { return (number_ * 1000 + night) * 4 + 1'000'000; }

  std::uint64_t number_;
  NightModel model_;
  SimulatedNights simulated_{3};
  SpeedFile baseline_speed_;
  History history_;
};

struct Kind {
  const char* name;
  NightModel model;
};
void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }

class WholeGate : public testing::TestWithParam<Kind> {};

TEST_P(WholeGate, NullNightsAlarmInOneOfAHundredAtMost) {
  const char* more = std::getenv("TRILAT_NIGHTS");
  const std::uint64_t nights = more ? std::max<std::uint64_t>(20, std::strtoull(more, nullptr, 10)) : 20;
  NightModel model = GetParam().model;
  model.duration_s = more ? 35.0 : 10.0;
  Alarms alarms;
  for (std::uint64_t first = 0; first < nights; first += kNightsOfABaseline) {
    BaselineNights baseline(first / kNightsOfABaseline, model);
    for (std::uint64_t n = 0; n < std::min(kNightsOfABaseline, nights - first); ++n)
      baseline.judge(n, alarms);
  }
  std::printf("%s: %llu of %llu simulated nights alarm (cells %llu, speed %llu, drift %llu)\n",
              GetParam().name, static_cast<unsigned long long>(alarms.nights),
              static_cast<unsigned long long>(nights), static_cast<unsigned long long>(alarms.cells),
              static_cast<unsigned long long>(alarms.speed), static_cast<unsigned long long>(alarms.drift));
  EXPECT_LE(alarms.nights, nights / 100);
}

INSTANTIATE_TEST_SUITE_P(Kinds, WholeGate,
                         testing::Values(Kind{"16 persons, same recordings", {16, 35.0, 0.1, true, 0.0}},
                                         Kind{"4 persons, other recordings", {4, 35.0, 1.0, false, 0.0}}));

}  // namespace
}  // namespace trilat
