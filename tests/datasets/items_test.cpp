// SPDX-License-Identifier: MIT
#include "datasets/results/items.h"

#include <array>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Makes the item "a/b" of one file.
std::filesystem::path made_item(const ScratchFolder& folder) {
  make_folder(folder / "aside");
  write_file(folder / "aside/data.txt", "12345");
  put_item(folder / "aside", folder.path(), {"a/b", "key", {{"x", 0.1}}});
  return item_folder(folder.path(), "a/b");
}

TEST(Items, AFolderHoldsWhatWasPutIntoIt) {
  const ScratchFolder folder;
  const auto item = made_item(folder);
  EXPECT_FALSE(std::filesystem::exists(folder / "aside"));
  const auto stored = stored_item(item);
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->key, "key");
  EXPECT_EQ(stored->outcome, (Json{{"x", 0.1}}));
  EXPECT_EQ(stored->bytes.at("data.txt"), 5u);
  EXPECT_THAT(damaged_file(*stored, item).string(), IsEmpty());
  EXPECT_EQ(stored_item(item_folder(folder.path(), "none")), std::nullopt);
}

TEST(Items, AFileThatIsCutOrGoneIsNamed) {
  const ScratchFolder folder;
  const auto item = made_item(folder);
  const auto stored = stored_item(item);
  write_file(item / "data.txt", "1234");
  EXPECT_EQ(damaged_file(*stored, item), item / "data.txt");
  std::filesystem::remove(item / "data.txt");
  EXPECT_EQ(damaged_file(*stored, item), item / "data.txt");
}

TEST(Items, OnePutAgainReplacesTheOther) {
  const ScratchFolder folder;
  const auto item = made_item(folder);
  make_folder(folder / "aside");
  put_item(folder / "aside", folder.path(), {"a/b", "other", 2});
  EXPECT_EQ(stored_item(item)->key, "other");
  EXPECT_FALSE(std::filesystem::exists(item / "data.txt"));
}

DoneItem item_number(std::size_t i) {
  return std::array{DoneItem{"a", "k1", {{"x", {0.1, nullptr}}}}, DoneItem{"b", "", 2}}.at(i);
}

TEST(Items, AreListedAsTheyWereWrittenWithTheFilesBesideThem) {
  const ScratchFolder folder;
  write_file(folder / "summary.json", "{}");
  write_items(folder.path(), "all", 2, item_number);
  EXPECT_EQ(read_items_head(folder.path()).key, "all");
  const ItemsHead head = read_items_head(folder.path());
  EXPECT_THAT(head.bytes,
              ElementsAre(testing::Pair("run.json", std::nullopt), testing::Pair("summary.json", 2u)));
  EXPECT_FALSE(has_all_files(folder.path(), head));  // no run.json yet
  write_file(folder / "run.json", "any size");
  EXPECT_TRUE(has_all_files(folder.path(), head));
  EXPECT_FALSE(is_damaged(folder.path(), head));
  write_file(folder / "summary.json", "{");
  EXPECT_TRUE(is_damaged(folder.path(), head));
  const std::vector<DoneItem> items = read_items(folder.path());
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[0].outcome, (Json{{"x", {0.1, nullptr}}}));
  EXPECT_EQ(items[1].id, "b");
}

TEST(Items, NoneAreAList) {
  const ScratchFolder folder;
  write_items(folder.path(), "all", 0, item_number);
  EXPECT_TRUE(read_items(folder.path()).empty());
  EXPECT_EQ(read_items_head(folder.path()).key, "all");
}

TEST(Items, OfAnotherVersionAreRefused) {
  const ScratchFolder folder;
  write_file(folder / "items.json", R"({"format":"trilat.items","version":1,"key":"k","files":{},"items":[
]}
)");
  EXPECT_THAT(message_of([&] { read_items(folder.path()); }), HasSubstr("/version: is another version"));
}

}  // namespace
}  // namespace trilat
