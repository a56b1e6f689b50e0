// SPDX-License-Identifier: MIT
#include <sstream>

#include "datasets/base/error.h"
#include "reports/tables/embedded_notes.h"
#include "reports/tables/table.h"

namespace trilat {

std::vector<std::string> notes(const std::string& section) {
  std::vector<std::string> sentences;
  std::istringstream text(embedded::notes_md);
  bool here = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("## ")) here = line.substr(3) == section;
    if (here && line.starts_with("- ")) sentences.push_back(line.substr(2));
  }
  TRILAT_CHECK(!sentences.empty(), "every section that is asked for is in notes.md");
  return sentences;
}

}  // namespace trilat
