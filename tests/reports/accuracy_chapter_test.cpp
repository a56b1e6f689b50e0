// SPDX-License-Identifier: MIT
// The report of accuracy results that hold everything a run writes beside the summary.
#include <algorithm>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/declared_parameters.h"
#include "datasets/results/studies/tracking_summary.h"
#include "reports/write_report.h"
#include "tests/reports/summaries.h"
#include "tests/reports/written_samples.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

std::filesystem::path full_results(const ScratchFolder& folder, const std::string& name,
                                   const std::vector<DeclaredParameter>& parameters) {
  const auto path = folder / name;
  write_samples(
      path, samples_of({"nonlinear", "mean"}, {{"p01", 60, "walking"}}),
      [](std::size_t, double t, std::size_t) { return 1.0 + 0.1 * t; },
      [](std::size_t, double t, std::size_t, std::size_t) { return 1.1 + 0.1 * t; });
  write_summary(path, hand_made_summary());
  TrackingSummary tracking{"table3", true, true, {}, {}, {}};
  tracking.views = {{"walking", "k1", "wrist", "inferred", 100, 10}};
  tracking.exchanges = {{"walking", "k1", 200, 50, 3}};
  tracking.clocks = {{"p01", "found", 0.0125, 0.010, 0.015, 3.0, 40.0, 0.95, 0.5, true}};
  write_beside(path, tracking);
  if (!parameters.empty()) write_declared_parameters(path, parameters);
  return path;
}

const std::vector<DeclaredParameter> kAssumed{{"frame rate", "30", "Hz", "SDK"}},
    kOther{{"frame rate", "15", "Hz", "set in the simulation"}};

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(AccuracyChapter, HoldsTablesTrackingFiguresAndWhatIsAssumed) {
  const ScratchFolder folder;
  const ReportFiles report = write_report({full_results(folder, "mine", kAssumed)}, folder / "report");
  const std::string page = read_file(folder / "report/report.html");
  for (const char* part :
       {"Which views are rejected, by joint", "Which views are rejected, by sensor",
        "Left and right exchanged by a sensor", "Offset between mocap and sensors by motion",
        "What the simulation behind mine assumes", "figures/mine/trajectory-walking-wrist_right.svg"})
    EXPECT_GE(count_of(page, part), 1u) << part;
  EXPECT_EQ(report.figures, 2u);  // errors by method, and the height of a wrist
  for (const auto& path : report.written) EXPECT_GT(std::filesystem::file_size(path), 0u) << path;
  EXPECT_TRUE(std::filesystem::exists(folder / "report/figures/mine/trajectory-walking-wrist_right.csv"));
}

TEST(AccuracyChapter, StudiesThatAssumeTheSameShareATableAndOthersHaveTheirOwn) {
  const ScratchFolder folder;
  const auto one = full_results(folder, "one", kAssumed), two = full_results(folder, "two", kAssumed),
             three = full_results(folder, "three", kOther), four = full_results(folder, "four", {});
  write_report({one, two / "", four}, folder / "same");
  const std::string same = read_file(folder / "same/report.html");
  EXPECT_EQ(count_of(same, "What the simulation behind"), 1u);
  EXPECT_THAT(same, HasSubstr("What the simulation behind one, two assumes"));
  write_report({one, three}, folder / "other");
  const std::string other = read_file(folder / "other/report.html");
  EXPECT_EQ(count_of(other, "What the simulation behind"), 2u);
  EXPECT_THAT(other, HasSubstr("What the simulation behind three assumes"));
  EXPECT_THAT(other, HasSubstr("tables/assumptions/three.csv"));
}

TEST(AccuracyChapter, WithoutTheExtraFilesTheTablesAreThere) {
  const ScratchFolder folder;
  const auto results = full_results(folder, "mine", kAssumed);
  for (const char* file : {"samples.h5", "tracking.json", "simulator.json"})
    std::filesystem::remove(results / file);
  const ReportFiles report = write_report({results}, folder / "report");
  EXPECT_EQ(report.figures, 1u);  // errors by method
  EXPECT_EQ(report.tables, 2u);   // errors, and their long form
  EXPECT_THAT(read_file(folder / "report/report.html"), Not(HasSubstr("What the simulation behind")));
}

TEST(AccuracyChapter, ADamagedFileBesideTheSummaryIsNamed) {
  const ScratchFolder folder;
  for (const char* file : {"tracking.json", "simulator.json", "samples.h5"}) {
    const auto results = full_results(folder, file, kAssumed);
    write_file(results / file, "{}");
    EXPECT_THAT(message_of([&] { write_report({results}, folder / "report"); }), HasSubstr(file));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "report"));
}

}  // namespace
}  // namespace trilat
