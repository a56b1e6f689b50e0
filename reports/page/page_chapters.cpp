// SPDX-License-Identifier: MIT
// The chapters of the studies, and what stands behind them.
#include <fmt/format.h>

#include "reports/page/html.h"
#include "reports/page/page.h"

namespace trilat {
namespace {

// A document of its own, so that the scripts of one picture do not see those of another.
std::string figure_html(const DrawnFigure& drawn) {
  const Figure& figure = drawn.figure;
  const std::string id = html_text(figure.id), title = html_text(figure.title);
  return fmt::format(
      "<figure class=\"picture\" id=\"figure-{0}\">\n<div class=\"pan\" tabindex=\"0\" role=\"group\" "
      "aria-label=\"{1}\"><object type=\"image/svg+xml\" "
      "data=\"data:image/svg+xml;base64,{2}\">{1}</object></div>\n"
      "<figcaption>{3} <a href=\"{0}.svg\">SVG</a> <a href=\"{0}.pdf\">PDF</a> <a "
      "href=\"{0}.csv\">CSV</a></figcaption>\n</figure>\n",
      id, title, base64_of(drawn.svg), html_text(figure.caption));
}

std::string folded(const Table& table, const std::string& commands) {
  return fmt::format("<details class=\"fold\"><summary>{} <small>{} rows</small></summary>\n{}</details>\n",
                     html_title(table.title), table.rows.size(), html_of(table, commands));
}

bool has_methods(const Chapter& chapter) {
  for (const Table& table : chapter.tables)
    for (const TableColumn& column : table.columns)
      if (column.key == "method") return true;
  return false;
}

std::string chapter_html(const Chapter& chapter, const std::set<std::string>& shown) {
  std::string html = "<p class=\"about\">" + html_sentence(chapter.about) + "</p>\n";
  for (const std::string& sentence : chapter.sentences) html += "<p>" + html_sentence(sentence) + "</p>\n";
  if (has_methods(chapter)) html += method_panel();
  const std::string commands = commands_of(chapter.provenance);
  std::string details;
  for (std::size_t t = 0; t < chapter.tables.size(); ++t) {
    const Table& table = chapter.tables[t];
    if (shown.contains(table.id))
      html += fmt::format("<p><a href=\"#table-{}\">{}</a> stands above.</p>\n", html_text(table.id),
                          html_text(table.title.substr(0, table.title.find(" ("))));
    else if (t < chapter.first_tables)
      html += html_of(table, commands);
    else
      details += folded(table, commands);
  }
  for (const DrawnFigure& figure : chapter.figures) html += figure_html(figure);
  return details.empty() ? html : html + "<h3>Details</h3>\n" + details;
}

std::string chapter_id(std::size_t number) { return fmt::format("chapter-{}", number + 1); }

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
  Table table;
  table.id = usable_id("inputs-" + p.folder);
  std::string rows;
  for (const InputFile& file : p.inputs)
    rows += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td><code>{}</code></td></tr>\n",
                        html_text(file.take), html_text(file.role), html_text(file.file),
                        file.sha256.empty() ? "could not be read" : html_text(file.sha256));
  return fmt::format(
      "<details class=\"plain\"><summary>SHA-256 of the {} input files</summary>\n<div class=\"scroll\" "
      "tabindex=\"0\" "
      "role=\"region\" aria-label=\"Input files\"><table><caption>Input files of {}</caption><thead><tr><th "
      "scope=\"col\">take</th><th scope=\"col\">role</th><th scope=\"col\">file</th><th "
      "scope=\"col\">SHA-256</th>"
      "</tr></thead><tbody>\n{}</tbody></table></div></details>\n",
      p.inputs.size(), html_text(p.folder), rows);
}

std::string provenance_html(const Provenance& p) {
  std::string html = "<h3>" + html_text(p.folder) + "</h3>\n";
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
  if (p.kind == StudyKind::accuracy)
    html += fmt::format(
        "<p class=\"soft\">CAMPAIGN: the folder of “{}”, whose files have the hashes below.</p>\n",
        html_text(p.campaign));
  return html + inputs_html(p) + "<details class=\"plain\"><summary>Resolved configuration (<code>" +
         html_text(study_file(p)) + "</code>)</summary><pre>" + html_text(p.config) + "</pre></details>\n";
}

}  // namespace

std::string method_panel() {
  return "<details class=\"methods script\"><summary>Methods <small>all "
         "shown</small></summary><fieldset><legend "
         "class=\"soft\">Rows of these methods are shown in the tables of this "
         "section</legend></fieldset></details>\n";
}

std::string origin_of(const ReportContent& content) {
  bool simulated = false, recorded = false;
  for (const Chapter& chapter : content.chapters) (chapter.simulated ? simulated : recorded) = true;
  if (simulated && recorded) return "Simulated and recorded data";
  return simulated ? "Simulated data" : "Recorded data";
}

PageSection runs_section(const ReportContent& content) {
  PageSection section{"runs", "What was run on what", {}};
  for (std::size_t c = 0; c < content.chapters.size(); ++c) {
    const Chapter& chapter = content.chapters[c];
    section.html += fmt::format("<li><a href=\"#{}\">{}</a>: {}</li>\n", chapter_id(c),
                                html_text(chapter.title), html_sentence(chapter.about));
  }
  section.html = "<ul>\n" + section.html + "</ul>\n";
  return section;
}

std::vector<PageSection> chapter_sections(const ReportContent& content, const std::set<std::string>& shown) {
  std::vector<PageSection> sections;
  for (std::size_t c = 0; c < content.chapters.size(); ++c)
    sections.push_back({chapter_id(c), content.chapters[c].title, chapter_html(content.chapters[c], shown)});
  return sections;
}

PageSection parameters_section(const ReportContent& content) {
  PageSection section{"parameters", "What the simulation assumes", {}};
  for (const Table& table : content.parameters) section.html += html_of(table, {});
  return section;
}

PageSection provenance_section(const ReportContent& content) {
  PageSection section{"provenance", "Provenance", {}};
  for (const Chapter& chapter : content.chapters) section.html += provenance_html(chapter.provenance);
  return section;
}

}  // namespace trilat
