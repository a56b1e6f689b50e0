// SPDX-License-Identifier: MIT
#include "datasets/results/paper_evidence.h"

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/results/results_file.h"
#include "datasets/results/table.h"

namespace trilat {

ResultsHead read_results_head(const std::filesystem::path& folder) {
  return read_as<ResultsHead>(read_results_json(folder), {folder / "summary.json"});
}

PaperEvidence read_paper_evidence(const std::vector<std::filesystem::path>& results) {
  PaperEvidence evidence;
  std::map<std::string, std::filesystem::path> known;
  for (const std::filesystem::path& folder : results) {
    const ResultsHead head = read_results_head(folder);
    if (head.paper == name_of(PaperStudy::none)) continue;
    const bool may_be_several = head.paper == name_of(PaperStudy::sensors);  // each with rigs of its own
    const auto [found, is_new] =
        known.emplace(may_be_several ? head.paper + ": " + head.study : head.paper, folder);
    if (!is_new)
      throw InputError(
          folder.string(),
          fmt::format("repeats the paper's \"{}\", as {} does; the paper's claims are judged by one of them",
                      head.paper, found->second.string()));
    evidence.any_simulated |= head.simulated;
    evidence.is_of_the_paper |=
        head.paper == name_of(PaperStudy::table3) || head.paper == name_of(PaperStudy::table2);
    if (const auto stored = read_json_file<StoredTables>(folder))
      evidence.errata.insert(stored->errata.begin(), stored->errata.end());
  }
  return evidence;
}

}  // namespace trilat
