// SPDX-License-Identifier: MIT
#include "pipeline/study/results_folder.h"

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

fs::path folder_with(const fs::path& folder, const std::string& file, const std::string& text) {
  make_folder(folder);
  write_file(folder / file, text);
  return folder;
}

TEST(ResultsFolder, WhatALinkLeadsToIsReplacedAndTheLinkStays) {
  const ScratchFolder folder;
  folder_with(folder / "scratch/results", "run.json", R"({"format": "trilat.run"})");
  fs::create_directory_symlink(folder / "scratch/results", folder / "results");
  const ResultsFolder results(folder / "results/");
  write_file(results.partial() / "new", "");
  EXPECT_TRUE(fs::exists(folder / "scratch/results.partial"));
  results.put_in_place();
  EXPECT_TRUE(fs::is_symlink(folder / "results"));
  EXPECT_TRUE(fs::exists(folder / "scratch/results/new"));
  fs::create_directory_symlink(folder / "nowhere", folder / "dangling");
  EXPECT_THAT(message_of([&] { ResultsFolder{folder / "dangling"}; }),
              HasSubstr("is a link that leads to no folder"));
}

TEST(ResultsFolder, ResultsThatLostTheirNameBetweenTwoRenamesGetItBack) {
  const ScratchFolder folder;
  folder_with(folder / "results.partial.old", "run.json", R"({"format": "trilat.run"})");
  { const ResultsFolder results(folder / "results"); }
  EXPECT_TRUE(fs::exists(folder / "results/run.json"));
  EXPECT_FALSE(fs::exists(folder / "results.partial.old"));
}

TEST(ResultsFolder, WhatWasNotLeftUnfinishedIsNotEmptied) {
  const ScratchFolder folder;
  folder_with(folder / "results.partial/mine", "thesis.txt", "");
  const auto message = [&] { return message_of([&] { ResultsFolder{folder / "results"}; }); };
  EXPECT_THAT(message(), HasSubstr("results.partial: is nothing that this program left unfinished"));
  EXPECT_TRUE(fs::exists(folder / "results.partial/mine/thesis.txt"));
  fs::rename(folder / "results.partial", folder / "precious");
  fs::create_directory_symlink(folder / "precious", folder / "results.partial");
  EXPECT_THAT(message(), HasSubstr("move it away"));
  EXPECT_TRUE(fs::exists(folder / "precious/mine/thesis.txt"));
}

TEST(ResultsFolder, RefusesAMountPointBeforeAnythingIsComputed) {
  EXPECT_THAT(message_of([&] { ResultsFolder{"/proc"}; }), HasSubstr("is a mount point"));
}

TEST(ResultsFolder, WhatOnlyAnUnfinishedOutputNeedsIsThereUntilItIsInPlace) {
  const ScratchFolder folder;
  const ResultsFolder results(folder / "results");
  folder_with(results.partial() / "items", "samples", "");
  fs::rename(results.partial(), folder / "aside");
  EXPECT_THROW(results.put_in_place(), OutputError);
  fs::rename(folder / "aside", results.partial());
  EXPECT_TRUE(fs::exists(results.partial() / "items"));
  results.put_in_place();
  EXPECT_TRUE(fs::is_empty(folder / "results"));
}

}  // namespace
}  // namespace trilat
