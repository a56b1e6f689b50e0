// SPDX-License-Identifier: MIT
#include <sstream>

#include "datasets/base/error.h"
#include "datasets/results/embedded_notes.h"
#include "datasets/results/table.h"

namespace trilat {

void add_notes(Table& table, const std::string& section, const std::map<std::string, std::string>& names) {
  const std::size_t before = table.notes.size();
  std::istringstream text(embedded::notes_md);
  bool here = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("## ")) here = line.substr(3) == section;
    if (!here || !line.starts_with("- ")) continue;
    line.erase(0, 2);
    for (const auto& [name, value] : names)
      for (std::size_t at = 0; (at = line.find('{' + name + '}', at)) != std::string::npos;
           at += value.size())
        line.replace(at, name.size() + 2, value);
    table.notes.push_back(std::move(line));
  }
  TRILAT_CHECK(table.notes.size() > before, "every section that is asked for is in notes.md");
}

}  // namespace trilat
