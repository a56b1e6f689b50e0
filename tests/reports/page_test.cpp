// SPDX-License-Identifier: MIT
#include "reports/page/page.h"

#include <gmock/gmock.h>

#include "reports/page/html.h"
#include "reports/tables.h"
#include "tests/reports/made_content.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Html, ATableHasItsTitleLinksCellsAndNotes) {
  EXPECT_EQ(html_of(errors_table()),
            "<div class=\"table\" id=\"table-table3/errors\">\n"
            "<p class=\"title\"><strong>Error</strong> <span>(2 takes, simulated)</span></p>\n"
            "<div class=\"links\"><a href=\"tables/table3/errors.csv\">CSV</a>"
            "<a href=\"tables/table3/errors.tex\">LaTeX</a></div>\n"
            "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Error (2 takes, simulated)\">"
            "<table><caption>Error (2 takes, simulated)</caption>\n"
            "<thead><tr><th scope=\"col\" tabindex=\"0\" aria-sort=\"none\">method</th>"
            "<th scope=\"col\" tabindex=\"0\" aria-sort=\"none\" class=\"n\">average (cm)</th>"
            "<th scope=\"col\" tabindex=\"0\" aria-sort=\"none\" class=\"n\">head (cm)</th></tr></thead>\n"
            "<tbody>\n"
            "<tr><th scope=\"row\">linear</th><td class=\"n\">5.00 <small>paper 8.7</small></td>"
            "<td class=\"n\">5.0 <span title=\"cannot be distinguished from the best\">≈</span> "
            "<small>4.0 to 6.0</small></td></tr>\n"
            "<tr><th scope=\"row\">mean</th><td class=\"n\">4.00</td>"
            "<td class=\"n\"><strong>4.0</strong> <small>3.0 to 5.0</small></td></tr>\n"
            "</tbody></table></div>\n<ul class=\"notes\"><li>Of a &lt; b.</li>\n</ul>\n</div>\n");
}

TEST(Html, ALongTableFoldsItsRowsOrItsColumns) {
  Table table = errors_table();
  table.notes.clear();
  table.first_rows = 1;
  EXPECT_THAT(html_of(table), HasSubstr("<button type=\"button\" class=\"more\">Show 1 more row</button>"));
  EXPECT_THAT(html_of(table), HasSubstr("<tbody>\n<tr><th scope=\"row\">linear"));
  EXPECT_THAT(html_of(table), HasSubstr("\n<tr class=\"rest\"><th scope=\"row\">mean"));
  EXPECT_THAT(html_of(table), HasSubstr("</table></div>\n</div>\n"));  // no list of notes
  table.first_rows = 2;
  EXPECT_THAT(html_of(table), Not(HasSubstr("button")));
  table.first_rows = 0;
  table.first_columns = 2;
  EXPECT_THAT(html_of(table), HasSubstr("<div class=\"table claims\""));
  EXPECT_THAT(html_of(table), HasSubstr("class=\"more\">Show intervals and details</button>"));
  EXPECT_THAT(html_of(table), HasSubstr("<td class=\"n rest\">5.00"));
  EXPECT_THAT(html_of(table), HasSubstr("<td class=\"n\">5.0 "));
  table.first_columns = 3;
  EXPECT_THAT(html_of(table), Not(HasSubstr("button")));
}

TEST(Html, LongTextsAreBrokenAndWideTablesPrintedSmall) {
  Table table = errors_table();
  table.rows[0][0].text = std::string(40, 'x');
  EXPECT_THAT(html_of(table), Not(HasSubstr("class=\"long\"")));
  table.rows[0][0].text += 'x';
  EXPECT_THAT(html_of(table), HasSubstr("<th scope=\"row\" class=\"long\">"));
  table.first_columns = 1;
  table.columns.push_back({"why", "why", true});
  for (auto& row : table.rows) row.push_back(TableValue::of("short"));
  EXPECT_THAT(html_of(table), HasSubstr("<td class=\"rest\">short</td>"));
  while (table.columns.size() < 12) {
    table.columns.push_back({"n", "n"});
    for (auto& row : table.rows) row.push_back(TableValue::of(1.0, 0));
  }
  EXPECT_THAT(html_of(table), Not(HasSubstr(" many\"")));
  table.columns.push_back({"n", "n"});
  for (auto& row : table.rows) row.push_back(TableValue::marked("holds", TableValue::Mark::good));
  EXPECT_THAT(html_of(table), HasSubstr("<div class=\"table claims many\""));
  EXPECT_THAT(html_of(table), HasSubstr("<span class=\"v holds\">holds</span>"));
}

