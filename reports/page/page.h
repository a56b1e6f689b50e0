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
// The section that links the simulations' parameters.
PageSection assumptions_section(const ReportContent& content);
// Resolved configurations, hashes, versions, seeds, machines, and the commands that make it all again.
PageSection provenance_section(const ReportContent& content);

// A picture with its caption.
std::string figure_html(const DrawnFigure& figure);

struct PageOptions {
  std::string made;      // when, as the page says it
  std::string citation;  // BibTeX
  std::string three_js;  // the library that draws the replay; empty: there is none
};

// report.html: one document that needs no network, and no other file but the CSVs and pictures that it links.
// Equal content and options give equal bytes.
std::string page_of(const ReportContent& content, const PageOptions& options);

}  // namespace trilat
