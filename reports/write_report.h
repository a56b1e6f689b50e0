// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "reports/figure.h"
#include "reports/table.h"

namespace trilat {

// What a report is made of.
struct ReportFiles {
  std::vector<Table> tables;
  std::vector<Figure> figures;
  std::vector<std::filesystem::path> written;
};

// Reads results folders and writes report.md, report.tex (compiles as it is, without figures), per table
// ID.csv and ID.tex, and per figure ID.svg, ID.pdf and ID.csv into `folder`. Nothing is computed again: the
// same results give the same bytes on one machine.
ReportFiles write_report(const std::vector<std::filesystem::path>& results,
                         const std::filesystem::path& folder);

}  // namespace trilat