TEST(Html, TextsPicturesAndBytesAreWrittenForAPage) {
  EXPECT_EQ(html_text("a & \"b\" < c > d\n\x01"), "a &amp; &quot;b&quot; &lt; c &gt; d\n ");
  EXPECT_EQ(html_list("x", {"a", "**b**"}),
            "<ul class=\"x\">\n<li>a</li>\n<li><strong>b</strong></li>\n</ul>\n");
  EXPECT_EQ(html_list("x", {}), "");
  // groups with nothing in them are left out, others stay
  EXPECT_EQ(svg_source("<g id='1'>\n</g>\n<g a='%#&'>\t<p/>\n</g>\n"),
            "data:image/svg+xml,<g a=&#39;%25%23&amp;&#39;> <p/> </g> ");
  EXPECT_EQ(base64_of("a"), "YQ==");
  EXPECT_EQ(base64_of("abc"), "YWJj");
  EXPECT_EQ(deflated("")[0], '\x78');  // zlib's head
  EXPECT_LT(deflated(std::string(1000, 'a')).size(), 30u);
}

std::string page(const ReportContent& content, const std::string& three_js = "") {
  return page_of(content, {.made = "2026-01-01", .citation = "@misc{a}", .three_js = three_js});
}

std::string section_of(const std::string& page, const std::string& id) {
  const std::size_t begin = page.find("<section id=\"" + id + "\">");
  if (begin == std::string::npos) return {};
  return page.substr(begin, page.find("</section>", begin) - begin);
}

TEST(Page, HasItsSectionsInOrderAndListsThem) {
  ReportContent content;
  content.chapters = {chapter_of("walks"), chapter_of("swings")};
  content.headline = headline_of(content, {}, {});
  const std::string html = page(content);
  EXPECT_THAT(html, HasSubstr("<a class=\"skip\" href=\"#chapter-1\">"));
  EXPECT_THAT(html, HasSubstr("<li><a href=\"#chapter-1\">walks on lab</a></li>\n<li><a "
                              "href=\"#chapter-2\">swings on lab</a></li>\n<li><a href=\"#provenance\">"));
  EXPECT_THAT(html, Not(HasSubstr("href=\"#claims\"")));
  EXPECT_THAT(html, Not(HasSubstr("href=\"#errata\"")));
  EXPECT_THAT(html, Not(HasSubstr("href=\"#replay\"")));
  EXPECT_THAT(html, Not(HasSubstr("href=\"#assumptions\"")));
  EXPECT_THAT(html, HasSubstr("<pre>@misc{a}</pre>"));
  EXPECT_THAT(html, HasSubstr("2026-01-01"));
  content.claims = errors_table();
  content.errata = errors_table();
  content.errata->id = "paper/errata";
  content.changes = errors_table();
  content.changes->id = "comparison/changes";
  content.parameters = {errors_table()};
  content.headline.verdicts = {{ClaimVerdict::holds, 2}};
  const std::string whole = page(content);
  EXPECT_THAT(whole, HasSubstr("<a class=\"skip\" href=\"#claims\">"));  // the paper's claims lead
  std::size_t place = 0;
  for (const char* id :
       {"claims", "changes", "chapter-1", "chapter-2", "errata", "assumptions", "provenance"}) {
    const std::size_t found = whole.find(std::string("<li><a href=\"#") + id + "\">");
    ASSERT_NE(found, std::string::npos) << id;
    EXPECT_GT(found, place) << id;
    place = found;
    EXPECT_NE(section_of(whole, id), "") << id;
  }
  EXPECT_THAT(
      section_of(whole, "assumptions"),
      HasSubstr("<li><strong>Error</strong> <span>(2 takes, simulated)</span> <small>2 rows</small> <a "
                "href=\"tables/table3/errors.csv\">CSV</a></li>\n"));
}

