// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "datasets/results/claims.h"
#include "datasets/results/results_file.h"

namespace trilat {

// Keys of every summary.json, whatever its kind.
struct ResultsHead {
  static constexpr bool kHasMore = true;
  StudyKind kind = StudyKind::accuracy;
  std::string study;
  std::string campaign;  // empty where the study has none
  std::string paper = name_of(PaperStudy::none);
  bool simulated = true;

  static void fields(auto& self, auto&& f) {
    visit_results_head(f, self.kind);
    f("study", self.study);
    f("campaign", self.campaign, kMayLack);
    f("paper", self.paper, kMayLack);
    f("simulated", self.simulated, kMayLack);
  }
};
// InputError with the place when `folder` holds no results of this version.
ResultsHead read_results_head(const std::filesystem::path& folder);

// Evidence of results about the paper, as their studies stored it.
struct PaperEvidence {
  bool is_of_the_paper = false;               // whether there is anything of Tables II or III
  bool any_simulated = false;                 // whether anything here comes from simulated sensors
  std::map<std::string, std::string> errata;  // what an erratum does besides, by its id
};

// Collects the evidence of results folders of any kind. InputError with the place when one holds no results
// of this version, or two are of one study: it would depend on their order which of them counts.
PaperEvidence read_paper_evidence(const std::vector<std::filesystem::path>& results);

struct PaperFindings {
  PaperEvidence evidence;
  std::vector<JudgedClaim> claims;
  std::map<std::string, std::vector<ClaimNumber>> errata;  // what an erratum does to errors, by its id
};

}  // namespace trilat
