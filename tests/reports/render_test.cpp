// SPDX-License-Identifier: MIT
#include "reports/render/render.h"

#include <limits>

#include <gmock/gmock.h>

#include "reports/page/html.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

Table small_table() {
  Table table;
  table.id = "small";
  table.title = "A table";
  table.columns = {{"joint", "joint", true}, {"MAE (cm)", "mae_cm", false}};
  table.rows = {{TableValue::of("head"), TableValue::of(1.0 / 3.0, 2)},
                {TableValue::of("müde"), TableValue::of(123.456, 2)},
                {TableValue::of("x"), TableValue::of(kNaN, 2)}};
  table.notes = {"One note.", "Another."};
  return table;
}

Table table_with(const std::string& text) {
  Table table = small_table();
  table.rows = {{TableValue::of(text), TableValue::of(1.0, 1)}};
  return table;
}

TEST(Markdown, ColumnsAreAlignedByCharactersNotBytes) {
  EXPECT_EQ(markdown_of(small_table()),
            "**A table**\n"
            "\n"
            "| joint | MAE (cm) |\n"
            "| ----- | -------: |\n"
            "| head  |     0.33 |\n"
            "| müde  |   123.46 |\n"
            "| x     |        – |\n"
            "\n"
            "- One note.\n"
            "- Another.\n");
}

TEST(Markdown, NarrowColumnsAndTablesWithoutRowsOrNotesKeepTheirShape) {
  Table table;
  table.title = "t";
  table.columns = {{"n", "n", false}};
  EXPECT_EQ(markdown_of(table), "**t**\n\n|   n |\n| --: |\n");
}

TEST(Markdown, BarsAndLineBreaksInACellDoNotBreakTheRow) {
  EXPECT_THAT(markdown_of(table_with("a|b\r\nc")), HasSubstr("\n| a\\|b  c |      1.0 |\n"));
}

TEST(Csv, FollowsRfc4180WithFullPrecisionAndEmptyFieldsForNaN) {
  Table table = small_table();
  table.rows.push_back({TableValue::of("say \"hi\", you"), TableValue::of(1e300, 1)});
  table.rows.push_back({TableValue::of("two\nlines"), TableValue::of(-0.1, 0)});
  table.rows.push_back(
      {TableValue::of("endless"), TableValue::of(std::numeric_limits<double>::infinity(), 1)});
  EXPECT_EQ(csv_of(table),
            "joint,mae_cm\r\n"
            "head,0.3333333333333333\r\n"
            "müde,123.456\r\n"
            "x,\r\n"
            "\"say \"\"hi\"\", you\",1e+300\r\n"
            "\"two\nlines\",-0.1\r\n"
            "endless,\r\n");
}

TEST(Latex, SpecialCharactersAreEscaped) {
  const std::string text = *latex_of(table_with("& % $ # _ { } ~ ^ \\ < >"));
  EXPECT_THAT(text, HasSubstr("\\& \\% \\$ \\# \\_ \\{ \\} \\textasciitilde{} \\textasciicircum{} "
                              "\\textbackslash{} \\textless{} \\textgreater{} & 1.0 \\\\"));
}

TEST(Latex, ALineBreakInATextDoesNotEndTheParagraph) {
  Table table = table_with("a\n\nb");
  table.title = "one\n\ntwo";
  EXPECT_THAT(*latex_of(table), Not(HasSubstr("\n\n")));
}

TEST(Latex, ATableEnvironmentHoldsCaptionLabelAndEveryRow) {
  const std::string text = *latex_of(small_table());
  EXPECT_THAT(text, HasSubstr("\\begin{table}\n\\centering\\footnotesize"));
  EXPECT_THAT(text, HasSubstr("\\caption{A table}\\label{tab:small}\n\\begin{tabular}{lr}\n\\toprule\n"));
  EXPECT_THAT(text, HasSubstr("joint & MAE (cm) \\\\\n\\midrule\n"));
  EXPECT_THAT(text, HasSubstr("\nhead & 0.33 \\\\\n"));
  EXPECT_THAT(text, HasSubstr("\nx & -- \\\\\n\\bottomrule\n\\end{tabular}\n"));
  EXPECT_THAT(text, HasSubstr("Another.\n\\end{table}\n"));
}

