// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/results/paper_evidence.h"

namespace trilat {

// Every claim and erratum of the paper, judged by one rule from results folders; none when nothing there is
// of its Tables II and III.
std::optional<PaperFindings> judge_paper(const std::vector<std::filesystem::path>& results);

// The claims of a document like datasets/paper/claims.json, whose place is `place`; InputError names the
// place in it of what cannot be read.
std::vector<JudgedClaim> judge_claims(const Json& document, const std::string& place,
                                      const PaperEvidence& evidence);

}  // namespace trilat
