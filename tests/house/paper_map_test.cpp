// SPDX-License-Identifier: MIT
// docs/paper.md says where each element of the paper is: nothing it names may be missing, nothing that is
// judged left out.
#include <filesystem>
#include <regex>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "tests/support/paths.h"

namespace trilat {
namespace {

std::string map_text() { return read_file(std::filesystem::path(kSourceDir) / "docs/paper.md"); }

// What stands between backticks, and matches.
std::set<std::string> named(const std::string& pattern) {
  const std::string text = map_text();
  const std::regex expression("`(" + pattern + ")`");
  std::set<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), expression), end; it != end; ++it)
    found.insert((*it)[1]);
  return found;
}

std::set<std::string> ids_in(const char* file, const char* list) {
  std::set<std::string> ids;
  const Json json = read_json(std::filesystem::path(kSourceDir) / "datasets/paper" / file);
  for (const Json& row : json[list]) ids.insert(row["id"].get<std::string>());
  return ids;
}

TEST(PaperMap, EveryPlaceItNamesIsThere) {
  const std::set<std::string> places = named("[a-z]+/[a-z0-9_/]*(?:\\.[a-z0-9]+)?");
  EXPECT_GE(places.size(), 25u);
  for (const std::string& place : places)
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(kSourceDir) / place)) << place;
}

TEST(PaperMap, EveryClaimAndErratumIsInItAndNoOther) {
  const std::set<std::string> claims = ids_in("claims.json", "claims");
  const std::string text = map_text();
  for (const std::string& id : claims) EXPECT_NE(text.find('`' + id + '`'), std::string::npos) << id;
  const std::string below = text.substr(text.find("## Claims"));
  const std::regex name("`([a-z0-9_]+)`");
  for (std::sregex_iterator it(below.begin(), below.end(), name), end; it != end; ++it)
    EXPECT_TRUE(claims.contains((*it)[1])) << (*it)[1];
  EXPECT_NE(text.find("E1 to E" + std::to_string(ids_in("errata.json", "errata").size())), std::string::npos);
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