TEST(Latex, ValuesHaveHalfTheirIntervalAndWhatIsPrintedARowOfItsOwn) {
  Table table = small_table();
  const auto value = [](double number, double low, double high) {
    TableValue cell = TableValue::of(number, 1);
    cell.low = low;
    cell.high = high;
    return cell;
  };
  table.rows = {{TableValue::of("a"), value(9.61, 9.2, 10.02)},
                {TableValue::of("b"), value(98.0, 90.0, 99.5)}};
  table.rows[0][1].beside = "paper 8.7";
  table.rows[0][1].mark = TableValue::Mark::best;
  const std::string text = *latex_of(table);
  EXPECT_THAT(text,
              HasSubstr("a & \\textbf{9.6}\\,\\ensuremath{\\pm}\\,0.4 \\\\\n\\quad paper & 8.7 \\\\\n"));
  // what stands beside one of two numbers has the row's name, too
  table.columns.push_back({"RMSE (cm)", "rmse_cm", false});
  for (auto& row : table.rows) row.push_back(TableValue::of(1.0, 1));
  EXPECT_THAT(*latex_of(table), HasSubstr("\\quad paper & 8.7 & "));
  EXPECT_THAT(text, HasSubstr("b & 98.0 (90.0 to 99.5) \\\\\n"));
}

// A column of numbers is as wide as "10.0 ± 0.5", nine letters: four of them and a name of eight fit into 69
// mm.
TEST(Latex, ATableIsAsWideAsItsIntervals) {
  Table table;
  table.id = "t";
  table.columns = {{"m", "m", true}};
  for (int c = 0; c < 4; ++c) table.columns.push_back({"c", "c"});
  const auto kind_of = [&](std::size_t letters) {
    TableValue value = TableValue::of(10.0, 1);
    value.low = 9.5;
    value.high = 10.5;
    table.rows = {{TableValue::of(std::string(letters, 'x')), value, value, value, value}};
    return latex_of(table)->substr(0, 14);
  };
  EXPECT_EQ(kind_of(8), "\\begin{table}\n");
  EXPECT_EQ(kind_of(9), "\\begin{table*}");
}

TEST(Latex, AnIntervalThatIsNotAboutItsValueKeepsItsEnds) {
  const auto cell_of = [](double high) {
    Table table = small_table();
    TableValue value = TableValue::of(10.0, 0);
    value.low = 9.0;
    value.high = high;
    table.rows = {{TableValue::of("a"), value}};
    return *latex_of(table);
  };
  EXPECT_THAT(cell_of(11.125),
              HasSubstr("a & 10\\,\\ensuremath{\\pm}\\,1 "));   // off by 0.0625 of 0.053 + 0.01
  EXPECT_THAT(cell_of(11.14), HasSubstr("a & 10 (9 to 11) "));  // by 0.07
}

TEST(Latex, TakesThePagesColumnsInTheirOrderAsWideAsTheyNeed) {
  Table table;
  table.id = "wide";
  table.columns = {{"method", "method", true}};
  table.rows = {{TableValue::of("mean")}};
  const auto add = [&](const std::string& key) {
    table.columns.push_back({key, key});
    table.rows[0].push_back(TableValue::of(1.0, 1));
  };
  add("head");
  add("average_mae_cm");
  EXPECT_THAT(*latex_of(table), HasSubstr("method & average\\_mae\\_cm (cm) & head"));
  for (int k = 0; k < 12; ++k) add("column");
  EXPECT_THAT(*latex_of(table), HasSubstr("\\begin{table*}"));
  for (int k = 0; k < 12; ++k) add("column");
  EXPECT_FALSE(latex_of(table));
  table.columns.resize(2);
  table.rows.assign(46, {TableValue::of("mean"), TableValue::of(1.0, 1)});
  EXPECT_FALSE(latex_of(table));
  table.first_rows = 8;
  EXPECT_TRUE(latex_of(table));
}

TEST(Render, MarkdownShowsWhatANameHoldsAndRunsNoneOfIt) {
  EXPECT_THAT(markdown_of(table_with("<b>*x* `y` [z](u) a_b _c_")),
              HasSubstr("\\<b>\\*x\\* \\`y\\` \\[z\\](u) a_b \\_c\\_"));
  EXPECT_THAT(markdown_of(table_with("a_ b")), HasSubstr("| a\\_ b |"));
  EXPECT_THAT(markdown_of(table_with("a _b")), HasSubstr("| a \\_b |"));
  EXPECT_THAT(markdown_of(table_with("R&D &amp; &#38; & x")), HasSubstr("| R\\&D \\&amp; \\&#38; & x |"));
}

TEST(Render, CsvTextsAreNoFormulas) {
  EXPECT_THAT(csv_of(table_with("=1+1")), HasSubstr("\n=1+1,"));
  EXPECT_THAT(csv_of(table_with("a=b")), HasSubstr("\na=b,"));
  Table table = table_with("x");
  table.rows[0][1] = TableValue::of(-1.5, 1);
  EXPECT_THAT(csv_of(table), HasSubstr(",-1.5"));
}

