// SPDX-License-Identifier: MIT
#include "reports/page/page.h"

#include <fmt/format.h>

#include "datasets/base/version.h"
#include "reports/page/embedded_page.h"
#include "reports/page/html_text.h"
#include "reports/page/page_replay.h"
#include "reports/page/page_sections.h"

namespace trilat {
namespace {

constexpr const char* kTitle = "Trilateration accuracy";

// Forbids the page to load anything. Pictures are documents of their own, with scripts of their own.
constexpr const char* kPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; object-src "
    "data:; "
    "frame-src data:";

std::string head_html(const ReportContent& content) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<meta http-equiv=\"Content-Security-Policy\" "
      "content=\"{}\">\n<meta name=\"generator\" content=\"{}\">\n<link rel=\"icon\" href=\"data:,\">\n"
      "<title>{} – {}</title>\n<style>\n{}</style>\n<script>document.documentElement.dataset.theme = "
      "matchMedia(\"(prefers-color-scheme: dark)\").matches ? \"dark\" : \"light\";</script>\n</head>\n",
      kPolicy, kProgramVersion, kTitle, html_text(origin_of(content)), embedded::page_css);
}

std::string contents_html(const std::vector<PageSection>& sections) {
  std::string html = "<nav class=\"contents\" aria-label=\"Contents\">\n<h2>Contents</h2>\n<ol>\n";
  bool in_chapters = false;
  for (const PageSection& section : sections) {
    const bool chapter = section.id.starts_with("chapter-");
    if (chapter && !in_chapters) html += "<li><a href=\"#" + section.id + "\">Studies</a><ol>\n";
    if (!chapter && in_chapters) html += "</ol></li>\n";
    in_chapters = chapter;
    html += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", section.id, html_text(section.name));
  }
  if (in_chapters) html += "</ol></li>\n";
  return html +
         "</ol>\n<p class=\"tools\"><button type=\"button\" class=\"script\" id=\"theme\">Dark "
         "page</button></p>\n"
         "</nav>\n";
}

std::string lead_html(const ReportContent& content) {
  bool simulated = false;
  const std::size_t tables = tables_of(content).size(), figures = figures_of(content).size();
  for (const Chapter& chapter : content.chapters) simulated |= chapter.simulated;
  std::string html = fmt::format("<p class=\"origin\">{}</p>\n<h1>{}</h1>\n<p class=\"lead\">",
                                 html_text(origin_of(content)), kTitle);
  html += fmt::format(
      "How well several Kinect v2 sensors find a person’s joints: {} stud{}, {} tables, {} figures.",
      content.chapters.size(), content.chapters.size() == 1 ? "y" : "ies", tables, figures);
  if (simulated)
    html +=
        " Where it says simulated, no camera was used: a number says what follows from the declared errors "
        "of sensors "
        "and body tracker.";
  return html + "</p>\n";
}

std::string citation_html(const std::string& citation) {
  return "<p>Every number of every table is a LaTeX macro in <a href=\"numbers.tex\">numbers.tex</a>; all "
         "tables are in "
         "<a href=\"report.tex\">report.tex</a>, which compiles as it is, and in <a "
         "href=\"report.md\">report.md</a>.</p>\n"
         "<pre>" +
         html_text(citation) + "</pre>\n";
}

}  // namespace

std::string page_of(const ReportContent& content, const PageOptions& options) {
  std::set<std::string> shown;
  std::vector<PageSection> sections{runs_section(content), claims_section(content),
                                    paper_section(content, shown), audit_section(content)};
  sections.push_back(replay_section(content, options.three_js));
  for (PageSection& section : chapter_sections(content, shown)) sections.push_back(std::move(section));
  sections.push_back(parameters_section(content));
  sections.push_back(provenance_section(content));
  sections.push_back({"article", "For an article", citation_html(options.citation)});
  std::erase_if(sections, [](const PageSection& section) { return section.html.empty(); });
  std::string html = head_html(content) +
                     "<body>\n<a class=\"skip\" href=\"#runs\">To the content</a>\n<div class=\"frame\">\n" +
                     contents_html(sections) + "<main>\n" + lead_html(content);
  for (const PageSection& section : sections)
    html += fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", section.id,
                        html_text(section.name), section.html);
  html += fmt::format("<footer>Made by {}, {}.</footer>\n</main>\n</div>\n<script>\n{}</script>\n",
                      kProgramVersion, html_text(options.made), embedded::page_js);
  return html + "</body>\n</html>\n";
}

}  // namespace trilat
