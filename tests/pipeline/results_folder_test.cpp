// SPDX-License-Identifier: MIT
#include "pipeline/results_folder.h"

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/work_part.h"
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

fs::path part_of_kind(const fs::path& folder, const std::string& kind) {
  make_folder(folder);
  write_part(folder, {kind, "build", 1, 2, Json::object(), {}});
  return folder;
}

TEST(ResultsFolder, APartIsReplacedByPartsOfItsKindOnly) {
  const ScratchFolder folder;
  const fs::path part = part_of_kind(folder / "part", "campaign");
  EXPECT_THAT(message_of([&] { ResultsFolder{part}; }), HasSubstr("is a part of kind campaign"));
  EXPECT_THAT(message_of([&] { ResultsFolder(part, {}, "accuracy"); }),
              HasSubstr("is not replaced by something else"));
  EXPECT_TRUE(fs::exists(part / "part.json"));
  ResultsFolder(part, {}, "campaign").put_in_place();
  EXPECT_FALSE(fs::exists(part / "part.json"));
}

TEST(ResultsFolder, KnowsItsOwnWithoutTheOneFileThatAWorkflowEngineRemoves) {
  const ScratchFolder folder;
  const fs::path results = folder_with(folder / "results", "run.json", R"({"format": "trilat.run"})");
  ResultsFolder{results}.put_in_place();
  EXPECT_TRUE(fs::is_empty(results));
  folder_with(results, "manifest.json", R"({"format": "trilat.manifest"})");
  ResultsFolder{results}.put_in_place();
  for (const char* text : {R"({"format": "another.run"})", "[]", "no JSON"}) {
    folder_with(results, "run.json", text);
    EXPECT_THAT(message_of([&] { ResultsFolder{results}; }), HasSubstr("is not a results folder")) << text;
  }
  const fs::path recordings = folder_with(folder / "sim", "items.json", R"({"format": "trilat.items"})");
  EXPECT_THAT(message_of([&] { ResultsFolder{recordings}; }), HasSubstr("is not a results folder"));
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

TEST(ResultsFolder, RefusesAMountPointBeforeAnythingIsComputed) {
  EXPECT_THAT(message_of([&] { ResultsFolder{"/proc"}; }), HasSubstr("is a mount point"));
}

TEST(ResultsFolder, WhatOnlyAnUnfinishedOutputNeedsIsThereUntilItIsInPlace) {
  const ScratchFolder folder;
  const ResultsFolder results(folder / "results");
  folder_with(results.partial() / "takes", "samples", "");
  write_file(results.partial() / ItemJournal::kFile, "");
  fs::rename(results.partial(), folder / "aside");
  EXPECT_THROW(results.put_in_place({ItemJournal::kFile, "takes"}), OutputError);
  fs::rename(folder / "aside", results.partial());
  EXPECT_TRUE(fs::exists(results.partial() / ItemJournal::kFile));
  results.put_in_place({ItemJournal::kFile, "takes"});
  EXPECT_TRUE(fs::is_empty(folder / "results"));
}

}  // namespace
}  // namespace trilat