TEST(Render, LatexCompilesWhateverANameHolds) {
  EXPECT_THAT(*latex_of(table_with("\u6D4B\u8BD5 \u00B5 \u2264 \u00E4")),
              HasSubstr("[U+6D4B][U+8BD5] \\ensuremath{\\mu} \\ensuremath{\\leq} \u00E4"));
  EXPECT_THAT(*latex_of(table_with("\xff")), HasSubstr("[U+FFFD]"));
  EXPECT_EQ(latex_text("\U0001F600 \u00C0\u017E\u0180 \u2026 \u00A0z"),
            "[U+1F600] \u00C0\u017E[U+0180] \\ldots{} ~z");
  EXPECT_EQ(latex_text("\xC3"), "[U+FFFD]");  // cut within a character
  EXPECT_EQ(latex_text("\xE2\x82"), "[U+FFFD]");
  EXPECT_EQ(latex_text("\xE2"
                       "a"),
            "[U+FFFD]a");
  EXPECT_EQ(latex_text("\x80"
                       "b"),
            "[U+FFFD]b");  // begins within one
}

TEST(Terminal, ANarrowOneLeavesOutTheColumnsBeforeTheLastTwo) {
  Table table;
  table.title = "t";
  table.columns = {{"method", "method", true}, {"head", "head"}, {"wrist", "wrist"},
                   {"ankle", "ankle"},         {"mean", "mean"}, {"all", "all"}};
  table.rows = {{TableValue::of("median"), TableValue::of(1.0, 1), TableValue::of(2.0, 1),
                 TableValue::of(3.0, 1), TableValue::of(4.0, 1), TableValue::of(5.0, 1)}};
  EXPECT_EQ(terminal_text(table, 80),
            "t\n"
            "method  head  wrist  ankle  mean  all\n"
            "median   1.0    2.0    3.0   4.0  5.0\n");
  EXPECT_EQ(terminal_text(table, 37), terminal_text(table, 80));
  EXPECT_EQ(terminal_text(table, 36),
            "t\n"
            "method  head  wrist  mean  all\n"
            "median   1.0    2.0   4.0  5.0\n"
            "the report has 1 more column\n");
  EXPECT_THAT(terminal_text(table, 10), HasSubstr("\nmethod  head  mean  all\n"));
  EXPECT_THAT(terminal_text(table, 10), HasSubstr("the report has 2 more columns\n"));
}

TEST(Terminal, OfALongTableItShowsTheFirstRowsAndSaysWhatMarksMean) {
  Table table = small_table();
  table.first_rows = 2;
  table.rows[0][1].mark = TableValue::Mark::best;
  EXPECT_EQ(terminal_text(table, 80),
            "A table\n"
            "joint  MAE (cm)\n"
            "head     0.33 *\n"
            "müde     123.46\n"
            "*: the least error; ≈: cannot be distinguished from it on the samples that both answer\n"
            "the report has 1 more row\n");
}

TEST(Html, AVerdictHasTheColourOfItsMark) {
  using enum TableValue::Mark;
  for (const auto& [mark, colour] :
       {std::pair{good, "v holds"}, std::pair{bad, "v fails"}, std::pair{contradiction, "v fails against"},
        std::pair{unsure, "v unsure"}})
    EXPECT_THAT(verdict_badge("a < b", mark),
                HasSubstr(std::string("class=\"") + colour + "\">a &lt; b</span>"));
}

TEST(Html, SentencesMarkCodeAndBoldAndCloseWhatIsOpen) {
  EXPECT_EQ(html_sentence("a **b** `c < **d**` e"), "a <strong>b</strong> <code>c &lt; **d**</code> e");
  EXPECT_EQ(html_sentence("`open"), "<code>open</code>");
  EXPECT_EQ(html_sentence("**open"), "<strong>open</strong>");
  EXPECT_EQ(html_sentence("2 * 3"), "2 * 3");
}

TEST(Render, AnIntervalOfWhichOneEndIsUnknownIsNone) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto between = [](double low, double high) {
    TableValue value = TableValue::of(3.0, 2);
    value.low = low;
    value.high = high;
    return printed_interval(value);
  };
  EXPECT_EQ(between(1.0, 4.0), "1.00 to 4.00");
  EXPECT_EQ(between(1.0, kNaN), "");
  EXPECT_EQ(between(kNaN, 4.0), "");
}

TEST(Render, WhatRoundsToNothingHasNoSign) {
  EXPECT_EQ(printed(TableValue::of(-0.004, 2)), "0.00");
  EXPECT_EQ(printed(TableValue::of(-0.0, 0)), "0");
  EXPECT_EQ(printed(TableValue::of(-0.006, 2)), "-0.01");
  EXPECT_EQ(printed(TableValue::of(1.0 / 3.0, 40)), "0.33333333333333331");  // 17 digits are all there are
  EXPECT_EQ(printed(TableValue::of(0.25, -1)), "0.25");
}

}  // namespace
}  // namespace trilat
