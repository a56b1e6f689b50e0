// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/paper_evidence.h"
#include "reports/table.h"

namespace trilat {

// Each claim of the paper, ours with its interval, and the verdict. Those from simulated sensors say so.
Table claims_table(const PaperFindings& findings);

// "6.4 % (5.9 to 6.9)" of each number, after what it is; completed by fallbacks, or not. A dash without any.
std::string parts_text(const std::vector<ClaimPart>& parts, bool complete);

}  // namespace trilat
