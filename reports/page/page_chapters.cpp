// SPDX-License-Identifier: MIT
// Everything below the first screen.
#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "reports/page/html.h"
#include "reports/page/page.h"

namespace trilat {
namespace {

std::size_t column_of(const Table& table, const std::string& key) {
  const auto found = std::ranges::find(table.columns, key, &TableColumn::key);
  return static_cast<std::size_t>(found - table.columns.begin());
}

// The part of the paper that belongs to a table, as its claims name it.
std::string place_in_paper(const Table& table) {
  static const std::map<std::string, std::string> kPlaces{{"table1", "Table I"},
                                                          {"table2", "Table II"},
                                                          {"table3", "Table III"},
                                                          {"table4", "Table IV"},
                                                          {"calibration", "Calibration"}};
  const auto found = kPlaces.find(table.printed);
  return found == kPlaces.end() ? std::string() : found->second;
}

// Whether "abstract, Table III" names a place.
bool names(const std::string& places, const std::string& place) {
  const std::string all = ", " + places + ",";
  return !place.empty() && all.find(", " + place + ",") != std::string::npos;
}

std::string claims_on(const std::optional<Table>& claims, const std::string& place) {
  std::string html;
  if (!claims) return html;
  const std::size_t where = column_of(*claims, "where"), verdict = column_of(*claims, "verdict");
  for (const auto& row : claims->rows)
    if (names(row[where].text, place))
      html += fmt::format("<li>{} {}</li>\n", html_text(row.front().text),
                          verdict_badge(row[verdict].text, row[verdict].mark));
  return html.empty() ? html : "<ul class=\"notes\">\n" + html + "</ul>\n";
}

// One line with the file of a table or figure that the page does not show.
std::string table_link(const Table& table) {
  const std::string id = html_text(table.id);
  const std::string rows =
      table.rows_in.empty() ? fmt::format(" <small>{} rows</small>", table.rows.size()) : std::string();
  return fmt::format("<li>{}{} <a href=\"tables/{}.csv\">CSV</a></li>\n", html_title(table), rows, id);
}

std::string figure_link(const DrawnFigure& drawn) {
  const Figure& figure = drawn.figure;
  const std::string id = html_text(figure.id);
  if (!drawn.is_drawn())
    return fmt::format("<li>{0} <a href=\"figures/{1}.csv\">CSV</a></li>\n", html_text(figure.title), id);
  return fmt::format(
      "<li>{0} <a href=\"figures/{1}.svg\">SVG</a> <a href=\"figures/{1}.pdf\">PDF</a> <a "
      "href=\"figures/{1}.csv\">CSV</a></li>\n",
      html_text(figure.title), id);
}

std::string folded(std::size_t count, const std::string& lines) {
  if (count == 0) return {};
  return fmt::format(
      "<details class=\"plain\"><summary>{} of this study</summary>\n<ul>\n{}</ul>\n</details>\n",
      count == 1 ? "1 more table or figure" : fmt::format("{} more tables and figures", count), lines);
}

std::string chapter_id(std::size_t number) { return fmt::format("chapter-{}", number + 1); }

std::string chapter_html(const ReportContent& content, const Chapter& chapter) {
  std::string html = "<p class=\"about\">" + html_sentence(chapter.about) + "</p>\n";
  const bool is_alone = content.chapters.size() == 1;  // the first screen has its findings and warnings
  for (const std::string& sentence : chapter.sentences)
    if (!is_alone || std::ranges::find(content.headline.answers, sentence) == content.headline.answers.end())
      html += "<p>" + html_sentence(sentence) + "</p>\n";
  if (!is_alone) html += html_list("warnings", chapter.warnings);
  std::set<std::string> judged;
  std::size_t others = 0;
  std::string links;
  const auto add = [&](const std::string& link) {
    links += link;
    ++others;
  };
  for (const Table& table : chapter.tables) {
    if (table.shown != Table::Placement::first) {
      add(table_link(table));
      continue;
    }
    if (const std::string place = place_in_paper(table); judged.insert(place).second)
      html += claims_on(content.claims, place);
    html += html_of(table);
  }
  for (const DrawnFigure& drawn : chapter.figures)
    if (!drawn.figure.is_first)
      add(figure_link(drawn));
    else if (!drawn.in_headline)
      html += figure_html(drawn);
  html += folded(others, links);
  return html + fmt::format("<p class=\"soft\"><a href=\"#made-{}\">Commands and inputs</a></p>\n",
                            html_text(file_name_from(chapter.provenance.folder)));
}

void add_fact(std::string& html, const char* name, const std::string& value) {
  if (!value.empty()) html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, html_text(value));
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string inputs_html(const Provenance& p) {
  if (p.inputs.empty()) return {};
  std::string rows;
  for (const Manifest::Input& file : p.inputs)
    rows += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td><code>{}</code></td></tr>\n",
                        html_text(file.take), html_text(file.role), html_text(file.file),
                        file.sha256 ? html_text(*file.sha256) : "could not be read");
  return fmt::format(
      "<details class=\"plain\"><summary>SHA-256 of the {} input files</summary>\n<div class=\"scroll\" "
      "tabindex=\"0\" role=\"region\" aria-label=\"Input files\"><table><caption>Input files of "
      "{}</caption><thead><tr><th scope=\"col\">take</th><th scope=\"col\">role</th><th "
      "scope=\"col\">file</th><th "
      "scope=\"col\">SHA-256</th></tr></thead><tbody>\n{}</tbody></table></div></details>\n",
      p.inputs.size(), html_text(p.folder), rows);
}

std::string provenance_html(const Provenance& p) {
  std::string html =
      fmt::format("<h3 id=\"made-{}\">{}</h3>\n", html_text(file_name_from(p.folder)), html_text(p.folder));
  if (p.config.empty())
    html += "<p>There is no manifest.json in this folder: what went into these results is not known.</p>\n";
  std::string facts;
  add_fact(facts, "study", fmt::format("{} ({})", p.study, name_of(p.kind)));
  add_fact(facts, "campaign", p.campaign);
  add_fact(facts, "sensors", joined(p.rig));
  add_fact(facts, "program", p.program);
  add_fact(facts, "seed", p.seed);
  add_fact(facts, "SHA-256 of the study", p.study_sha256);
  add_fact(facts, "processor", p.processor);
  add_fact(facts, "threads", p.threads);
  add_fact(facts, "compiler", p.compiler);
  add_fact(facts, "computed in", p.wall_s.empty() ? "" : p.wall_s + " s");
  html += "<dl class=\"facts\">\n" + facts + "</dl>\n";
  if (p.config.empty()) return html;
  html += "<pre>" + html_text(commands_of(p)) + "</pre>\n";
  if (p.kind == StudyKind::accuracy && !p.is_compared)
    html += fmt::format(
        "<p class=\"soft\">CAMPAIGN: the folder of “{}”, whose files have the hashes below.</p>\n",
        html_text(p.campaign));
  return html + inputs_html(p) + "<details class=\"plain\"><summary>Resolved configuration (<code>" +
         html_text(study_file(p)) + "</code>)</summary><pre>" + html_text(p.config) + "</pre></details>\n";
}

}  // namespace

