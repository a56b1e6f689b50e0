// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "reports/render/render.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

TrackingSummary tracked() {
  TrackingSummary s;
  s.study = "walks";
  s.simulated = true;
  s.repaired = true;
  s.views = {{"walking", "k1", "wrist", "inferred", 100, 10},
             {"walking", "k2", "wrist", "inferred", 100, 30},
             {"walking", "k1", "head", "inferred", 50, 0},
             {"walking", "k1", "wrist", "mean", 100, 40}};
  s.exchanges = {{"walking", "k1", 200, 50, 3}};
  s.clocks = {{"p01", "found", 0.0125, 0.010, 0.015, 3.0, 40.0, 0.95, 0.5, true}};
  return s;
}

std::string cell(const Table& table, std::size_t row, const std::string& key) {
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    if (table.columns[c].key == key) return printed(table.rows.at(row).at(c));
  ADD_FAILURE() << table.id << " has no " << key;
  return {};
}

const std::string kDash = printed(TableValue::of(kNoNumber, 1));

TEST(TrackingTables, ViewsAreAddedUpByJointAndBySensor) {
  const std::vector<Table> tables = tracking_tables(tracked());
  ASSERT_EQ(tables.size(), 4u);
  const Table& by_joint = tables[0];
  ASSERT_EQ(by_joint.rows.size(), 3u);
  EXPECT_EQ(cell(by_joint, 0, "joint"), "wrist");
  EXPECT_EQ(cell(by_joint, 0, "views"), "200");
  EXPECT_EQ(cell(by_joint, 0, "rejected_percent"), "20.0");
  EXPECT_EQ(cell(by_joint, 2, "rule"), "mean");
  const Table& by_sensor = tables[1];
  ASSERT_EQ(by_sensor.rows.size(), 3u);
  EXPECT_EQ(cell(by_sensor, 0, "sensor"), "k1");
  EXPECT_EQ(cell(by_sensor, 0, "views"), "150");
  EXPECT_EQ(cell(by_sensor, 1, "sensor"), "k2");
}

TEST(TrackingTables, ExchangesSayWhatWasFoundAndWhetherItWasUndone) {
  const Table table = tracking_tables(tracked())[2];
  EXPECT_EQ(cell(table, 0, "found_percent"), "25.0");
  EXPECT_THAT(table.title, HasSubstr("were undone"));
  TrackingSummary left = tracked();
  left.repaired = false;
  EXPECT_THAT(tracking_tables(left)[2].title, HasSubstr("were left as they were"));
}

TEST(TrackingTables, ClocksAreInMillisecondsAndWhatIsNotKnownIsADash) {
  TrackingSummary s = tracked();
  s.clocks.push_back({"p02", "too_little_motion", kNoNumber, kNoNumber, kNoNumber, kNoNumber, kNoNumber,
                      kNoNumber, kNoNumber, false});
  const Table table = tracking_tables(s)[3];
  EXPECT_EQ(cell(table, 0, "offset_ms"), "12.50");
  EXPECT_EQ(printed_interval(table.rows[0][1]), "10.00 to 15.00");
  EXPECT_EQ(cell(table, 0, "applied"), "yes");
  EXPECT_EQ(cell(table, 1, "offset_ms"), kDash);
  EXPECT_EQ(cell(table, 1, "outcome"), "too_little_motion");
  EXPECT_THAT(markdown_of(table), Not(HasSubstr("nan")));
}

TEST(TrackingTables, SaySimulatedOrRecordedAndTablesWithoutRowsAreLeftOut) {
  TrackingSummary s = tracked();
  for (const Table& table : tracking_tables(s)) EXPECT_THAT(table.title, HasSubstr("simulated"));
  s.simulated = false;
  for (const Table& table : tracking_tables(s)) {
    EXPECT_THAT(table.title, HasSubstr("recorded"));
    EXPECT_THAT(table.title, Not(HasSubstr("simulated")));
  }
  s.views.clear();
  EXPECT_EQ(tracking_tables(s).size(), 2u);
  s.clocks.clear();
  s.exchanges.clear();
  EXPECT_TRUE(tracking_tables(s).empty());
}

}  // namespace
}  // namespace trilat
