// SPDX-License-Identifier: MIT
// docs/explanation/paper.md says where each element of the paper is: nothing it names may be missing.
#include <filesystem>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/json.h"
#include "tests/support/paths.h"

namespace trilat {
namespace {

std::string map_text() { return read_file(std::filesystem::path(kSourceDir) / "docs/explanation/paper.md"); }

// What stands between backticks.
std::set<std::string> named(const std::string& text) {
  std::set<std::string> found;
  for (std::size_t at = text.find('`'); at != std::string::npos;) {
    const std::size_t end = text.find('`', at + 1);
    found.insert(text.substr(at + 1, end - at - 1));
    at = text.find('`', end + 1);
  }
  return found;
}

TEST(PaperMap, EveryPlaceItNamesIsThere) {
  std::string text = map_text();  // what it names of a report is held against one by Program.reproduce
  const std::size_t outputs = text.find("## Tables and figures"), behind = text.find("## Experiments");
  ASSERT_LT(outputs, behind);
  text.erase(outputs, behind - outputs);
  int places = 0;
  for (const std::string& name : named(text)) {
    if (name.find('/') == std::string::npos) continue;
    ++places;
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(kSourceDir) / name)) << name;
  }
  EXPECT_GE(places, 25);
}

TEST(PaperMap, ItCountsTheErrata) {
  const Json errata = read_json(std::filesystem::path(kSourceDir) / "datasets/paper/errata.json")["errata"];
  EXPECT_NE(map_text().find("E1 to E" + std::to_string(errata.size())), std::string::npos);
}

TEST(PaperMap, AllTwentyTwoEquationsAndFourTablesAreInIt) {
  const std::string text = map_text();
  for (const char* row : {"| 1 |",      "| 2 |",       "| 3 |",        "| 4 |",      "| 5 |",        "| 6 |",
                          "| 7 |",      "| 8 |",       "| 9 |",        "| 10 |",     "| 11 to 13 |", "| 14 |",
                          "| 15, 16 |", "| 17 |",      "| 18 |",       "| 19 |",     "| 20, 21 |",   "| 22 |",
                          "| Table I,", "| Table II,", "| Table III,", "| Table IV,"})
    EXPECT_NE(text.find(row), std::string::npos) << row;
}

}  // namespace
}  // namespace trilat
