// SPDX-License-Identifier: MIT
#include "datasets/results/item_journal.h"

#include <fstream>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using ::testing::Optional;

TEST(ItemJournal, RemembersWhatWasDoneWithTheSameKey) {
  const ScratchFolder folder;
  ItemJournal(folder.path()).add({"a", "key", {{"x", 0.1}}});
  const ItemJournal journal(folder.path());
  EXPECT_THAT(journal.find("a", "key"), Optional(Json{{"x", 0.1}}));
  EXPECT_EQ(journal.find("a", "another"), std::nullopt);
  EXPECT_EQ(journal.find("b", "key"), std::nullopt);
}

TEST(ItemJournal, ALineThatWasCutAnywhereIsNotThereAndSpoilsNoOther) {
  const ScratchFolder folder;
  {
    ItemJournal journal(folder.path());
    journal.add({"a", "key", 1});
    journal.add({"b", "key", 2});
  }
  const std::string whole = read_file(folder / "items.jsonl");
  const std::size_t first = whole.find('\n') + 1;
  for (std::size_t end = first; end < whole.size() - 1; ++end) {
    std::ofstream(folder / "items.jsonl", std::ios::binary) << whole.substr(0, end);
    ItemJournal journal(folder.path());
    EXPECT_THAT(journal.find("a", "key"), Optional(Json(1)));
    EXPECT_EQ(journal.find("b", "key"), std::nullopt) << end;
    journal.add({"c", "key", 3});
    EXPECT_THAT(ItemJournal(folder.path()).find("c", "key"), Optional(Json(3)));
  }
}

TEST(ItemJournal, ANumberThatWasChangedIsNoticed) {
  const ScratchFolder folder;
  ItemJournal(folder.path()).add({"a", "key", 12345});
  std::string text = read_file(folder / "items.jsonl");
  text.replace(text.find("12345"), 5, "12346");
  write_file(folder / "items.jsonl", text);
  EXPECT_EQ(ItemJournal(folder.path()).find("a", "key"), std::nullopt);
}

TEST(ItemJournal, WhatWasForgottenStaysForgottenUntilItIsDoneAgain) {
  const ScratchFolder folder;
  {
    ItemJournal journal(folder.path());
    journal.add({"a", "key", 1});
    journal.add({"b", "key", 2});
    journal.forget("a");
    journal.forget("never done");
    EXPECT_EQ(journal.find("a", "key"), std::nullopt);
  }
  ItemJournal journal(folder.path());
  EXPECT_EQ(journal.find("a", "key"), std::nullopt);
  EXPECT_THAT(journal.find("b", "key"), Optional(Json(2)));
  journal.add({"a", "key", 3});
  EXPECT_THAT(ItemJournal(folder.path()).find("a", "key"), Optional(Json(3)));
}

TEST(Items, AreReadAsTheyWereWritten) {
  const ScratchFolder folder;
  write_items(folder.path(), std::array{DoneItem{"a", "k1", {{"x", {0.1, nullptr}}}}, DoneItem{"b", "", 2}},
              "all");
  EXPECT_EQ(read_items_key(folder.path()), "all");
  const DoneItems done = read_items(folder.path());
  EXPECT_EQ(done.key, "all");
  ASSERT_EQ(done.items.size(), 2u);
  EXPECT_EQ(done.items[0].outcome, (Json{{"x", {0.1, nullptr}}}));
  EXPECT_EQ(done.items[1].id, "b");
}

TEST(Items, NoneAreAList) {
  const ScratchFolder folder;
  write_items(folder.path(), {}, "all");
  EXPECT_TRUE(read_items(folder.path()).items.empty());
  EXPECT_EQ(read_items_key(folder.path()), "all");
}

}  // namespace
}  // namespace trilat
