// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "reports/render/render.h"
#include "reports/tables.h"
#include "tests/reports/summaries.h"

namespace trilat {
namespace {

TEST(Errata, AllAreListedAndWithoutAStudyNoEffectIsClaimed) {
  const Table table = errata_table({});
  ASSERT_EQ(table.rows.size(), 21u);
  for (std::size_t k = 0; k < table.rows.size(); ++k)
    EXPECT_EQ(table.rows[k][0].text, "E" + std::to_string(k + 1));
  EXPECT_EQ(table.rows[6][5].text, "its study is not among these results");
  EXPECT_EQ(table.rows[8][5].text, "none on a result");
}

TEST(Errata, TheEffectIsPrintedBesideCorrected) {
  PaperFindings findings;
  findings.errata["E8"] = {{.claim = "E8",
                            .what = "printed stop against nonlinear",
                            .unit = "%",
                            .value = 33.3,
                            .low = 30.0,
                            .high = 36.0,
                            .compared = 0.8}};
  EXPECT_EQ(errata_table(findings).rows[7][5].text,
            "printed stop against nonlinear: 33.3 % (30.0 to 36.0), where both answer (80 % of the samples)");
}

}  // namespace
}  // namespace trilat
