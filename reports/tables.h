// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/figure.h"
#include "datasets/results/paper_evidence.h"
#include "datasets/results/summary.h"
#include "datasets/results/table.h"

namespace trilat {

// Two results of one study: what changed, the real changes first; and the sentences that lead.
Table changes_table(const ErrorChanges& changes);
std::vector<std::string> changes_sentences(const ErrorChanges& changes);

// Measurements of real sensors, beside simulated numbers: recorded.json, which scripts/measure_tracker
// writes.
Table recorded_table();

// Each claim of the paper, ours with its interval, and the verdict. Those from simulated sensors say so.
Table claims_table(const PaperFindings& findings);

// "6.4 % (5.9 to 6.9)" of each number, after what it is. A dash without any.
std::string numbers_text(const std::vector<ClaimNumber>& numbers);

// Every erratum: what is printed, why it cannot be so, what replaces it, and the effect of the difference in
// these results, where a study of it was run.
Table errata_table(const PaperFindings& findings);

// Adds what the paper prints to a table and a figure that say that its numbers belong beside: of Table III by
// group, which is a column's key or a panel, and method.
void add_printed(Table& table, bool simulated);
void add_printed(Figure& figure);

}  // namespace trilat
