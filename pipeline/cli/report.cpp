// SPDX-License-Identifier: MIT
// `trilat report`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "reports/write_report.h"

namespace trilat {

int report(const ReportArguments& arguments) {
  ReportFiles files;
  {
    Progress progress("writing the report");
    files = write_report(arguments.results, arguments.output,
                         {.made = arguments.time, .progress = [&](double share) { progress.set(share); }});
  }
  if (arguments.json) {
    Json list = Json::array();
    for (const auto& path : files.written) list.push_back(path.string());
    fmt::print(
        "{}\n",
        json_text({{"tables", files.tables.size()}, {"figures", files.figures.size()}, {"files", list}}, 2));
  } else {
    fmt::print("{} tables, {} figures: {}\n", files.tables.size(), files.figures.size(),
               (arguments.output / "report.html").string());
  }
  return kDone;
}

}  // namespace trilat
