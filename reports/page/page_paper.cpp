// SPDX-License-Identifier: MIT
// What the paper says, and ours beside it.
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "reports/page/html.h"
#include "reports/page/page.h"
#include "reports/render/render.h"

namespace trilat {
namespace {

// Tables that hold the paper's numbers beside ours, and the part of the paper where claims on them stand.
struct PaperTable {
  const char* id;
  const char* name;
  const char* where;
};
constexpr std::array<PaperTable, 7> kPaperTables{{{"table1", "Table I", "Table I"},
                                                  {"calibration_wand", "Calibration", "Calibration"},
                                                  {"table2", "Table II", "Table II"},
                                                  {"table3", "Table III", "Table III"},
                                                  {"table4_clocks", "Table IV, clocks", "Table IV"},
                                                  {"table4_queue", "Table IV, real time", "Table IV"},
                                                  {"table4_processing", "Table IV, processing", "Table IV"}}};

std::size_t column_of(const Table& table, const std::string& key) {
  const auto found = std::find_if(table.columns.begin(), table.columns.end(),
                                  [&](const TableColumn& column) { return column.key == key; });
  return static_cast<std::size_t>(found - table.columns.begin());
}

// Whether "abstract, Table III" names a place.
bool names(const std::string& places, const std::string& place) {
  const std::string all = ", " + places + ",";
  return all.find(", " + place + ",") != std::string::npos;
}

std::string claims_on(const std::optional<Table>& claims, const std::string& place) {
  std::string html;
  if (!claims) return html;
  const std::size_t where = column_of(*claims, "where"), verdict = column_of(*claims, "verdict");
  for (const auto& row : claims->rows)
    if (names(row[where].text, place))
      html += fmt::format("<li>{} {}</li>\n", html_text(row.front().text), verdict_badge(row[verdict].text));
  return html.empty() ? html : "<ul class=\"notes\">\n" + html + "</ul>\n";
}

}  // namespace

PageSection claims_section(const ReportContent& content) {
  PageSection section{"claims", "The paper’s claims", {}};
  if (!content.claims) return section;
  const Table& claims = *content.claims;
  const std::size_t verdict = column_of(claims, "verdict");
  std::vector<std::pair<std::string, int>> tally;
  for (const char* word :
       {"holds", "does not hold", "undecided", "contradicts itself", "cannot be tested here"})
    if (const auto n = std::count_if(claims.rows.begin(), claims.rows.end(),
                                     [&](const auto& row) { return row[verdict].text.starts_with(word); }))
      section.html += fmt::format("<li>{} {}</li>\n", n, verdict_badge(word));
  section.html = "<ul class=\"tally\">\n" + section.html + "</ul>\n" + html_of(claims, {});
  return section;
}

PageSection audit_section(const ReportContent& content) {
  PageSection section{"audit-of-the-paper", "The audit of the paper", {}};
  for (const Table& table : content.audit) section.html += html_of(table, {});
  return section;
}

PageSection paper_section(const ReportContent& content, std::set<std::string>& shown) {
  PageSection section{"paper", "The paper’s tables beside ours", {}};
  for (const auto& [id, name, where] : kPaperTables)
    for (const Chapter& chapter : content.chapters)
      for (const Table& table : chapter.tables) {
        if (table.id != id) continue;
        section.html += fmt::format("<h3>{}</h3>\n{}{}", name, claims_on(content.claims, where),
                                    html_of(table, commands_of(chapter.provenance)));
        shown.insert(table.id);
      }
  if (section.html.find("data-key=\"method\"") != std::string::npos)
    section.html = method_panel() + section.html;
  return section;
}

}  // namespace trilat
