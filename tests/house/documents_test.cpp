// SPDX-License-Identifier: MIT
// The documents: nothing that they link to is missing, and every page is found from README.
#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "datasets/base/files.h"
#include "tests/support/paths.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = kSourceDir;

std::vector<fs::path> documents() {
  std::vector<fs::path> found{kRoot / "README.md", kRoot / "datasets/FORMATS.md"};
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / "docs"))
    if (entry.path().extension() == ".md") found.push_back(entry.path());
  return found;
}

struct Link {
  std::string file, heading;  // empty: this file; none
};

// Of Markdown links that lead into the project.
std::vector<Link> links_of(const std::string& text) {
  static const std::regex link(R"(\]\(([^)#\s]*)(?:#([^)\s]*))?\))");
  std::vector<Link> links;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), link); it != std::sregex_iterator(); ++it)
    if ((*it)[1].str().find("://") == std::string::npos) links.push_back({(*it)[1], (*it)[2]});
  return links;
}

// As a forge makes them from headings: small letters, digits, hyphens for spaces.
std::set<std::string> anchors_of(const std::string& text) {
  static const std::regex heading(R"((?:^|\n)#+ ([^\n]*))");
  std::set<std::string> anchors;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), heading); it != std::sregex_iterator();
       ++it) {
    std::string anchor;
    for (const char c : (*it)[1].str())
      if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_')
        anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      else if (c == ' ')
        anchor += '-';
    anchors.insert(anchor);
  }
  return anchors;
}

TEST(Documents, EveryRelativeLinkLeadsSomewhere) {
  std::size_t links = 0;
  for (const fs::path& document : documents()) {
    const std::string text = read_file(document);
    for (const Link& link : links_of(text)) {
      const fs::path to = link.file.empty() ? document : document.parent_path() / link.file;
      ++links;
      ASSERT_TRUE(fs::exists(to)) << document << " links to " << link.file;
      if (!link.heading.empty()) {
        EXPECT_TRUE(anchors_of(read_file(to)).contains(link.heading))
            << document << " links to #" << link.heading;
      }
    }
  }
  EXPECT_GE(links, 30u);
}

TEST(Documents, EveryPageIsFoundFromReadme) {
  std::set<fs::path> found{kRoot / "README.md"};
  std::vector<fs::path> open(found.begin(), found.end());
  while (!open.empty()) {
    const fs::path document = open.back();
    open.pop_back();
    for (const Link& link : links_of(read_file(document))) {
      const fs::path to = (document.parent_path() / link.file).lexically_normal();
      if (to.extension() == ".md" && found.insert(to).second) open.push_back(to);
    }
  }
  for (const fs::path& document : documents())
    EXPECT_TRUE(found.contains(document.lexically_normal())) << document;
}

TEST(Documents, ReadmeFitsOnAFewScreensAndItsPictureIsSmall) {
  const std::string text = read_file(kRoot / "README.md");
  EXPECT_LE(std::ranges::count(text, '\n'), 120);
  for (const Link& link : links_of(text))
    if (link.file.ends_with(".svg") || link.file.ends_with(".png")) {
      EXPECT_LT(fs::file_size(kRoot / link.file), 300'000u) << link.file;
    }
}

}  // namespace
}  // namespace trilat