TEST(Page, TheFirstScreenAnswersWarnsAndCounts) {
  ReportContent content;
  content.chapters = {chapter_of("walks")};
  Headline& headline = content.headline;
  headline.origin = "Recorded data";
  headline.asked = "Which < errs least?";
  headline.answers = {"`mean` does."};
  headline.legend = {"**mean**: of all sensors"};
  std::string html = page(content);
  EXPECT_THAT(html,
              HasSubstr("<p class=\"origin\">Recorded data</p>\n<h1>Which &lt; errs least?</h1>\n"
                        "<ul class=\"answers\">\n<li><code>mean</code> does.</li>\n</ul>\n"
                        "<ul class=\"legend\">\n<li><strong>mean</strong>: of all sensors</li>\n</ul>\n"));
  EXPECT_THAT(html, Not(HasSubstr("class=\"tally\"")));
  EXPECT_THAT(html, Not(HasSubstr("class=\"warnings\"")));
  EXPECT_THAT(html, Not(HasSubstr("Below: ")));
  EXPECT_THAT(html, Not(HasSubstr("Simulated: ")));
  headline.warnings = {"first"};
  headline.verdicts = {{ClaimVerdict::holds, 3}, {ClaimVerdict::undecided, 1}};
  html = page(content);
  EXPECT_THAT(html,
              HasSubstr("<p class=\"tally\">The paper’s claims: <a href=\"#claims\">3 <span class=\"v "
                        "holds\">holds</span></a> <a href=\"#claims\">1 <span class=\"v "
                        "unsure\">undecided</span></a></p>\n<p class=\"warnings\">1 warning: first</p>"));
  EXPECT_THAT(html, Not(HasSubstr("<details class=\"plain\" id=\"warnings\">")));
  headline.warnings.push_back("second");
  content.chapters[0].simulated = true;
  content.chapters[0].tables = {errors_table()};
  html = page(content);
  EXPECT_THAT(html, HasSubstr("<a href=\"#warnings\">2 warnings, the first</a>: first</p>"));
  EXPECT_THAT(html, HasSubstr("<summary>All 2 warnings</summary>\n<ul class=\"warnings\">\n<li>first</li>"));
  EXPECT_THAT(html, HasSubstr("to have, by default as measured on real people. Below: 1 table; each study"));
  content.chapters[0].tables.push_back(errors_table());
  EXPECT_THAT(page(content), HasSubstr("Below: 2 tables; "));
}

TEST(Page, FiguresStandOnTheFirstScreenInTheirChapterOrAsLinks) {
  ReportContent content;
  content.chapters = {chapter_of("walks")};
  std::vector<DrawnFigure>& figures = content.chapters[0].figures;
  figures = {drawn_figure("one", true), drawn_figure("two", true), drawn_figure("three", false),
             drawn_figure("four", false)};
  figures[0].in_headline = true;
  figures[0].narrow_svg = "<svg narrow/>";
  figures[1].figure.width = FigureWidth::column;
  figures[3].svg.clear();
  const std::string html = page(content), chapter = section_of(html, "chapter-1");
  EXPECT_THAT(html, HasSubstr("<div class=\"first\">\n<figure class=\"stacks\" id=\"figure-one\">"));
  EXPECT_THAT(html, HasSubstr("<img class=\"narrow\" alt=\"Errors of one\" loading=\"lazy\" src='"
                              "data:image/svg+xml,<svg narrow/>'>"));
  EXPECT_THAT(chapter, Not(HasSubstr("figure-one")));
  EXPECT_THAT(chapter,
              HasSubstr("<figure class=\"column\" id=\"figure-two\">\n<div class=\"pan\" tabindex=\"0\" "
                        "role=\"group\" aria-label=\"Errors of two\"><img alt=\"Errors of two\" "
                        "loading=\"lazy\" src='data:image/svg+xml,<svg/>'></div>\n<figcaption><strong>Errors "
                        "of two.</strong> A caption. <a href=\"figures/two.svg\">SVG</a> <a "
                        "href=\"figures/two.pdf\">PDF</a> <a href=\"figures/two.csv\">CSV</a></figcaption>"));
  EXPECT_THAT(
      chapter,
      HasSubstr("<summary>2 more tables and figures of this study</summary>\n<ul>\n<li>Errors of three "
                "<a href=\"figures/three.svg\">SVG</a> <a href=\"figures/three.pdf\">PDF</a> <a "
                "href=\"figures/three.csv\">CSV</a></li>\n<li>Errors of four <a "
                "href=\"figures/four.csv\">CSV</a></li>\n"));
  figures[1].svg.clear();
  EXPECT_THAT(section_of(page(content), "chapter-1"),
              HasSubstr("<p id=\"figure-two\"><strong>Errors of two.</strong> A caption. <a "
                        "href=\"figures/two.csv\">CSV</a></p>\n"));
  content.headline.history = drawn_figure("history", true);
  EXPECT_THAT(page(content), HasSubstr("id=\"figure-history\""));
}

