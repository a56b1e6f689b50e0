// SPDX-License-Identifier: MIT
#include "reports/page/page.h"

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "reports/page/html.h"
#include "reports/write_report.h"
#include "tests/reports/calibration_summaries.h"
#include "tests/reports/summaries.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string page_with(const ScratchFolder& folder, ResultsSummary summary) {
  std::filesystem::create_directories(folder / "results");
  write_summary(folder / "results", summary);
  write_report({folder / "results"}, folder / "report", {.made = "then"});
  return read_file(folder / "report/report.html");
}

Table one_row(TableValue value) {
  Table table;
  table.id = "t";
  table.title = "A title (with settings)";
  table.columns = {{"method", "method", true}, interval_column("error", "mae_cm")};
  table.rows = {{TableValue::of("a<b"), std::move(value)}};
  return table;
}

TEST(HtmlText, IsEscaped) {
  EXPECT_EQ(html_text("<a href=\"x\">&\x01"), "&lt;a href=&quot;x&quot;&gt;&amp; ");
  EXPECT_EQ(html_sentence("**a<** `b**` c"), "<strong>a&lt;</strong> <code>b**</code> c");
  EXPECT_EQ(html_sentence("left `open"), "left <code>open</code>");
}

TEST(HtmlText, Base64HasTheVectorsOfRfc4648) {
  EXPECT_EQ(base64_of(""), "");
  EXPECT_EQ(base64_of("f"), "Zg==");
  EXPECT_EQ(base64_of("fo"), "Zm8=");
  EXPECT_EQ(base64_of("foo"), "Zm9v");
  EXPECT_EQ(base64_of("foob"), "Zm9vYg==");
  EXPECT_EQ(base64_of(std::string("\xff\xfe\xfd", 3)), "//79");
}

TEST(HtmlTable, NumbersCarryTheirUnroundedValueAndHeadersTheirUnit) {
  const std::string html = html_of(one_row(number_cell(2, 1.0 / 3.0, 0.25, 0.5)), "");
  EXPECT_THAT(
      html,
      HasSubstr(
          "data-v=\"0.3333333333333333\" data-ends=\"0.25,0.5\">0.33 <small>0.25 to 0.50</small></td>"));
  EXPECT_THAT(html, HasSubstr("data-key=\"mae_cm\" data-ends=\"mae_from_cm,mae_to_cm\" class=\"n\"><button "
                              "type=\"button\">error (cm)</button>"));
  EXPECT_THAT(html, HasSubstr("<th scope=\"row\">a&lt;b</th>"));
  EXPECT_THAT(html, HasSubstr("<caption>A title (with settings)</caption>"));
}

TEST(HtmlTable, WhatIsNoNumberIsADashWithoutAValue) {
  EXPECT_THAT(html_of(one_row(TableValue::of(kNoNumber, 2)), ""),
              HasSubstr("<td class=\"n\" data-v=\"\" data-ends=\",\">–</td>"));
}

TEST(HtmlTable, WhatIsNotAskedForAtFirstHides) {
  Table table = one_row(TableValue::of(1.0, 0));
  table.rows.push_back(table.rows.front());
  EXPECT_THAT(html_of(table, ""), Not(HasSubstr("class=\"rest\"")));
  table.first_rows = 1;
  EXPECT_THAT(html_of(table, ""),
              testing::AllOf(HasSubstr("Show 1 more rows"), HasSubstr("<tr class=\"rest\">")));
}

TEST(HtmlTable, CommandsStandUnderTheTableTheyMake) {
  EXPECT_THAT(html_of(one_row(TableValue::of(1.0, 0)), "trilat run \"x\""),
              HasSubstr("<pre>trilat run &quot;x&quot;</pre>"));
}

TEST(Headline, WithoutIntervalsAndDifferencesSaysTheErrorsAlone) {
  ResultsSummary summary = hand_made_summary();
  summary.participants = 1;
  summary.reference = "nonlinear";
  summary.cells.push_back(cell_of("nonlinear", kAverageGroup, 0.03));
  summary.cells.push_back(cell_of("mean", kAverageGroup, 0.05));
  summary.cells.push_back(cell_of("linear", kAverageGroup, kNoNumber, 0));
  PaperFindings findings;
  findings.evidence.walking = summary;
  const Headline headline = headline_of({}, findings, {});
  EXPECT_THAT(
      headline.answers,
      testing::ElementsAre(
          "**Trilateration** of 1 walker, simulated: mean error `nonlinear` 3.0 cm. The paper prints 8.7 cm.",
          "**The plain mean** of the same sensors errs by 5.0 cm."));
}

