// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/paper_evidence.h"
#include "reports/table.h"

namespace trilat {

// What the paper's own printed numbers imply, recomputed from them alone (errata E12 to E15), and which of
// them agree with each other.
Table audit_table();

// Every erratum: what is printed, why it cannot be so, what stands in its place, and what the difference does
// in these results, as far as a study of it was run.
Table errata_table(const PaperFindings& findings);

}  // namespace trilat
