// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "reports/report_content.h"

namespace trilat {

// A part of a page with a line in its table of contents.
struct PageSection {
  std::string id, name;
  std::string html;  // without the heading; empty: the section is left out
};

// The paper's claims with verdicts, and what it prints that cannot be so.
PageSection claims_section(const ReportContent& content);
PageSection errata_section(const ReportContent& content);
// One a results folder: what it says, its shown tables with the claims that rest on them, its first figures.
std::vector<PageSection> chapter_sections(const ReportContent& content);
// The tables and figures that the page does not show, one section a results folder, and what the simulations
// assume.
std::vector<PageSection> other_sections(const ReportContent& content);
// Resolved configurations, hashes, versions, seeds, machines, and the commands that make it all again.
PageSection provenance_section(const ReportContent& content);

// A picture with its caption, in the page itself, or (`linked`) as the file beside it.
std::string figure_html(const DrawnFigure& figure, bool linked = false);

struct PageOptions {
  std::string made;      // when, as the page says it
  std::string citation;  // BibTeX
  std::string three_js;  // the library that draws the replay; empty: there is none
};

// report.html: one document that needs no other file and no network. Equal content and options give equal
// bytes.
std::string page_of(const ReportContent& content, const PageOptions& options);
// all-tables.html, which lies beside it: what the page does not show.
std::string all_tables_of(const ReportContent& content, const PageOptions& options);

}  // namespace trilat