TEST(Page, SaysFirstWhetherItsNumbersAreSimulated) {
  const ScratchFolder folder;
  ResultsSummary summary = hand_made_summary();
  const std::string simulated = page_with(folder, summary);
  EXPECT_LT(simulated.find("<p class=\"origin\">Simulated data</p>"), simulated.find("<h1>"));
  summary.simulated = false;
  const std::string recorded = page_with(folder, summary);
  EXPECT_THAT(recorded, HasSubstr("<p class=\"origin\">Recorded data</p>"));
  EXPECT_THAT(recorded, Not(HasSubstr("no camera was used")));
}

TEST(Page, SaysOnItsFirstScreenWhatWasFound) {
  const ScratchFolder folder;
  ResultsSummary s = hand_made_summary();
  s.methods = {"nonlinear", "mean", "geometric"};
  s.reference = "nonlinear";
  s.conditions = {"walking"};
  s.groups = {"head"};
  s.best = {{"walking", "head", "mean", {"geometric"}}};
  s.differences.resize(1);
  s.cells = {cell_of("nonlinear", "head", 0.044, 99), cell_of("mean", "head", 0.041, 100),
             cell_of("geometric", "head", 0.01, 60)};  // of the easy samples alone
  for (SummaryCell& cell : s.cells) {
    cell.mae_low_m = cell.mae_m - 0.002;
    cell.mae_high_m = cell.mae_m + 0.004;
  }
  DifferenceCell& d = s.differences[0];
  d.method = "mean";
  d.condition = "walking";
  d.group = "head";
  d.alignment = "mean";
  std::tie(d.low_m, d.high_m) = std::pair(-0.004, -0.002);
  std::tie(d.percent_of_reference, d.percent_low, d.percent_high) = std::tuple(-7.0, -9.0, -5.0);
  const std::string page = page_with(folder, s);
  const std::size_t at = page.find(
      "<strong>walking</strong>, simulated: of 3 methods <code>mean</code> errs least, by 4.1 cm (3.9 to "
      "4.5), -7 % (-9 to -5) against <code>nonlinear</code>; 1 other is not told apart from it "
      "(<code>geometric</code>).");
  EXPECT_LT(at, page.find("<section"));
}

TEST(Page, EveryTableIsOnceOnItOrLinked) {
  const ScratchFolder folder;
  const std::string page = page_with(folder, hand_made_summary());
  const ReportContent content = read_report({folder / "results"});
  EXPECT_FALSE(content.shown_tables().empty());
  EXPECT_FALSE(content.other_tables().empty());
  for (const auto& tables : {content.shown_tables(), content.other_tables()})
    for (const Table* table : tables) EXPECT_THAT(page, HasSubstr("href=\"tables/" + table->id + ".csv\""));
  for (const Table* table : content.shown_tables()) {
    const std::string id = "id=\"table-" + table->id + "\"";
    EXPECT_THAT(page, HasSubstr(id));
    EXPECT_EQ(page.find(id), page.rfind(id)) << table->id;
  }
}

TEST(Page, OwnDataComeBeforeThePaperUnlessItWasAsked) {
  const ScratchFolder folder;
  EXPECT_THAT(page_with(folder, hand_made_summary()), Not(HasSubstr("The paper’s claims")));
}

TEST(Page, WarnsOfWhatAReaderMustKnow) {
  const ScratchFolder folder;
  ResultsSummary s = hand_made_summary();
  s.notes = {{"p1", true, "p1/mocap.csv:3", "is cut"}};
  s.resamples = 100;
  const std::string page = page_with(folder, s);
  for (const char* warning :
       {"Take p1 failed: p1/mocap.csv:3: is cut.", "Only 2 participants: intervals are wide"}) {
    EXPECT_NE(page.find(warning), std::string::npos) << warning;
    EXPECT_LT(page.find(warning), page.find("<section")) << warning;
  }
}

TEST(Page, LoadsNothing) {
  const ScratchFolder folder;
  const std::string page = page_with(folder, hand_made_summary());
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  for (const char* loads : {"src=\"http", "href=\"http", "url(", "@import", "fetch("})
    EXPECT_THAT(page, Not(HasSubstr(loads)));
}

TEST(Page, TextsFromOutsideStayText) {
  const ScratchFolder folder;
  ResultsSummary summary = hand_made_summary();
  summary.campaign = "<script>alert(1)</script>";
  EXPECT_THAT(page_with(folder, summary), Not(HasSubstr("<script>alert")));
}

TEST(Page, ItsFiguresAreInItAndTheOthersBesideIt) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "results");
  write_results(folder / "results", hand_made_calibration());
  write_report({folder / "results"}, folder / "report", {.made = "then"});
  const std::string page = read_file(folder / "report/report.html");
  EXPECT_THAT(page,
              HasSubstr("data:image/svg+xml;base64," +
                        base64_of(read_file(folder / "report/figures/results/distance-and-angle.svg"))));
  EXPECT_THAT(page, HasSubstr("href=\"figures/results/distortion.svg\""));
}

}  // namespace
}  // namespace trilat
