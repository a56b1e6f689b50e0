// SPDX-License-Identifier: MIT
#include "datasets/results/numbers.h"

#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/item_store.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

const NumberKey kHead{
    .condition = "walking", .group = "head", .method = "nonlinear, three", .alignment = "mean"};

Numbers three_numbers() {
  Numbers numbers;
  numbers.add(
      {kHead.with({.measure = "distance", .statistic = "mean"}), 0.1, 1.0 / 30.0, 0.3, 1234, 16, 0.04});
  numbers.add({kHead.with({.measure = "answered", .statistic = "share"}), 0.75});
  numbers.add({kHead.with({.method = "say \"hi\"\nagain", .measure = "jerk", .statistic = "mean"}), 1e-300});
  return numbers;
}

std::string damage_of(const std::string& text, std::size_t expected = 3) {
  const ScratchFolder folder;
  write_file(folder / kNumbersFile, text);
  try {
    read_numbers(folder.path(), expected);
  } catch (const InputError& error) {
    return error.what();
  }
  return "was read";
}

std::string written() {
  const ScratchFolder folder;
  write_numbers(folder.path(), three_numbers());
  return read_file(folder / kNumbersFile, 10'000);
}

std::string with(const std::string& old, const std::string& now) {
  std::string text = written();
  text.replace(text.find(old), old.size(), now);
  return text;
}

TEST(Numbers, AreReadBackToTheLastBit) {
  const ScratchFolder folder;
  const Numbers before = three_numbers();
  write_numbers(folder.path(), before);
  const Numbers after = read_numbers(folder.path(), 3);
  ASSERT_EQ(after.all().size(), 3u);
  for (const Number& number : before.all()) {
    const Number* same = after.find(number);
    ASSERT_TRUE(same) << number.method;
    EXPECT_EQ(same->value, number.value);
    EXPECT_TRUE(same->low == number.low || std::isnan(number.low));
    EXPECT_EQ(same->n, number.n);
    EXPECT_EQ(same->clusters, number.clusters);
    EXPECT_TRUE(same->p == number.p || std::isnan(number.p));
  }
}

TEST(Numbers, WithoutAValueAreLeftOut) {
  Numbers numbers;
  numbers.add({kHead, kNaN});
  EXPECT_TRUE(numbers.all().empty());
  EXPECT_EQ(numbers.find(kHead), nullptr);
  EXPECT_TRUE(std::isnan(numbers.value(kHead)));
  EXPECT_EQ(numbers.n(kHead), 0u);
}

// One sample alone has no error relative to its mean, and what is compared with that has no ratio.
TEST(Numbers, ThatAreNotFiniteAreLeftOutAndReadBack) {
  const ScratchFolder folder;
  Numbers numbers;
  numbers.add({kHead.with({.measure = "distance", .statistic = "relative_difference"}), HUGE_VAL});
  numbers.add({kHead.with({.measure = "distance", .statistic = "ratio"}), -HUGE_VAL});
  numbers.add({kHead.with({.measure = "distance", .statistic = "mean"}), 0.1, -HUGE_VAL, HUGE_VAL});
  ASSERT_EQ(numbers.all().size(), 1u);
  write_numbers(folder.path(), numbers);
  const Numbers after = read_numbers(folder.path(), 1);
  EXPECT_EQ(after.all()[0].value, 0.1);
  EXPECT_TRUE(std::isnan(after.all()[0].low) && std::isnan(after.all()[0].high));
}

TEST(Numbers, EveryPartOfAKeyTellsTwoApart) {
  Numbers numbers;
  NumberKey key;
  numbers.add({key, 0.0});
  for (std::string NumberKey::*part :
       {&NumberKey::condition, &NumberKey::group, &NumberKey::method, &NumberKey::against,
        &NumberKey::alignment, &NumberKey::measure, &NumberKey::statistic, &NumberKey::take}) {
    NumberKey other;
    other.*part = "a";
    numbers.add({other, 1.0});
    EXPECT_EQ(numbers.value(other), 1.0);
    EXPECT_EQ(key.with(other), other);
  }
  EXPECT_EQ(numbers.value(key), 0.0);
}

TEST(Numbers, DamageIsNamedWithItsRow) {
  EXPECT_THAT(damage_of(written().substr(0, written().find("answered"))),
              HasSubstr("numbers.csv:3: is cut: the line has no end"));
  EXPECT_THAT(damage_of(with(",1,0.75,", ",0.75,")), HasSubstr("numbers.csv:3: has 14 of 15 cells"));
  Numbers with_p;  // whose last digits are gone: what is left is a number, too
  with_p.add({kHead.with({.measure = "distance", .statistic = "mean"}), 0.1, 0.0, 0.3, 9, 16, 0.0412});
  const ScratchFolder folder;
  write_numbers(folder.path(), with_p);
  const std::string whole = read_file(folder / kNumbersFile, 10'000);
  EXPECT_EQ(damage_of(whole, 1), "was read");
  EXPECT_THAT(damage_of(whole.substr(0, whole.size() - 3), 1), HasSubstr("numbers.csv:2: is cut"));
  EXPECT_THAT(damage_of(written(), 4), HasSubstr("has 3 numbers, and 4 were written"));
  EXPECT_THAT(damage_of(written(), 2), HasSubstr("has 3 numbers, and 2 were written"));
  EXPECT_THAT(damage_of(written() + written().substr(written().find("walking"))),
              HasSubstr("numbers.csv:5: repeats a number that stands above"));
  EXPECT_THAT(damage_of(with(",m,0.1", ",cm,0.1")),
              HasSubstr("numbers.csv:2: unit is \"cm\"; it must be m, the unit of distance mean"));
  EXPECT_THAT(damage_of(with("0.1,", "0,1,")), HasSubstr("numbers.csv:2: has 16 of 15 cells"));
  EXPECT_THAT(damage_of(with("0.1,", "ten,")), HasSubstr("numbers.csv:2: value is \"ten\""));
  EXPECT_THAT(damage_of(with("0.1,", ",")), HasSubstr("numbers.csv:2: value is \"\"; it must be a number"));
  EXPECT_THAT(damage_of(with("0.3,", "inf,")), HasSubstr("numbers.csv:2: high is \"inf\""));
  EXPECT_THAT(damage_of(with(",1234,", ",-1,")), HasSubstr("numbers.csv:2: n is \"-1\"; it must be a count"));
  EXPECT_THAT(damage_of(with("condition,", "Condition,")), HasSubstr("numbers.csv:1: must be the line"));
  EXPECT_THAT(damage_of(""), HasSubstr("has 0 numbers, and 3 were written"));
}

TEST(Manifest, PartsOfTwoRunsAreRefusedWithBothNames) {
  Manifest manifest;
  manifest.place = JsonPlace("r/manifest.json");
  manifest.study.kind = "accuracy";
  manifest.study.name = "old";
  manifest.campaign = "spring";
  const auto refused = [&](const char* kind, const char* study, const char* campaign) {
    return message_of([&] { check_same_run(manifest, kind, study, campaign); });
  };
  EXPECT_THAT(refused("accuracy", "new", "spring"),
              HasSubstr("/study/name: is \"old\", and that of summary.json beside it \"new\""));
  EXPECT_THAT(refused("clocks", "old", "spring"),
              HasSubstr("/study/kind: is \"accuracy\", and that of summary.json beside it \"clocks\""));
  EXPECT_THAT(refused("accuracy", "old", "autumn"),
              HasSubstr("/campaign: is \"spring\", and that of summary.json beside it \"autumn\""));
  EXPECT_NO_THROW(check_same_run(manifest, "accuracy", "old", "spring"));
  EXPECT_NO_THROW(check_same_run(manifest, "accuracy", "old", ""));
}

}  // namespace
}  // namespace trilat
