// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "pipeline/gate/gate_report.h"

namespace trilat {
namespace {

using testing::HasSubstr;

TEST(GateSummary, SaysSizesInTheirUnitTheWorstFirstAndNoMoreThanFourPlaces) {
  GateReport report;
  report.results = "now";
  report.baseline = "base";
  const auto add = [&](const char* group, double before, double now, const char* unit) -> GateFinding& {
    GateFinding f =
        finding_of({"table3", "linear", "walking", group}, FindingKind::accuracy, Direction::worse, true);
    f.before = before;
    f.now = now;
    f.unit = unit;
    f.percent = percent_of(now, before);
    report.findings.push_back(f);
    return report.findings.back();
  };
  add("head", 0.04, 0.042, "m");
  GateFinding& certain = add("knee", 0.02, 0.03, "rad");
  certain.low = 20.0;
  certain.high = 80.0;
  certain.p_value = 1e-8;
  add("wrist", kNaN, 0.0442, "m");
  add("ankle", 0.5, 0.6, "1").p_value = 0.0123;
  add("hip", 2.0, 2.02, "s");
  sort_findings(report.findings);
  const std::string said = gate_summary(report);
  EXPECT_THAT(said, HasSubstr("REGRESSION: table3, linear, walking, wrist: larger errors, nothing -> 4.42 "
                              "cm; and 4 more (base)\n"));
  EXPECT_THAT(
      said,
      HasSubstr(
          "table3, linear: larger errors\n  walking, wrist: nothing -> 4.42 cm\n"
          "  walking, knee: +50.0 % (+20.0 to +80.0), 1.15 degrees -> 1.72 degrees, p below 1e-6\n"
          "  walking, ankle: +20.0 %, 0.5 -> 0.6, p = 0.01\n  walking, head: +5.0 %, 4.00 cm -> 4.20 cm\n"
          "  and 1 places more: --json\n"));
  EXPECT_THAT(said, HasSubstr("trilat gate now --baseline base --accept"));
  report.findings[0].alarm = false;
  sort_findings(report.findings);
  EXPECT_THAT(
      gate_summary(report),
      HasSubstr(
          "Better, or to be known; no alarm:\n\ntable3, linear: larger errors\n  walking, wrist: nothing"));
}

}  // namespace
}  // namespace trilat
