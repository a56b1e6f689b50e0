// SPDX-License-Identifier: MIT
#include "reports/page/page.h"

#include <gmock/gmock.h>

#include "reports/page/html.h"
#include "reports/tables.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// One row a method, with an interval, a mark and what the paper prints.
Table errors_table() {
  Table table;
  table.id = "table3/errors";
  table.title = "Error";
  table.about = "2 takes, simulated";
  table.columns = {{"method", "method", true},
                   interval_column("head (cm)", "head_mae_cm"),
                   interval_column("average (cm)", "average_mae_cm")};
  const auto row = [&](const char* method, double cm) {
    table.rows.push_back({TableValue::of(method), {cm, 1, {}, cm - 1.0, cm + 1.0}, TableValue::of(cm, 2)});
  };
  row("linear", 5.0);
  row("mean", 4.0);
  table.rows[0][1].mark = TableValue::Mark::not_distinguished;
  table.rows[1][1].mark = TableValue::Mark::best;
  table.rows[0][2].beside = "paper 8.7";
  table.notes = {"Of a < b."};
  table.shown = Table::Placement::first;
  return table;
}

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

Provenance made_of(const std::string& folder) {
  Provenance made;
  made.folder = folder;
  made.study = "walks";
  made.program = "trilat 0.5.0";
  made.campaign = "lab";
  made.seed = "7";
  made.rig = {"k1", "k2"};
  made.wall_s = "2.5";
  made.config = "{}";
  made.inputs = {{"t1", "session", "t1.h5", "ab12"}, {"t2", "mocap", "t2.csv", std::nullopt}};
  return made;
}

Chapter chapter_of(const std::string& folder) {
  Chapter chapter;
  chapter.provenance = made_of(folder);
  chapter.asked = "Which method errs least?";
  chapter.title = folder + " on lab";
  chapter.about = "Two takes.";
  chapter.simulated = false;
  return chapter;
}

