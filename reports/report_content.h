// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "datasets/results/paper_evidence.h"
#include "reports/chapter.h"
#include "reports/tables/table.h"

namespace trilat {

// All that a report says, before it is written in any form. The ids of its tables and figures differ.
struct ReportContent {
  std::optional<Table> claims;
  std::vector<Table> audit;  // of the paper; beside its claims
  std::vector<Chapter> chapters;
  std::vector<Table> parameters;  // one for all studies that assume the same
};

// Reads results folders in this order and draws their figures. `paper`: what they say about
// the paper, as far as that was asked. `progress` is told the share that is done.
ReportContent read_report(const std::vector<std::filesystem::path>& results,
                          const std::optional<PaperFindings>& paper = {},
                          const std::function<void(double)>& progress = {});

// Every table, in the order of the report.
std::vector<Table> tables_of(const ReportContent& content);
// Those that answer what was asked.
std::vector<Table> main_tables_of(const ReportContent& content);
std::vector<Figure> figures_of(const ReportContent& content);

}  // namespace trilat