TEST(Page, AChapterSaysWhatTheFirstScreenDoesNot) {
  ReportContent content;
  content.chapters = {chapter_of("walks")};
  Chapter& chapter = content.chapters[0];
  chapter.sentences = {"On the first screen.", "More."};
  chapter.warnings = {"Beware."};
  content.headline.answers = {"On the first screen."};
  std::string html = section_of(page(content), "chapter-1");
  EXPECT_THAT(html, HasSubstr("<h2>walks on lab</h2>\n<p class=\"about\">Two takes.</p>\n<p>More.</p>\n<p "
                              "class=\"soft\"><a href=\"#made-walks\">Commands and inputs</a></p>\n"));
  content.chapters.push_back(chapter_of("swings"));
  html = section_of(page(content), "chapter-1");
  EXPECT_THAT(html,
              HasSubstr("<p>On the first screen.</p>\n<p>More.</p>\n<ul class=\"warnings\">\n<li>Beware."));
}

TEST(Page, ClaimsStandBeforeTheFirstTableTheyRestOn) {
  ReportContent content;
  content.chapters = {chapter_of("walks")};
  std::vector<Table>& tables = content.chapters[0].tables;
  tables = {errors_table(), errors_table(), errors_table()};
  for (std::size_t t = 0; t < tables.size(); ++t) {
    tables[t].id = "t" + std::to_string(t);
    tables[t].printed = "table3";
  }
  tables[2].shown = Table::Placement::detail;
  tables[2].rows_in = "rows.csv";
  const auto judged = [](const char* claim, const char* where, ClaimVerdict verdict) {
    JudgedClaim judged_claim;
    judged_claim.claim = claim;
    judged_claim.where = where;
    judged_claim.verdict = verdict;
    return judged_claim;
  };
  PaperFindings findings;
  findings.claims = {judged("a", "abstract, Table III", ClaimVerdict::holds), judged("b", "Table I", {}),
                     judged("c", "Table III, text", ClaimVerdict::does_not_hold)};
  content.claims = claims_table(findings);
  const std::string html = section_of(page(content), "chapter-1");
  const std::string claims =
      "<ul class=\"notes\">\n<li>a <span class=\"v holds\">holds</span></li>\n<li>c "
      "<span class=\"v fails\">does not hold</span></li>\n</ul>\n";
  EXPECT_THAT(html, HasSubstr(claims + "<div class=\"table\" id=\"table-t0\">"));
  EXPECT_EQ(html.find(claims), html.rfind(claims));
  EXPECT_THAT(html, HasSubstr("<summary>1 more table or figure of this study</summary>\n<ul>\n<li><strong>"
                              "Error</strong> <span>(2 takes, simulated)</span> <a href=\"tables/t2.csv\">"));
}

