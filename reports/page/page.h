// SPDX-License-Identifier: MIT
#pragma once

#include <set>
#include <string>
#include <vector>

#include "reports/report_content.h"

namespace trilat {

// A part of the page with a line in its table of contents.
struct PageSection {
  std::string id, name;
  std::string html;  // without the heading; empty: the section is left out
};

// What was run on what, a line a results folder.
PageSection runs_section(const ReportContent& content);
// The paper's claims with verdicts.
PageSection claims_section(const ReportContent& content);
// What the paper prints that cannot be so: its own numbers recomputed, and every erratum with its effect.
PageSection audit_section(const ReportContent& content);
// Tables I to IV and the calibration, ours beside the paper's, with the claims that rest on them. Tells which
// tables it shows, by id.
PageSection paper_section(const ReportContent& content, std::set<std::string>& shown);
// One a results folder: what it says, its tables but those already shown, its figures.
std::vector<PageSection> chapter_sections(const ReportContent& content, const std::set<std::string>& shown);
// What the simulations assume.
PageSection parameters_section(const ReportContent& content);
// Resolved configurations, hashes, versions, seeds, machines, and the commands that make it all again.
PageSection provenance_section(const ReportContent& content);

// Boxes that hide and show the rows of methods in the tables of the section that it stands in; page.js fills
// it.
std::string method_panel();

// What every number of the report comes from: "simulated", "recorded", or both.
std::string origin_of(const ReportContent& content);

struct PageOptions {
  std::string made;      // when, as the page says it
  std::string citation;  // BibTeX
  std::string three_js;  // the library that draws the replay; empty: there is none
};

// report.html: one document that needs no other file and no network. Equal content and options give equal
// bytes.
std::string page_of(const ReportContent& content, const PageOptions& options);

}  // namespace trilat
