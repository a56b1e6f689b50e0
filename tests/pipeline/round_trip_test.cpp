// SPDX-License-Identifier: MIT
// Whatever says its fields is filled in every one of them, written, read, and written again: the same bytes.
#include <type_traits>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/figure.h"
#include "datasets/results/item_store.h"
#include "datasets/results/summary.h"
#include "datasets/results/table.h"
#include "datasets/rig/calibration.h"
#include "datasets/rig/campaign.h"
#include "pipeline/accuracy/tracking_summary.h"
#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/clocks/clocks_study.h"
#include "pipeline/sweep/sweep_summary.h"
#include "pipeline/sweep/sweep_tables.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

// Gives every field another value than it begins with, and every number another one than the last.
struct Filler {
  int n = 0;

  bool has(const char*, bool) const { return true; }
  void format(const char*, int = 1) const {}
  template <class T>
  void written(const char*, const T&) const {}
  template <class T>
  void operator()(const char*, T& member, const About&) {
    fill(member);
  }
  template <class T, class... More>
  requires(sizeof...(More) % 2 == 0) void operator()(const char*, T& member, More&&... more) {
    fill(member);
    if constexpr (sizeof...(more) > 0) (*this)(more...);
  }
  template <class T>
  void fill(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      value = !value;
    } else if constexpr (std::is_floating_point_v<T>) {
      value = static_cast<T>(++n + 1.0 / 3.0);
    } else if constexpr (std::is_integral_v<T>) {
      value = static_cast<T>(++n);
    } else if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(1);
    } else if constexpr (std::is_same_v<T, std::string>) {
      value = "text " + std::to_string(++n);
    } else if constexpr (std::is_same_v<T, Json>) {
      value = Json{{"inner", ++n}};
    } else if constexpr (Described<T>) {
      T::fields(value, *this);
    } else if constexpr (requires {
                           value.emplace();
                           value.has_value();
                         }) {
      fill(value.emplace());
    } else if constexpr (requires { typename T::mapped_type; }) {
      fill(value["key" + std::to_string(++n)]);
    } else {
      if constexpr (requires { value.resize(2); }) value.resize(2);
      for (auto& entry : value) fill(entry);
    }
  }
};

template <class T>
T filled() {
  T value;
  Filler().fill(value);
  return value;
}

// Writes, reads and writes the value again; both texts must be equal.
template <class T>
void expect_read_back(const T& value) {
  const Json json = json_of(value);
  const std::string text = json_text(json, 1);
  EXPECT_EQ(text.find("null"), std::string::npos) << "a field was not filled";
  const Json parsed = parse_json(text, "filled.json");
  EXPECT_EQ(json_text(json_of(read_as<T>(parsed, {"filled.json"})), 1), text);
}

template <class T>
class Filled : public testing::Test {};
using Plain = testing::Types<StoredItem, TrackingSummary, SweepTimings, SweepSetting, SweepCell,
                             ResultsSummary, StoredTables, StoredFigures>;
TYPED_TEST_SUITE(Filled, Plain);

TYPED_TEST(Filled, IsReadBackToTheLastBit) { expect_read_back(filled<TypeParam>()); }

// NaN is written as null and read back as NaN.
TEST(FilledStudy, OfAWallMayLackNumbers) {
  const WallRow wall;
  const std::string text = json_text(json_of(wall), 1);
  EXPECT_THAT(text, testing::HasSubstr("null"));
  const Json parsed = parse_json(text, "wall.json");
  EXPECT_EQ(json_text(json_of(read_as<WallRow>(parsed, {"wall.json"})), 1), text);
}

TEST(FilledStudy, OfCalibrationIsReadBackToTheLastBit) {
  expect_read_back(filled<CalibrationSummary>());
  expect_read_back(filled<WandRecording>());
  expect_read_back(filled<WallRecording>());
}

TEST(FilledStudy, OfARecordingIsReadBackToTheLastBit) { expect_read_back(filled<ClocksSummary>()); }

TEST(FilledStudy, OfASweepIsReadBackToTheLastBit) {
  auto summary = filled<SweepSummary>();
  summary.thresholds = summary.ranges = 2;
  summary.cells.resize(8, summary.cells[0]);
  expect_read_back(summary);
}

// Each of the documents that a campaign consists of, filled, as its reader and writer leave it.
TEST(FilledDocument, CampaignMappingAndCalibrationAreReadBackToTheLastBit) {
  const ScratchFolder folder;
  const Campaign campaign{"gait",
                          true,
                          {{"p1-walk",
                            "p1",
                            "walking",
                            folder / "s.h5",
                            folder / "c.json",
                            folder / "m.csv",
                            folder / "j.json",
                            123456789012345,
                            UpAxis::z,
                            {{"mine", folder / "mine.trc", {{"head", {"H1", "H2"}}}, true}}}}};
  write_campaign(folder.path(), campaign);
  const std::string text = read_file(folder / "campaign.json");
  write_campaign(folder.path(), read_campaign(folder.path()));
  EXPECT_EQ(read_file(folder / "campaign.json"), text);
  for (const char* word : {"gait", "true", "p1-walk", "walking", "s.h5", "c.json", "m.csv", "j.json",
                           "123456789012345", "\"z\"", "mine.trc", "\"H2\"", "motion"})
    EXPECT_THAT(text, testing::HasSubstr(word));

  write_file(folder / "mapping.json", R"({"format": "trilat.mapping", "version": 1,
      "joints": {"wrist_left": ["a", "b"], "head": ["c"]}})");
  write_mapping(folder / "again.json", read_mapping(folder / "mapping.json"));
  const std::string mapping = read_file(folder / "again.json");
  write_mapping(folder / "again.json", read_mapping(folder / "again.json"));
  EXPECT_EQ(read_file(folder / "again.json"), mapping);
  for (const char* word : {"wrist_left", "head", "\"a\"", "\"b\"", "\"c\""})
    EXPECT_THAT(mapping, testing::HasSubstr(word));
}

}  // namespace
}  // namespace trilat