std::string figure_html(const DrawnFigure& drawn) {
  const Figure& figure = drawn.figure;
  const std::string id = html_text(figure.id), title = html_text(figure.title);
  if (!drawn.is_drawn())
    return fmt::format(
        "<p id=\"figure-{0}\"><strong>{1}.</strong> {2} <a href=\"figures/{0}.csv\">CSV</a></p>\n", id, title,
        html_text(figure.caption));
  return fmt::format(
      "<figure class=\"{4}\" id=\"figure-{0}\">\n<div class=\"pan\" tabindex=\"0\" role=\"group\" "
      "aria-label=\"{1}\"><img alt=\"{1}\" loading=\"lazy\" src='{2}'>{5}</div>\n"
      "<figcaption><strong>{1}.</strong> {3} <a href=\"figures/{0}.svg\">SVG</a> <a "
      "href=\"figures/{0}.pdf\">PDF</a> <a href=\"figures/{0}.csv\">CSV</a></figcaption>\n</figure>\n",
      id, title, svg_source(drawn.svg), html_text(figure.caption),
      figure.width == FigureWidth::column ? "column"
      : drawn.narrow_svg.empty()          ? ""
                                          : "stacks",
      drawn.narrow_svg.empty() ? std::string()
                               : fmt::format("<img class=\"narrow\" alt=\"{}\" loading=\"lazy\" src='{}'>",
                                             title, svg_source(drawn.narrow_svg)));
}

PageSection claims_section(const ReportContent& content) {
  PageSection section{"claims", "The paper’s claims", {}};
  if (content.claims) section.html = html_of(*content.claims);
  return section;
}

PageSection errata_section(const ReportContent& content) {
  PageSection section{"errata", "What the paper prints that cannot be so", {}};
  if (content.errata) section.html = html_of(*content.errata);
  return section;
}

std::vector<PageSection> chapter_sections(const ReportContent& content) {
  std::vector<PageSection> sections;
  for (std::size_t c = 0; c < content.chapters.size(); ++c)
    sections.push_back(
        {chapter_id(c), content.chapters[c].title, chapter_html(content, content.chapters[c])});
  return sections;
}

PageSection assumptions_section(const ReportContent& content) {
  PageSection section{"assumptions", "What the simulations assume", {}};
  std::string links;
  for (const Table& table : content.parameters) links += table_link(table);
  if (!links.empty()) section.html = "<ul>\n" + links + "</ul>\n";
  return section;
}

PageSection provenance_section(const ReportContent& content) {
  PageSection section{"provenance", "Provenance", {}};
  for (const Chapter& chapter : content.chapters) section.html += provenance_html(chapter.provenance);
  return section;
}

}  // namespace trilat
