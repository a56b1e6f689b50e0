// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "reports/report_content.h"

namespace trilat {

struct PageOptions {
  std::string made;      // when, as the page says it
  std::string citation;  // BibTeX
  std::string three_js;  // the library that draws the replay; empty: there is none
};

// report.html: one document that needs no other file and no network. Equal content and options give equal
// bytes.
std::string page_of(const ReportContent& content, const PageOptions& options);

}  // namespace trilat
