// SPDX-License-Identifier: MIT
// Which room may include which: the table is the architecture, and this test holds every file against it.
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/paths.h"

namespace {

struct Arrow {
  std::string from;               // longest matching folder prefix decides
  std::vector<std::string> into;  // folder prefixes it may include
};

const std::vector<Arrow> kArrows{
    {"datasets/base/", {"datasets/base/"}},
    {"datasets/rig/", {"datasets/base/", "datasets/rig/"}},
    {"datasets/results/", {"datasets/base/", "datasets/rig/", "datasets/hdf5/", "datasets/results/"}},
    {"datasets/hdf5/", {"datasets/base/", "datasets/hdf5/"}},
    {"datasets/mocap/", {"datasets/base/", "datasets/rig/", "datasets/mocap/"}},
    {"datasets/", {"datasets/"}},
    {"recorders/", {"datasets/", "recorders/"}},
    {"evaluators/", {"datasets/base/", "datasets/rig/", "evaluators/"}},
    {"reports/", {"datasets/base/", "datasets/results/", "datasets/paper/", "datasets/rig/", "reports/"}},
    {"pipeline/cli/", {"datasets/", "recorders/", "evaluators/", "reports/", "pipeline/"}},
    {"pipeline/study/", {"datasets/", "pipeline/study/"}},
    {"pipeline/simulate/", {"datasets/", "recorders/", "pipeline/"}},
    {"pipeline/", {"datasets/", "evaluators/", "pipeline/"}},
};

bool starts_with_any(const std::string& text, const std::vector<std::string>& prefixes) {
  for (const std::string& prefix : prefixes)
    if (text.starts_with(prefix)) return true;
  return false;
}

const Arrow* arrow_of(const std::string& file) {
  const Arrow* best = nullptr;
  for (const Arrow& arrow : kArrows)
    if (file.starts_with(arrow.from) && (!best || arrow.from.size() > best->from.size())) best = &arrow;
  return best;
}

std::string contents_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

std::vector<std::string> quoted_includes(const std::filesystem::path& path) {
  std::vector<std::string> result;
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line);) {
    const auto start = line.find("#include \"");
    if (start != 0) continue;
    result.push_back(line.substr(10, line.find('"', 10) - 10));
  }
  return result;
}

TEST(IncludeArrows, EveryIncludeFollowsTheTable) {
  const std::filesystem::path root = trilat::kSourceDir;
  std::size_t files = 0;
  for (const char* room : {"datasets", "recorders", "evaluators", "reports", "pipeline"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / room)) {
      const auto extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      const std::string file = std::filesystem::relative(entry.path(), root).generic_string();
      const Arrow* arrow = arrow_of(file);
      ASSERT_NE(arrow, nullptr) << file << " stands in no room of the table";
      for (const std::string& include : quoted_includes(entry.path()))
        EXPECT_TRUE(starts_with_any(include, arrow->into)) << file << " may not include " << include;
    }
  }
  EXPECT_GT(files, 10u);
}

// Files are compiled together, which would hide a header that does not include what it uses: each stands
// first in its own source, and the debug preset compiles every file alone.
TEST(IncludeOrder, EachSourceIncludesItsOwnHeaderFirst) {
  const std::filesystem::path root = trilat::kSourceDir;
  std::size_t files = 0;
  for (const char* room : {"datasets", "recorders", "evaluators", "reports", "pipeline"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / room)) {
      std::filesystem::path header = entry.path();
      if (header.extension() != ".cpp" || !std::filesystem::exists(header.replace_extension(".h"))) continue;
      ++files;
      std::ifstream stream(entry.path());
      std::string line;
      while (std::getline(stream, line) && !line.starts_with("#include")) continue;
      EXPECT_EQ(line, "#include \"" + std::filesystem::relative(header, root).generic_string() + "\"")
          << entry.path();
    }
  }
  EXPECT_GT(files, 100u);
}

// An agent runs on a Windows PC beside a Kinect, for which Debian has Eigen and zlib alone.
TEST(IncludeArrows, TheAgentNeedsNoLibraryThatItsWindowsBuildHasNot) {
  const std::filesystem::path root = trilat::kSourceDir;
  const std::regex library("trilat_room\\(trilat_(frames|frame_source|link|kinect_sdk|agent_run)\\s[^)]*\\)");
  const std::regex source("[a-z_0-9/]+\\.(h|cpp)\\b");
  std::size_t libraries = 0;
  for (const std::string room : {"datasets", "recorders"}) {
    const std::string text = contents_of(root / room / "CMakeLists.txt");
    for (std::sregex_iterator it(text.begin(), text.end(), library), end; it != end; ++it, ++libraries) {
      const std::string block = it->str();
      for (std::sregex_iterator file(block.begin(), block.end(), source); file != end; ++file)
        EXPECT_THAT(contents_of(root / room / file->str()),
                    testing::Not(testing::ContainsRegex("#include <(fmt|nlohmann|hdf5|opencv2|ceres)")))
            << room << "/" << file->str();
    }
  }
  EXPECT_EQ(libraries, 5u);
}

TEST(IncludeArrows, TheTableItselfForbidsWhatTheRoomsMustNotSee) {
  EXPECT_FALSE(starts_with_any("evaluators/x.h", arrow_of("recorders/a.cpp")->into));
  EXPECT_FALSE(starts_with_any("recorders/x.h", arrow_of("evaluators/a.cpp")->into));
  EXPECT_FALSE(starts_with_any("evaluators/x.h", arrow_of("reports/a.cpp")->into));
  EXPECT_FALSE(starts_with_any("pipeline/x.h", arrow_of("reports/a.cpp")->into));
  EXPECT_FALSE(starts_with_any("reports/x.h", arrow_of("pipeline/run.cpp")->into));
  EXPECT_FALSE(starts_with_any("evaluators/x.h", arrow_of("datasets/rig/a.cpp")->into));
}

}  // namespace
