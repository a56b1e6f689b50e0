// SPDX-License-Identifier: MIT
#include "reports/page/page_replay.h"

#include <fmt/format.h>

#include "reports/page/embedded_page.h"
#include "reports/page/html_text.h"

namespace trilat {
namespace {

// Of all replays, so that the page stays below 15 MB.
constexpr std::size_t kMostBytes = 8'000'000;

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

}  // namespace

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
        "<p>There is no replay: none of the results holds a replay.h5, which <code>trilat run</code> writes "
        "for studies of kind accuracy.</p>\n";
    return section;
  }
  if (three_js.empty() || three_js.find("</script") != std::string::npos) {
    section.html =
        "<p>There is no replay: three.js was not found. Install the Debian package "
        "<code>libjs-three</code> and write the report again.</p>\n";
    return section;
  }
  section.html = fmt::format(
      "<p>The first take of each condition, at most 35&nbsp;s of it{}: what every sensor’s body tracker gave "
      "(thin, faint "
      "where a joint is inferred), each method’s estimate, the truth (thick), and lines from truth to "
      "estimate "
      "coloured by their length. Positions are as estimated, before any alignment, to a millimetre.</p>\n",
      simulated ? ", <strong>simulated</strong>" : "");
  if (!left_out.empty())
    section.html += "<p class=\"soft\">Left out, to keep the page small: " + html_text(left_out) + ".</p>\n";
  section.html +=
      "<div class=\"replay\" id=\"replay-view\"><p class=\"soft\">The replay needs a browser with "
      "JavaScript and WebGL.</p></div>\n" +
      data + "<script type=\"text/plain\" id=\"three-js\">" + three_js + "</script>\n<script>\n" +
      embedded::replay_js + "</script>\n";
  return section;
}

}  // namespace trilat
