// SPDX-License-Identifier: MIT
#include "reports/page/page.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/version.h"
#include "datasets/base/words.h"
#include "reports/page/embedded_page.h"
#include "reports/page/html.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxBytes = 1'950'000;  // of a page; replays that do not fit are left out

// JSON in a script element: no "<" may end it.
std::string script_json(const std::string& json) {
  std::string text;
  for (char c : json) text += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return text;
}

// The takes in 3-D, at most so many bytes; nothing when there are none. `three_js` is the library; empty: it
// was not found.
PageSection replay_section(const ReportContent& content, const std::string& three_js, std::size_t most) {
  PageSection section{"replay", "Replay in 3-D", {}};
  std::string data, left_out;
  bool any = false, simulated = false;
  for (const Chapter& chapter : content.chapters)
    for (const PackedReplay& replay : chapter.replays) {
      any = true;
      if (data.size() + replay.json.size() > most) {
        left_out += (left_out.empty() ? "" : "; ") + replay.title;
        continue;
      }
      simulated |= chapter.simulated;
      data += fmt::format("<script type=\"application/json\" class=\"take\" data-title=\"{}\">{}</script>\n",
                          html_text(replay.title), script_json(replay.json));
    }
  if (!any) return section;
  if (three_js.empty()) {
    section.html =
        "<p>The replay is left out, because three.js was not found. Install the Debian package "
        "<code>libjs-three</code> and write the report again.</p>\n";
    return section;
  }
  if (!left_out.empty())
    left_out = "<p class=\"soft\">Left out, to keep the page small: " + html_text(left_out) + ".</p>\n";
  section.html = fmt::format(
      "<p>The first take of each condition, at most 35&nbsp;s of it{}: the truth and one method’s "
      "estimate, before any alignment.</p>\n{}<div class=\"replay\" "
      "id=\"replay-view\"><p class=\"soft\">The replay needs a browser with JavaScript and "
      "WebGL.</p></div>\n{}<script type=\"text/plain\" id=\"three-js\">{}</script>\n<script>\n{}</script>\n",
      simulated ? ", <strong>simulated</strong>" : "", left_out, data, base64_of(deflated(three_js)),
      embedded::replay_js);
  return section;
}

std::string contents_html(const std::vector<PageSection>& sections) {
  std::string html;
  for (const PageSection& section : sections)
    html += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", section.id, html_text(section.name));
  return html;
}

std::string verdicts_html(const Headline& headline) {
  if (headline.verdicts.empty()) return {};
  std::string html = "<p class=\"tally\">The paper’s claims:";
  for (const auto& [verdict, count] : headline.verdicts)
    html += fmt::format(" <a href=\"#claims\">{} {}</a>", count,
                        verdict_badge(name_of(verdict), mark_of(verdict)));
  return html + "</p>\n";
}

// The first screen: what was asked, what was found, on which data, and where to go on.
std::string lead_html(const ReportContent& content) {
  const Headline& headline = content.headline;
  std::string html = fmt::format("<p class=\"origin\">{}</p>\n<h1>{}</h1>\n", html_text(headline.origin),
                                 html_text(headline.asked));
  html += html_list("answers", headline.answers) + verdicts_html(headline);
  if (const std::size_t count = headline.warnings.size(); count > 0) {
    const std::string said = warnings_text(headline);
    html += fmt::format("<p class=\"warnings\">{}: {}</p>\n",
                        count == 1 ? said : "<a href=\"#warnings\">" + said + "</a>",
                        html_sentence(headline.warnings.front()));
  }
  if (headline.history) html += figure_html(*headline.history);
  std::string figures, more;
  for (const Chapter& chapter : content.chapters)
    for (const DrawnFigure& drawn : chapter.figures)
      if (drawn.in_headline) figures += figure_html(drawn);
  if (!figures.empty()) html += "<div class=\"first\">\n" + figures + "</div>\n";
  html += html_list("legend", headline.legend);
  if (headline.warnings.size() > 1)
    html += fmt::format(
        "<details class=\"plain\" id=\"warnings\"><summary>All {} warnings</summary>\n{}</details>\n",
        headline.warnings.size(), html_list("warnings", headline.warnings));
  if (std::ranges::any_of(content.chapters, &Chapter::simulated))
    more =
        "Simulated: no camera was used; a number says what follows from the errors that sensors and body "
        "tracker are declared to have, by default as measured on real people. ";
  const auto tables = std::ranges::count(content.tables(), Table::Placement::first, &Table::shown);
  if (tables > 0)
    more += fmt::format("Below: {}; each study lists its others, one CSV each.",
                        counted(static_cast<std::size_t>(tables), "table"));
  return more.empty() ? html : html + "<p class=\"soft\">" + more + "</p>\n";
}

std::string citation_html(const std::string& citation) {
  return "<p>Every table is a CSV file of its own, and a LaTeX file where it fits a page; every figure is an "
         "SVG, a "
         "PDF and a CSV.</p>\n<pre>" +
         html_text(citation) + "</pre>\n";
}

// The text with a value for each {{name}} in it.
std::string filled(std::string_view text, const std::map<std::string_view, std::string>& values) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t open = std::min(text.find("{{", at), text.size());
    result += text.substr(at, open - at);
    if (open == text.size()) break;
    const std::size_t close = text.find("}}", open);
    TRILAT_CHECK(close != std::string_view::npos, "a name in page.html ends with }}");
    result += values.at(text.substr(open + 2, close - open - 2));
    at = close + 2;
  }
  return result;
}

}  // namespace

std::string page_of(const ReportContent& content, const PageOptions& options) {
  std::vector<PageSection> sections;
  if (content.changes) sections.push_back({"changes", "What changed", html_of(*content.changes)});
  for (PageSection& section : chapter_sections(content)) sections.push_back(std::move(section));
  // what the reader's own studies found comes before somebody else's paper
  sections.insert(content.headline.verdicts.empty() ? sections.end() : sections.begin(),
                  claims_section(content));
  sections.push_back(errata_section(content));
  sections.push_back(assumptions_section(content));
  const std::string lead = lead_html(content);
  std::size_t bytes = std::strlen(embedded::page_html) + lead.size() + options.three_js.size() / 3;
  for (const PageSection& section : sections) bytes += section.html.size();
  sections.push_back(replay_section(content, options.three_js, kMaxBytes - std::min(kMaxBytes, bytes)));
  sections.push_back(provenance_section(content));
  sections.push_back({"article", "For an article", citation_html(options.citation)});
  std::erase_if(sections, [](const PageSection& section) { return section.html.empty(); });
  std::string html;
  for (const PageSection& section : sections)
    html += fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", section.id,
                        html_text(section.name), section.html);
  return filled(embedded::page_html,
                {{"program", kProgramVersion},
                 {"title", "Trilateration accuracy – " + html_text(content.headline.origin)},
                 {"first", sections.front().id},
                 {"lead", lead},
                 {"contents", contents_html(sections)},
                 {"sections", html},
                 {"made", html_text(options.made)}});
}

}  // namespace trilat
