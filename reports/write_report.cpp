// SPDX-License-Identifier: MIT
#include "reports/write_report.h"

#include <set>

#include <fmt/format.h>

#include "datasets/base/files.h"
#include "datasets/results/summary.h"
#include "reports/accuracy_tables.h"
#include "reports/render.h"

namespace trilat {
namespace {

std::string heading_of(const ResultsSummary& s) {
  std::string text = fmt::format("## {} on {}\n\n{} of {} takes, {} participants, {}.\n", s.study, s.campaign,
                                 s.takes - s.takes_failed, s.takes, s.participants,
                                 s.simulated ? "**simulated** sensors" : "recorded sensors");
  if (s.cross_check)
    text += fmt::format(
        "\nCross-check of `{}` with Ceres: {} samples, worst difference {:.3g} m (limit {:g} m): {}.\n",
        s.cross_check->method, s.cross_check->samples, s.cross_check->worst_m, s.cross_check->limit_m,
        s.cross_check->passed() ? "agrees" : "**disagrees**");
  return text;
}

// Ids become file names, so two results of one kind must not share them.
void make_unique(Table& table, std::set<std::string>& ids, const std::string& study) {
  if (!ids.insert(table.id).second) {
    const std::string base = usable_id(study + "-" + table.id);
    table.id = base;
    for (int n = 2; !ids.insert(table.id).second; ++n) table.id = fmt::format("{}-{}", base, n);
  }
}

}  // namespace

ReportFiles write_report(const std::vector<std::filesystem::path>& results,
                         const std::filesystem::path& folder) {
  ReportFiles report;
  std::set<std::string> ids;
  std::string markdown = "# Trilateration accuracy\n";
  for (const auto& path : results) {
    const ResultsSummary summary = read_summary(path);
    markdown += "\n" + heading_of(summary);
    std::vector<Table> tables = table3(summary);
    for (Table& table : accuracy_tables(summary)) tables.push_back(std::move(table));
    for (Table& table : tables) {
      make_unique(table, ids, summary.study);
      markdown += "\n" + markdown_of(table);
      report.tables.push_back(std::move(table));
    }
  }
  make_folder(folder);
  const auto write = [&](const std::string& name, const std::string& text) {
    write_file(folder / name, text);
    report.written.push_back(folder / name);
  };
  write("report.md", markdown);
  write("report.tex", latex_document(report.tables));
  for (const Table& table : report.tables) {
    write(table.id + ".csv", csv_of(table));
    write(table.id + ".tex", latex_of(table));
  }
  return report;
}

}  // namespace trilat
