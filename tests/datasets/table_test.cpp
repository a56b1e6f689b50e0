// SPDX-License-Identifier: MIT
// Stored numbers as cells of a table, and tables as CSV.
#include "datasets/results/table.h"

#include <cmath>

#include <gmock/gmock.h>

namespace trilat {
namespace {

const NumberKey kRow{.condition = "walking", .group = "head", .method = "mean", .alignment = "none"};

TEST(StoredNumbers, AreFoundByEveryPartOfTheirKey) {
  ResultsSummary summary;
  summary.reference = "linear";
  double value = 0.0;
  for (const char* method : {"mean", "linear"})
    for (const char* condition : {"walking", "standing"})
      for (const char* group : {"head", "wrist"})
        for (const char* alignment : {"none", "mean"}) {
          const NumberKey key{
              .condition = condition, .group = group, .method = method, .alignment = alignment};
          value += 0.01;
          summary.numbers.add({key.with({.measure = "answered", .statistic = "share"}), value});
          summary.numbers.add({key.with({.measure = "distance", .statistic = "mean"}), 1.0 + value});
          summary.numbers.add(
              {key.with({.against = "linear", .measure = "distance", .statistic = "difference"}),
               2.0 + value});
          EXPECT_EQ(coverage_of(summary, method, condition, group, alignment), value);
          EXPECT_EQ(find_error(summary, method, condition, group, alignment)->value, 1.0 + value);
          EXPECT_EQ(find_difference(summary, method, condition, group, alignment, "difference")->value,
                    2.0 + value);
        }
  EXPECT_TRUE(std::isnan(coverage_of(summary, "median", "walking", "head", "none")));
}

TEST(TableCells, ShowNumbersInTheUnitOfPeople) {
  Numbers numbers;
  const auto shown = [&](const char* measure, const char* statistic) {
    const NumberKey key = kRow.with({.measure = measure, .statistic = statistic});
    numbers.add({key, 0.5, 0.25, 0.75});
    const TableValue cell = shown_number(numbers, key, 2);
    EXPECT_EQ(cell.decimals, 2);
    EXPECT_DOUBLE_EQ(cell.low, 0.5 * cell.number.value());
    EXPECT_DOUBLE_EQ(cell.high, 1.5 * cell.number.value());
    return cell.number.value();
  };
  EXPECT_DOUBLE_EQ(shown("distance", "mean"), 50.0);   // cm
  EXPECT_DOUBLE_EQ(shown("answered", "share"), 50.0);  // %
  EXPECT_TRUE(std::isnan(
      shown_number(numbers, kRow.with({.measure = "distance", .statistic = "p95"}), 1).number.value()));
}

TEST(TableCells, StatusesAreSharesOfWhatWasAskedFor) {
  Numbers numbers;
  const auto count = [&](const char* measure, const char* statistic, std::uint64_t n) {
    numbers.add({kRow.with({.measure = measure, .statistic = statistic}), 0.0, kNaN, kNaN, n});
  };
  count("answered", "share", 10'000);
  count("status", "converged", 9'000);
  count("status", "too_few", 996);
  count("status", "diverged", 4);
  const std::vector<std::string> names{"diverged", "too_few", "converged", "unused"};
  EXPECT_EQ(statuses_text(numbers, kRow, names), "converged 90.0 %, too_few 10.0 %, diverged <0.1 %");
  Numbers nearly;
  nearly.add({kRow.with({.measure = "answered", .statistic = "share"}), 0.0, kNaN, kNaN, 10'000});
  nearly.add({kRow.with({.measure = "status", .statistic = "converged"}), 0.0, kNaN, kNaN, 9'999});
  EXPECT_EQ(statuses_text(nearly, kRow, names), "converged >99.9 %");
}

TEST(Tables, AreWrittenAsCsvWithTheEndsOfIntervals) {
  Table table;
  table.columns = {{.name = "method", .key = "method", .is_text = true},
                   {.name = "error (cm)", .key = "error_cm", .has_interval = true},
                   {.name = "n", .key = "n"}};
  table.rows = {{TableValue::of("say \"hi\", all"), {1.25, 1, "", 1.0, 1.5}, TableValue::of(3.0, 0)},
                {TableValue::of("none"), TableValue::of("-"), TableValue::of(kNaN, 0)}};
  EXPECT_EQ(csv_of(table),
            "method,error_cm,error_from_cm,error_to_cm,n\r\n"
            "\"say \"\"hi\"\", all\",1.25,1,1.5,3\r\n"
            "none,-,,,\r\n");
}

TEST(Tables, FileNamesKeepLettersAndDigits) {
  EXPECT_EQ(file_name_from("AZaz09._-"), "AZaz09._-");
  EXPECT_EQ(file_name_from("@[`{/:"), "------");
  EXPECT_EQ(file_name_from("Tables I & IV"), "Tables-I---IV");
}

}  // namespace
}  // namespace trilat