DrawnFigure drawn_figure(const std::string& id, bool is_first) {
  DrawnFigure drawn;
  drawn.figure = {
      .id = id, .title = "Errors of " + id, .caption = "A caption.", .x_label = "", .y_label = ""};
  drawn.figure.is_first = is_first;
  drawn.svg = "<svg/>";
  drawn.pdf = "%PDF";
  return drawn;
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

TEST(Headline, OfOneStudyGivesItsQuestionAndFourAnswers) {
  ReportContent content;
  content.chapters = {chapter_of("walks")};
  Chapter& chapter = content.chapters[0];
  chapter.findings = {"1", "2", "3", "4", "5", "6"};
  chapter.sentences = {"not this"};
  chapter.warnings = {"w"};
  chapter.legend = {"a method"};
  chapter.figures = {drawn_figure("detail", false), drawn_figure("first", true)};
  const Headline headline = headline_of(content, {}, {});
  EXPECT_EQ(headline.origin, "Recorded data");
  EXPECT_EQ(headline.asked, "Which method errs least?");
  EXPECT_THAT(headline.answers, ElementsAre("1", "2", "3", "4", "And 2 more, in the studies below."));
  EXPECT_THAT(headline.warnings, ElementsAre("w"));
  EXPECT_THAT(headline.legend, ElementsAre("a method"));
  EXPECT_FALSE(chapter.figures[0].in_headline);
  EXPECT_TRUE(chapter.figures[1].in_headline);
  EXPECT_EQ(headline_text(headline),
            "Which method errs least? Recorded data.\n  - 1\n  - 2\n  - 3\n  - 4\n  - And "
            "2 more, in the studies below.\n  - 1 warning: w\n");
}

TEST(Headline, OfSeveralStudiesNamesThemAndSaysAWarningOnce) {
  ReportContent content;
  content.chapters = {chapter_of("walks"), chapter_of("swings")};
  content.chapters[0].sentences = {"s"};
  content.chapters[0].warnings = {"both", "one"};
  content.chapters[1].warnings = {"both"};
  content.chapters[1].simulated = true;
  Headline headline = headline_of(content, {}, {});
  EXPECT_EQ(headline.origin, "Simulated and recorded data");
  EXPECT_EQ(headline.asked, "Which method errs least?");
  EXPECT_THAT(headline.answers, ElementsAre("walks: s"));
  EXPECT_THAT(headline.warnings, ElementsAre("walks, swings: both", "walks: one"));
  EXPECT_THAT(headline_text(headline), HasSubstr("  - 2 warnings, the first: walks, swings: both\n"));
  content.chapters[0].simulated = true;
  content.chapters[1].asked = "Another?";
  headline = headline_of(content, {}, {});
  EXPECT_EQ(headline.origin, "Simulated data");
  EXPECT_EQ(headline.asked, "What did the studies find?");
}

TEST(Headline, BesideThePaperItsWalkingStudyAnswers) {
  ReportContent content;
  content.chapters = {chapter_of("other"), chapter_of("walks")};
  content.chapters[0].on_the_paper = {"not this"};
  content.chapters[0].figures = {drawn_figure("other", true)};
  Chapter& walks = content.chapters[1];
  walks.paper = "table3";
  walks.on_the_paper = {"No."};
  walks.figures = {drawn_figure("curves", true), drawn_figure("rows", true)};
  walks.figures[1].figure.y_names = {"mean"};
  PaperFindings paper;
  paper.claims.resize(3);
  paper.claims[1].verdict = ClaimVerdict::holds;
  const Headline headline = headline_of(content, paper, {});
  EXPECT_THAT(headline.asked, HasSubstr("better than the plain mean of them?"));
  EXPECT_THAT(headline.answers, ElementsAre("No."));
  EXPECT_THAT(headline.verdicts, ElementsAre(std::pair{ClaimVerdict::holds, std::size_t{1}},
                                             std::pair{ClaimVerdict::cannot_test, std::size_t{2}}));
  EXPECT_TRUE(walks.figures[1].in_headline);
  EXPECT_FALSE(walks.figures[0].in_headline);
  EXPECT_FALSE(content.chapters[0].figures[0].in_headline);
  EXPECT_THAT(headline_text(headline),
              HasSubstr("  - The paper's claims: holds 1, cannot be tested here 2.\n"));
  walks.simulated = true;
  EXPECT_THAT(headline_of(content, paper, {}).answers.back(),
              HasSubstr("No. Recorded, for comparison: one real Kinect v2 against motion capture"));
  walks.on_the_paper.clear();
  EXPECT_EQ(headline_of(content, paper, {}).asked, "Which method errs least?");
}

ErrorChanges two_changes() {
  const ErrorChange small{.condition = "walking",
                          .group = "average",
                          .method = "mean",
                          .before_m = 0.05,
                          .after_m = 0.09,
                          .difference_m = 0.04,
                          .low_m = -0.01,
                          .high_m = 0.09};
  ErrorChange better = small, worse = small, larger = small;
  better.difference_m = -0.01;
  better.low_m = -0.02;
  better.high_m = -0.005;
  worse.method = "linear";
  worse.difference_m = 0.02;
  worse.low_m = 0.01;
  worse.high_m = 0.03;
  larger.difference_m = 0.05;
  return {
      .before = "a", .after = "b", .paired = true, .participants = 3, .rows = {small, better, larger, worse}};
}

TEST(Changes, RealOnesStandFirstTheLargestAtTheTop) {
  const Table table = changes_table(two_changes());
  std::vector<std::string> differs;
  for (const auto& row : table.rows) differs.push_back(printed(row[4]) + " " + row[5].text);
  EXPECT_THAT(differs, ElementsAre("2.00 worse", "-1.00 better", "5.00 no", "4.00 no"));
  EXPECT_EQ(table.rows[0][5].mark, TableValue::Mark::bad);
  EXPECT_EQ(table.rows[1][5].mark, TableValue::Mark::good);
  EXPECT_EQ(table.rows[2][5].mark, TableValue::Mark::none);
  EXPECT_EQ(table.title, "What changed from a to b: mean error in cm (3 participants, the same in both)");
  EXPECT_THAT(
      changes_sentences(two_changes()),
      ElementsAre("From `a` to `b` the mean error of **2 of 4** methods and conditions changed beyond its "
                  "interval.",
                  "`linear`, walking: +2.00 cm (+1.00 to +3.00), from 5.00 to 9.00.",
                  "`mean`, walking: -1.00 cm (-2.00 to -0.50), from 5.00 to 9.00."));
  ReportContent content;
  content.chapters = {chapter_of("a"), chapter_of("b")};
  content.chapters[1].figures = {drawn_figure("f", true)};
  const Headline headline = headline_of(content, {}, two_changes());
  EXPECT_EQ(headline.asked, "What changed, by how much, and is it real?");
  EXPECT_EQ(headline.answers.size(), 3u);
  EXPECT_TRUE(content.chapters[1].figures[0].in_headline);
}

TEST(Claims, NumbersHaveAsManyDigitsAsTheyNeed) {
  const auto text = [](double value, double low = kNaN, double high = kNaN, double compared = 1.0) {
    return numbers_text(
        {{.what = "w", .unit = "%", .value = value, .low = low, .high = high, .compared = compared}});
  };
  EXPECT_EQ(text(9.994), "w: 9.99 %");
  EXPECT_EQ(text(-12.34, -13, -11), "w: -12.3 % (-13.0 to -11.0)");
  EXPECT_EQ(text(99.5), "w: 99.500 %");  // near all, where a digit less would say 100
  EXPECT_EQ(text(123.4), "w: 123 %");
  EXPECT_EQ(text(kNaN), "w: no answer");
  EXPECT_EQ(text(1.0, 0.5, 1.5, 0.994), "w: 1.00 % (0.50 to 1.50), where both answer (99 % of the samples)");
  EXPECT_EQ(text(1.0, 0.5, 1.5, 0.996), "w: 1.00 % (0.50 to 1.50)");
  EXPECT_EQ(numbers_text({}), "–");
}

TEST(Claims, TheTableGivesVerdictNumbersAndRule) {
  PaperFindings findings;
  findings.claims = {
      {.id = "a",
       .where = "abstract",
       .claim = "better",
       .printed = "8.7 cm",
       .reason = "half a step",
       .numbers = {{.what = "x",
                    .unit = "cm",
                    .value = 4.0,
                    .low = 3.0,
                    .high = 5.0,
                    .over = "participants",
                    .compared = 1.0,
                    .bound = "more than 1 %"},
                   {.what = "y", .unit = "cm", .value = 2.0, .compared = 1.0, .bound = "more than 1 %"}},
       .p = 0.00005,
       .verdict = ClaimVerdict::does_not_hold},
      {.id = "n",
       .where = "",
       .claim = "none",
       .printed = "-",
       .reason = "nothing printed",
       .numbers = {},
       .p = 0.25}};
  const Table table = claims_table(findings);
  std::vector<std::string> cells;
  for (const auto& row : table.rows)
    for (const TableValue& value : row) cells.push_back(value.text);
  EXPECT_THAT(cells,
              ElementsAre("better", "does not hold", "8.7 cm", "x: 4.00 cm; y: 2.00 cm",
                          "x: 4.00 cm (3.00 to 5.00); y: 2.00 cm",
                          "more than 1 %: half a step; over participants", "< 0.0001", "abstract", "none",
                          "cannot be tested here", "-", "–", "–", "nothing printed", "0.2500", ""));
  EXPECT_EQ(table.rows[0][1].mark, TableValue::Mark::bad);
  EXPECT_EQ(table.first_columns, 4u);
  EXPECT_EQ(table.title, "The paper's claims and what becomes of them");
  EXPECT_THAT(errata_table(findings).about, IsEmpty());
  findings.evidence.any_simulated = true;
  EXPECT_EQ(claims_table(findings).title,
            "The paper's claims and what becomes of them, with simulated sensors");
  EXPECT_GT(claims_table(findings).notes.size(), table.notes.size());
  findings.evidence.errata["E1"] = "stored";
  findings.errata["E1"] = {{.what = "x", .unit = "cm", .value = 4.0, .compared = 1.0}};
  EXPECT_EQ(errata_table(findings).rows[0][5].text, "stored; x: 4.00 cm");
  EXPECT_EQ(errata_table(findings).about, "simulated");
}

TEST(Claims, WhatThePaperPrintsStandsBesideItsTableAndItsFigure) {
  Table table = errors_table();
  table.columns[1].key = "head_mae_cm";
  add_printed(table, true);
  EXPECT_EQ(table.title, "Error");  // it is not the paper's
  table.printed = "table3";
  table.rows[0][0].text = "nonlinear";
  Table recorded = table;
  add_printed(table, true);
  add_printed(recorded, false);
  EXPECT_EQ(table.title, "Table III: Error");
  EXPECT_THAT(table.rows[0][1].beside, testing::StartsWith("paper "));
  EXPECT_EQ(table.rows[1][1].beside, "");  // the paper has no mean
  EXPECT_EQ(table.rows[0][0].beside, "");
  EXPECT_GT(table.notes.size(), recorded.notes.size());
  Figure figure{.id = "f", .title = "t", .caption = "c", .x_label = "x", .y_label = "y"};
  add_printed(figure);
  EXPECT_EQ(figure.title, "t");
  figure.printed = "table3";
  figure.panels = {"head", "knee"};
  figure.y_names = {"mean", "nonlinear"};
  add_printed(figure);
  ASSERT_EQ(figure.series.size(), 1u);
  EXPECT_TRUE(figure.series[0].hollow);
  EXPECT_EQ(figure.series[0].panel, 0u);
  ASSERT_EQ(figure.series[0].points.size(), 1u);
  EXPECT_EQ(figure.series[0].points[0].y, 1.0);
  EXPECT_EQ("paper " + printed(TableValue::of(figure.series[0].points[0].x, 1)), table.rows[0][1].beside);
  EXPECT_EQ(figure.title, "t, the paper's beside ours");
}

TEST(Parameters, NoteTheirOriginUnlessTheSimulationSetSome) {
  std::vector<SimulationAssumption> parameters{{.name = "n", .value = "1", .unit = "m", .source = "a paper"}};
  Table table = parameters_table(parameters, "table3");
  EXPECT_EQ(table.title, "What the simulation behind table3 assumes, with sources");
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0][3].text, "a paper");
  EXPECT_FALSE(table.notes.empty());
  parameters.push_back({.name = "m", .value = "2", .unit = "", .source = kSetInTheSimulation});
  EXPECT_TRUE(parameters_table(parameters, "table3").notes.empty());
}

}  // namespace
}  // namespace trilat
