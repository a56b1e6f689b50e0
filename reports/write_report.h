// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/paper_evidence.h"
#include "reports/report_content.h"

namespace trilat {

struct ReportOptions {
  std::optional<PaperFindings> paper = {};   // the claims and the errata of the paper; none: neither
  std::optional<ErrorChanges> changes = {};  // between the two results, when there are two of one study
  std::vector<Night> history = {};           // of nights, as `trilat gate` keeps it
  std::string made = {};                     // the page's time stamp; empty: the time of the day, UTC
  // three.js, as Debian's libjs-three has it; where it is not, the page has no replay
  std::filesystem::path three_js = "/usr/share/javascript/three/three.min.js";
  std::function<void(double)> progress = {};  // share of the work that is done
};

// The files of a report.
struct ReportFiles {
  Headline headline;
  std::size_t tables = 0, figures = 0;
  std::vector<std::filesystem::path> written;
};

// Reads results folders and writes into `folder`: report.html (the page), report.md, citation.bib, the
// resolved studies, tables/STUDY/NAME.csv and .tex, and figures/STUDY/NAME.svg, .pdf and .csv. An earlier
// report's files of these names are removed, and its folders studies, tables and figures as a whole. Nothing
// is computed again: the same results give the same bytes on one machine, the page's time stamp apart.
ReportFiles write_report(const std::vector<std::filesystem::path>& results,
                         const std::filesystem::path& folder, const ReportOptions& options = {});

}  // namespace trilat
