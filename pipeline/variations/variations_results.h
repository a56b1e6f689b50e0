// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/figure.h"
#include "datasets/results/table.h"
#include "pipeline/variations/variations_summary.h"

namespace trilat {

// Fills in what the points of a summary say of its comparisons, of the best method, and in sentences. Points
// of ranges are independent of each other: shares are Clopper and Pearson's, means have Student's t between
// points. Points that failed are left out.
void analyse(VariationsSummary& summary);

// Tables and figures of a study of patches, or of ranges.
StoredTables variation_tables(const VariationsSummary& summary);
std::vector<Figure> variation_figures(const VariationsSummary& summary);

}  // namespace trilat
