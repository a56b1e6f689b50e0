// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/paper_evidence.h"
#include "reports/figures/figure.h"
#include "reports/tables/table.h"

namespace trilat {

struct ReportOptions {
  std::optional<PaperFindings> paper = {};  // the claims and the audit of the paper; none: neither
  std::string made = {};                    // the page's time stamp; empty: the time of the day, UTC
  // three.js, as Debian's libjs-three has it; where it is not, the page has no replay
  std::filesystem::path three_js = "/usr/share/javascript/three/three.min.js";
  std::function<void(double)> progress = {};  // share of the work that is done
};

// What a report is made of.
struct ReportFiles {
  std::vector<Table> tables;
  std::vector<Figure> figures;
  std::vector<std::filesystem::path> written;
};

// Reads results folders and writes into `folder`: report.html (the page, needs nothing else), report.md,
// numbers.tex (a macro for every number of the main tables), citation.bib, the resolved studies, per table
// ID.csv and ID.tex, by-take, by-participant and by-joint of a study as CSV, and per figure ID.svg, ID.pdf
// and ID.csv. Nothing is computed again: the same results give the same bytes on one machine, the page's time
// stamp apart.
ReportFiles write_report(const std::vector<std::filesystem::path>& results,
                         const std::filesystem::path& folder, const ReportOptions& options = {});

}  // namespace trilat
