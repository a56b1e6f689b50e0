// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "pipeline/gate/judge_cells.h"

namespace trilat {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

Json document_with(double mae_m, double digits) {
  return {{"study", "sweep"},
          {"cells",
           {{{"method", "a"}, {"mae_m", mae_m}, {"mean_digits", 9.0}},
            {{"method", "b"}, {"mae_m", 0.1}, {"mean_digits", digits}}}}};
}

TEST(GateNumbers, WhatDiffersByMoreThanTheSmallestEffectIsAnAlarm) {
  NumberChanges changes = judge_numbers("sweep", document_with(0.11, 9.0), document_with(0.1, 9.0), {});
  EXPECT_EQ(changes.differing, 1u);
  ASSERT_THAT(changes.findings, SizeIs(1));
  EXPECT_TRUE(changes.findings[0].alarm);
  EXPECT_NEAR(changes.findings[0].change.percent, 10.0, 1e-9);
  EXPECT_EQ(changes.findings[0].what, "/cells/0/mae_m (a)");
  changes = judge_numbers("sweep", document_with(0.09, 8.0), document_with(0.1, 9.0), {});
  ASSERT_THAT(changes.findings, SizeIs(2));  // in either direction, the smaller change last
  EXPECT_TRUE(changes.findings[0].alarm && changes.findings[1].alarm);
  EXPECT_EQ(changes.findings[1].what, "/cells/0/mae_m (a)");
  EXPECT_NEAR(changes.largest_percent, 100.0 / 9.0, 1e-9);
  changes = judge_numbers("sweep", document_with(0.1005, 9.0), document_with(0.1, 9.0), {});
  EXPECT_EQ(changes.differing, 1u);
  EXPECT_NEAR(changes.largest_percent, 0.5, 1e-9);
  EXPECT_THAT(changes.findings, IsEmpty());
}

TEST(GateNumbers, AValueThatIsNotThereAnyMoreOrIsAnotherKindIsAnAlarm) {
  Json now = document_with(0.1, 9.0);
  now["cells"][0]["mae_m"] = nullptr;
  now["cells"][1].erase("mean_digits");
  now["study"] = "other";
  const NumberChanges changes = judge_numbers("sweep", now, document_with(0.1, 9.0), {});
  ASSERT_THAT(changes.findings, SizeIs(3));
  for (const GateFinding& finding : changes.findings) EXPECT_TRUE(finding.alarm) << finding.what;
  EXPECT_EQ(changes.findings[0].note, R"("sweep" before, "other" now)");
  EXPECT_EQ(changes.findings[1].note, "0.1 before, nothing now");
}

}  // namespace
}  // namespace trilat
