// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "reports/page/page_sections.h"

namespace trilat {

// The takes in 3-D, or one line that says why there are none. `three_js` is the library; empty: it was not
// found.
PageSection replay_section(const ReportContent& content, const std::string& three_js);

}  // namespace trilat
