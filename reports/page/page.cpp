// SPDX-License-Identifier: MIT
#include "reports/page/page.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "datasets/base/version.h"
#include "reports/page/embedded_page.h"
#include "reports/page/html.h"

namespace trilat {
namespace {

// Of all replays, so that the page stays below 3 MB.
constexpr std::size_t kMostBytes = 700'000;

// JSON in a script element: no "<" may end it.
std::string script_json(const std::string& json) {
  std::string text;
  for (char c : json) text += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return text;
}

std::string replay_data_html(const PackedReplay& replay) {
  return fmt::format(
      "<script type=\"application/json\" class=\"replay-head\" data-title=\"{}\">{}</script>\n<script "
      "type=\"text/plain\" class=\"replay-bytes\">{}</script>\n",
      html_text(replay.title), script_json(replay.header), base64_of(replay.bytes));
}

// The takes in 3-D, or one line that says why there are none. `three_js` is the library; empty: it was not
// found.
PageSection replay_section(const ReportContent& content, const std::string& three_js) {
  PageSection section{"replay", "Replay in 3-D", {}};
  std::string data, left_out;
  std::size_t bytes = 0;
  bool simulated = false;
  for (const Chapter& chapter : content.chapters)
    for (const PackedReplay& replay : chapter.replays) {
      if (bytes + replay.bytes.size() > kMostBytes) {
        left_out += (left_out.empty() ? "" : "; ") + replay.title;
        continue;
      }
      bytes += replay.bytes.size();
      simulated |= chapter.simulated;
      data += replay_data_html(replay);
    }
  if (data.empty()) {
    section.html =
        "<p>There is no replay: none of the results has one, which <code>trilat run</code> writes "
        "for studies of kind accuracy.</p>\n";
    return section;
  }
  if (three_js.empty()) {
    section.html =
        "<p>There is no replay: three.js was not found. Install the Debian package <code>libjs-three</code> "
        "and write the report again.</p>\n";
    return section;
  }
  section.html = fmt::format(
      "<p>The first take of each condition, at most 35&nbsp;s of it{}: what every sensor’s body tracker gave "
      "(thin, faint where a joint is inferred), each method’s estimate, the truth (thick), and lines from "
      "truth to estimate coloured by their length. Positions are as estimated, before any alignment, to a "
      "millimetre.</p>\n",
      simulated ? ", <strong>simulated</strong>" : "");
  if (!left_out.empty())
    section.html += "<p class=\"soft\">Left out, to keep the page small: " + html_text(left_out) + ".</p>\n";
  section.html +=
      "<div class=\"replay\" id=\"replay-view\"><p class=\"soft\">The replay needs a browser with JavaScript "
      "and WebGL.</p></div>\n" +
      data + "<script type=\"text/plain\" id=\"three-js\">" + base64_of(deflated(three_js)) +
      "</script>\n<script>\n" + embedded::replay_js + "</script>\n";
  return section;
}

constexpr const char* kTitle = "Trilateration accuracy";

// Forbids the page to load anything but pictures that lie beside it.
constexpr const char* kPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: 'self' file:";

std::string head_html(const ReportContent& content) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<meta http-equiv=\"Content-Security-Policy\" "
      "content=\"{}\">\n<meta name=\"generator\" content=\"{}\">\n<link rel=\"icon\" href=\"data:,\">\n"
      "<title>{} – {}</title>\n<style>\n{}</style>\n<script>document.documentElement.dataset.theme = "
      "matchMedia(\"(prefers-color-scheme: dark)\").matches ? \"dark\" : \"light\";</script>\n</head>\n",
      kPolicy, kProgramVersion, kTitle, html_text(content.headline.origin), embedded::page_css);
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

std::string verdicts_html(const Headline& headline) {
  if (headline.verdicts.empty()) return {};
  std::string html = "<p class=\"tally\">The paper’s claims:";
  for (const auto& [verdict, count] : headline.verdicts)
    html += fmt::format(" <a href=\"#claims\">{} {}</a>", count, verdict_badge(verdict));
  return html + "</p>\n";
}

// The first screen: what was asked, what was found, on which data, and where to go on.
std::string lead_html(const ReportContent& content) {
  const Headline& headline = content.headline;
  std::string html = fmt::format("<header>\n<p class=\"origin\">{}</p>\n<h1>{}</h1>\n",
                                 html_text(headline.origin), html_text(headline.asked));
  html += html_list("answers", headline.answers) + verdicts_html(headline) +
          html_list("warnings", headline.warnings);
  if (headline.history) html += figure_html(*headline.history);
  std::string figures;
  for (const Chapter& chapter : content.chapters)
    for (const DrawnFigure& drawn : chapter.figures)
      if (drawn.in_headline) figures += figure_html(drawn);
  if (!figures.empty()) html += "<div class=\"first\">\n" + figures + "</div>\n";
  html += "<p class=\"soft\">";
  for (const Chapter& chapter : content.chapters)
    if (chapter.simulated) {
      html +=
          "Simulated: no camera was used; a number says what follows from the errors that sensors and body "
          "tracker are declared to have, by default as measured on real people. ";
      break;
    }
  return html + fmt::format("Below: {} tables; each study lists its others, one CSV each.</p>\n</header>\n",
                            std::ranges::count(content.tables(), Table::Shown::first, &Table::shown));
}

std::string citation_html(const std::string& citation) {
  return "<p>Every table is a CSV and a LaTeX file of its own, every figure an SVG, a PDF and a CSV; their "
         "names "
         "stand under them.</p>\n<pre>" +
         html_text(citation) + "</pre>\n";
}

std::string document(const ReportContent& content, const PageOptions& options,
                     std::vector<PageSection> sections, const std::string& lead) {
  std::erase_if(sections, [](const PageSection& section) { return section.html.empty(); });
  std::string html = head_html(content) + "<body>\n<a class=\"skip\" href=\"#" + sections.front().id +
                     "\">To the content</a>\n<div class=\"frame\">\n" + contents_html(sections) + "<main>\n" +
                     lead;
  for (const PageSection& section : sections)
    html += fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", section.id,
                        html_text(section.name), section.html);
  html += fmt::format("<footer>Made by {}, {}.</footer>\n</main>\n</div>\n<script>\n{}</script>\n",
                      kProgramVersion, html_text(options.made), embedded::page_js);
  return html + "</body>\n</html>\n";
}

}  // namespace

std::string page_of(const ReportContent& content, const PageOptions& options) {
  std::vector<PageSection> sections;
  if (content.changes) sections.push_back({"changes", "What changed", html_of(*content.changes, {})});
  for (PageSection& section : chapter_sections(content)) sections.push_back(std::move(section));
  // what the reader's own studies found comes before somebody else's paper
  sections.insert(content.headline.verdicts.empty() ? sections.end() : sections.begin(),
                  claims_section(content));
  sections.push_back(errata_section(content));
  sections.push_back(assumptions_section(content));
  sections.push_back(replay_section(content, options.three_js));
  sections.push_back(provenance_section(content));
  sections.push_back({"article", "For an article", citation_html(options.citation)});
  return document(content, options, std::move(sections), lead_html(content));
}

}  // namespace trilat
