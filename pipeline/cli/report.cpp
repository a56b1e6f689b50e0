// SPDX-License-Identifier: MIT
// `trilat report`.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/strict_json.h"
#include "pipeline/accuracy/statistics/error_changes.h"
#include "pipeline/claims/judge_claims.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/gate/found_results.h"
#include "reports/claims/claims.h"
#include "reports/render/render.h"
#include "reports/write_report.h"

namespace trilat {

namespace {

Json json_of(const Table& table) {
  Json rows = Json::array();
  for (const auto& row : table.rows) {
    Json object = Json::object();
    for (std::size_t c = 0; c < row.size(); ++c) {
      if (row[c].number)
        object[table.columns[c].key] = *row[c].number;
      else
        object[table.columns[c].key] = row[c].text;
    }
    rows.push_back(std::move(object));
  }
  return rows;
}

int print_audit(bool json) {
  const Table table = audit_table();
  fmt::print("{}\n",
             json ? json_text({{"title", table.title}, {"rows", json_of(table)}}, 2) : markdown_of(table));
  return kDone;
}

bool holds_results_folders(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder) || std::filesystem::exists(folder / "summary.json"))
    return false;
  return std::ranges::any_of(std::filesystem::directory_iterator(folder), [](const auto& inside) {
    return std::filesystem::exists(inside.path() / "summary.json");
  });
}

// Results folders, and those directly inside a folder that is none itself, by kind: accuracy first.
std::vector<std::filesystem::path> results_of(const std::vector<std::filesystem::path>& given) {
  std::vector<std::filesystem::path> results;
  for (const std::filesystem::path& folder : given)
    if (!holds_results_folders(folder))
      results.push_back(folder);
    else {
      std::vector<FoundResults> found = find_results(folder).results;
      std::ranges::stable_sort(found, {}, &FoundResults::kind);
      for (const FoundResults& one : found) results.push_back(one.folder);
    }
  return results;
}

}  // namespace

int report(const ReportArguments& arguments) {
  if (arguments.audit && arguments.results.empty()) return print_audit(arguments.json);
  if (arguments.results.empty())
    throw InputError("trilat report",
                     "needs results folders, or --audit for what the paper's own numbers imply");
  if (arguments.output.empty()) throw InputError("trilat report", "needs a folder for the report: -o DIR");
  const std::vector<std::filesystem::path> results = results_of(arguments.results);
  check_output({arguments.output, OutputKind::report, results, arguments.force});
  ReportFiles files;
  {
    Progress progress("writing the report");
    files = write_report(results, arguments.output,
                         {.paper = arguments.paper ? judge_paper(results) : std::nullopt,
                          .changes = arguments.paper ? std::nullopt : changes_between(results),
                          .history = arguments.history.empty() ? History{} : read_history(arguments.history),
                          .made = arguments.time,
                          .progress = [&](double share) { progress.set(share); }});
  }
  if (arguments.json) {
    Json list = Json::array();
    for (const auto& path : files.written) list.push_back(path.string());
    fmt::print("{}\n", json_text({{"tables", files.tables},
                                  {"figures", files.figures},
                                  {"answers", files.headline.answers},
                                  {"warnings", files.headline.warnings},
                                  {"files", list}},
                                 2));
  } else {
    fmt::print("{}\n{} tables, {} figures: {}\n", headline_text(files.headline), files.tables, files.figures,
               (arguments.output / "report.html").string());
  }
  return kDone;
}

}  // namespace trilat