TEST(Page, ReplaysThatFitAreThereAndTheOthersNamed) {
  ReportContent content;
  content.chapters = {chapter_of("walks"), chapter_of("swings")};
  content.chapters[0].replays = {{"walks: \"a\"", "{\"x\": \"</script>\"}"}};
  EXPECT_THAT(section_of(page(content), "replay"), HasSubstr("<code>libjs-three</code>"));
  std::string html = section_of(page(content, "three"), "replay");
  EXPECT_THAT(html,
              HasSubstr("class=\"take\" data-title=\"walks: &quot;a&quot;\">{\"x\": \"\\u003c/script>\"}<"));
  EXPECT_THAT(html, HasSubstr("at most 35&nbsp;s of it: the truth"));
  EXPECT_THAT(html, HasSubstr("id=\"three-js\">" + base64_of(deflated("three")) + "</script>"));
  EXPECT_THAT(html, Not(HasSubstr("Left out")));
  content.chapters[0].simulated = true;
  EXPECT_THAT(section_of(page(content, "three"), "replay"),
              HasSubstr("at most 35&nbsp;s of it, <strong>simulated</strong>: the truth"));
  content.chapters[0].simulated = false;
  content.chapters[1].simulated = true;
  content.chapters[1].replays = {
      {"large", std::string(1'950'000, ' ')}, {"larger", std::string(1'960'000, ' ')}, {"small", "{}"}};
  html = section_of(page(content, "three"), "replay");
  EXPECT_THAT(html, HasSubstr("<p class=\"soft\">Left out, to keep the page small: large; larger.</p>\n"));
  EXPECT_THAT(html, HasSubstr("data-title=\"small\""));
  EXPECT_THAT(html, HasSubstr("<strong>simulated</strong>"));
  content.chapters[1].replays.resize(1);  // what is left out is not said to be simulated
  EXPECT_THAT(section_of(page(content, "three"), "replay"), Not(HasSubstr("<strong>simulated</strong>")));
}

TEST(Page, ProvenanceListsWhatWentIn) {
  ReportContent content;
  content.chapters = {chapter_of("my walks")};
  std::string html = section_of(page(content), "provenance");
  EXPECT_THAT(html,
              HasSubstr("<h3 id=\"made-my-walks\">my walks</h3>\n<dl class=\"facts\">\n<dt>study</dt><dd>"
                        "walks (accuracy)</dd>\n<dt>campaign</dt><dd>lab</dd>\n<dt>sensors</dt><dd>k1, "
                        "k2</dd>\n<dt>program</dt><dd>trilat 0.5.0</dd>\n<dt>seed</dt><dd>7</dd>\n<dt>"
                        "computed in</dt><dd>2.5 s</dd>\n</dl>\n<pre>trilat run "
                        "studies/my-walks.json --campaign CAMPAIGN -o my-walks\ntrilat report my-walks "
                        "-o report</pre>\n<p class=\"soft\">CAMPAIGN: the folder of “lab”"));
  EXPECT_THAT(html, HasSubstr("<summary>SHA-256 of the 2 input files</summary>"));
  EXPECT_THAT(html, HasSubstr("<tr><th scope=\"row\">t1</th><td>session</td><td>t1.h5</td><td><code>ab12"));
  EXPECT_THAT(html, HasSubstr("<td>t2.csv</td><td><code>could not be read</code></td></tr>\n"));
  EXPECT_THAT(
      html, HasSubstr("Resolved configuration (<code>studies/my-walks.json</code>)</summary><pre>{}</pre>"));
  content.chapters[0].provenance.inputs.clear();
  content.chapters[0].provenance.kind = StudyKind::threshold_sweep;
  html = section_of(page(content), "provenance");
  EXPECT_THAT(html, Not(HasSubstr("input files")));
  EXPECT_THAT(html, Not(HasSubstr("CAMPAIGN")));
  content.chapters[0].provenance.config.clear();
  html = section_of(page(content), "provenance");
  EXPECT_THAT(html, HasSubstr("There is no manifest.json in this folder"));
  EXPECT_THAT(html, Not(HasSubstr("trilat run")));
}

TEST(Provenance, CommandsMakeTheResultsAgain) {
  Provenance made = made_of("cmp");
  made.calibration = "rig.json";
  EXPECT_EQ(commands_of(made),
            "trilat run studies/cmp.json --campaign CAMPAIGN --calibration rig.json -o cmp\n"
            "trilat report cmp -o report");
  made.kind = StudyKind::threshold_sweep;
  made.calibration.clear();
  EXPECT_EQ(commands_of(made), "trilat run studies/cmp.json -o cmp\ntrilat report cmp -o report");
  made.is_compared = true;
  made.inputs = {
      {"t", "mocap", "truth.csv", {}}, {"t", "mapping", "m.json", {}}, {"t", "joints", "own.csv", {}}};
  EXPECT_EQ(commands_of(made),
            "trilat compare truth.csv own.csv --mapping m.json -o cmp\ntrilat report cmp -o report");
}

}  // namespace
}  // namespace trilat
