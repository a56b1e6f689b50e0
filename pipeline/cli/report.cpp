// SPDX-License-Identifier: MIT
// `trilat report`.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/json.h"
#include "datasets/base/words.h"
#include "pipeline/claims/judge_claims.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/errors/error_changes.h"
#include "pipeline/gate/found_results.h"
#include "reports/render/render.h"
#include "reports/tables.h"
#include "reports/write_report.h"

namespace trilat {
namespace {

struct ReportArguments {
  std::vector<std::filesystem::path> results;
  std::filesystem::path output;
  bool paper = false;             // with the paper's claims and errata
  std::filesystem::path history;  // of nights, as the gate keeps it; empty: none
  std::string time;               // the page's time stamp; empty: now
  bool force = false;             // may replace what others wrote
  bool json = false;
};

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

OutputMark report_mark(const std::vector<std::filesystem::path>& results) {
  OutputMark mark{"report", {}};
  for (const std::filesystem::path& folder : results)
    if (const auto manifest = folder / "manifest.json";  // small; the summary says whether they are finished
        std::filesystem::exists(manifest) && std::filesystem::exists(folder / "summary.json"))
      mark.names.push_back(read_json(manifest).value("/study/name"_json_pointer, ""));
    else
      mark.names.push_back(read_results_json(folder).value("study", ""));
  return mark;
}

PaperFindings judged_paper(const std::vector<std::filesystem::path>& results) {
  if (std::optional<PaperFindings> findings = judge_paper(results)) return std::move(*findings);
  throw InputError("--paper",
                   "needs results of a study with \"paper\": \"table3\" or \"table2\": the paper's claims "
                   "are judged by these");
}

int report(const ReportArguments& arguments) {
  if (arguments.results.empty()) throw InputError("trilat report", "needs results folders");
  if (arguments.output.empty()) throw InputError("trilat report", "needs a folder for the report: -o DIR");
  const std::vector<std::filesystem::path> results = results_of(arguments.results);
  const OutputMark mark = report_mark(results);
  check_output_folder({arguments.output, results, arguments.force}, mark);
  ReportFiles files;
  {
    Progress progress("writing the report");
    mark_output(arguments.output, mark);
    files = write_report(
        results, arguments.output,
        {.paper = arguments.paper ? std::optional(judged_paper(results)) : std::nullopt,
         .changes = arguments.paper ? std::nullopt : changes_between(results),
         .history = arguments.history.empty() ? std::vector<Night>{} : read_history(arguments.history),
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
    fmt::print("{}\n{}, {}: {}\n", headline_text(files.headline), counted(files.tables, "table"),
               counted(files.figures, "figure"), (arguments.output / "report.html").string());
  }
  return kDone;
}

}  // namespace

void add_report(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<ReportArguments>(
      app, code, "report", "results to a page, Markdown, CSV and LaTeX; nothing is computed again", report,
      OnInterrupt::at_once);
  verb.add_option("results", a.results, "results folders, or a folder of them");
  verb.add_option("-o,--output", a.output, "folder of the report");
  verb.add_option("--time", a.time, "the time stamp of the page, any text; without it the time of the day");
  verb.add_option(
      "--history", a.history,
      "history of nights that `trilat gate` keeps: the last verdict and the errors by night lead");
  verb.add_flag("--paper", a.paper,
                "judge the paper's claims by these results, and list its errata, on the page");
  removed_option(verb, "--audit", "--paper judges what the paper's own tables imply, too");
  add_force(verb, a.force);
  add_json(verb, a.json);
}

}  // namespace trilat
