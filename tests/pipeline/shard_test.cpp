// SPDX-License-Identifier: MIT
#include <fstream>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/study.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using ::testing::ElementsAre;

TEST(Shard, IsReadAsKOfN) {
  EXPECT_EQ(parse_shard("3/7", "--shard").number, 3u);
  EXPECT_EQ(parse_shard("7/7", "--shard").of, 7u);
  for (const char* text :
       {"", "3", "0/7", "8/7", "3/", "/7", "3/7 ", "-1/7", "a/b", "1/99999999999999999999", "1/100001"})
    EXPECT_THROW(parse_shard(text, "--shard"), InputError) << text;
}

TEST(Shard, TheDearestItemsGoToTheShardsThatHaveLeast) {
  const std::vector<double> costs{1.0, 5.0, 1.0, 1.0, 1.0, 1.0};
  EXPECT_THAT(shards_of(costs, 2), ElementsAre(2, 1, 2, 2, 2, 2));
}

TEST(Shard, MoreShardsThanItemsLeavesSomeWithNone) {
  EXPECT_THAT(shards_of(std::vector<double>{1.0, 1.0}, 5), ElementsAre(1, 2));
}

TEST(HashCache, AFileThatChangedIsReadAgain) {
  const ScratchFolder folder;
  const auto file = folder / "a.txt";
  HashCache cache;
  std::ofstream(file) << "one";
  const std::string one = cache.hash(file, {}).sha256;
  std::ofstream(file) << "two";
  EXPECT_NE(cache.hash(file, {}).sha256, one);
  EXPECT_EQ(cache.hash(folder / "absent", {}).sha256, "");
}

TEST(HashCache, WhatIsOldIsNotReadAgain) {
  const ScratchFolder folder;
  HashCache cache;
  const std::filesystem::path old = "/bin/sh";  // was not installed within the last two seconds
  const std::string known = cache.hash(old, {}).sha256;
  cache.save(folder.path());
  std::string text = read_file(folder / "hashes.json");
  text.replace(text.find(known), known.size(), std::string(known.size(), 'f'));
  write_file(folder / "hashes.json", text);
  HashCache other;
  other.load(folder.path());
  EXPECT_EQ(other.hash(old, {}).sha256, std::string(known.size(), 'f'));
}

}  // namespace
}  // namespace trilat
