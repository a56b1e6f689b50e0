// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/results/summary.h"
#include "reports/render/render.h"
#include "reports/report_content.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxAnswers = 4;
// "Recorded, for comparison: WHAT: 0.8 to 4.4 cm; …".
std::string recorded_sentence(const Table& recorded) {
  std::string text;
  for (const std::vector<TableValue>& row : recorded.rows)
    text += fmt::format("{}{}: {} to {} cm", text.empty() ? "Recorded, for comparison: " : "; ", row[0].text,
                        printed(row[1]), printed(row[2]));
  return text + ".";
}

void add_verdicts(const std::vector<JudgedClaim>& claims, Headline& headline) {
  for (std::size_t v = 0; v < kVerdictNames.size(); ++v)
    if (const auto n = std::ranges::count(claims, static_cast<ClaimVerdict>(v), &JudgedClaim::verdict))
      headline.verdicts.emplace_back(static_cast<ClaimVerdict>(v), static_cast<std::size_t>(n));
}

// The first figure that is wanted of those that answer a question, with what its methods are.
void put_in_headline(ReportContent& content, Headline& headline, const auto& is_wanted) {
  for (Chapter& chapter : content.chapters)
    for (DrawnFigure& drawn : chapter.figures)
      if (drawn.figure.is_first && is_wanted(chapter, drawn.figure)) {
        drawn.in_headline = true;
        headline.legend = chapter.legend;
        return;
      }
}

// The warnings of all studies. A warning that several give is printed once, behind their names.
std::vector<std::string> warnings_of(const std::vector<Chapter>& chapters) {
  std::vector<std::pair<std::string, std::string>> said;  // by whom, and what
  for (const Chapter& chapter : chapters)
    for (const std::string& warning : chapter.warnings) {
      const auto same = std::ranges::find(said, warning, &std::pair<std::string, std::string>::second);
      if (same == said.end())
        said.emplace_back(chapter.provenance.folder, warning);
      else
        same->first += ", " + chapter.provenance.folder;
    }
  std::vector<std::string> warnings;
  for (const auto& [by, warning] : said)
    warnings.push_back(chapters.size() > 1 ? by + ": " + warning : warning);
  return warnings;
}

}  // namespace

Headline headline_of(ReportContent& content, const std::optional<PaperFindings>& paper,
                     const std::optional<ErrorChanges>& changes) {
  Headline headline;
  bool simulated = false, recorded = false;
  for (const Chapter& chapter : content.chapters) (chapter.simulated ? simulated : recorded) = true;
  headline.origin = simulated && recorded ? "Simulated and recorded data"
                    : simulated           ? "Simulated data"
                                          : "Recorded data";
  // the experiment that the paper's question is asked of
  const auto is_walking = [](const Chapter& c) { return c.paper == name_of(PaperStudy::table3); };
  const bool on_the_paper = paper && std::ranges::any_of(content.chapters, [&](const Chapter& c) {
                              return is_walking(c) && !c.on_the_paper.empty();
                            });
  headline.warnings = warnings_of(content.chapters);
  if (paper) add_verdicts(paper->claims, headline);
  if (on_the_paper) {
    headline.asked =
        "Does nonlinear trilateration of several Kinect v2 find joints better than the plain mean of them?";
    for (const Chapter& chapter : content.chapters)
      if (is_walking(chapter))
        headline.answers.insert(headline.answers.end(), chapter.on_the_paper.begin(),
                                chapter.on_the_paper.end());
    if (simulated) headline.answers.back() += " " + recorded_sentence(recorded_table());
    put_in_headline(content, headline,
                    [&](const Chapter& c, const Figure& f) { return is_walking(c) && !f.y_names.empty(); });
    return headline;
  }
  if (changes) {
    headline.asked = "What changed, by how much, and is it real?";
    headline.answers = changes_sentences(*changes);
    put_in_headline(content, headline, [](const Chapter&, const Figure&) { return true; });
    return headline;
  }
  const bool one_question = std::ranges::all_of(
      content.chapters, [&](const Chapter& c) { return c.asked == content.chapters.front().asked; });
  headline.asked = one_question ? content.chapters.front().asked : "What did the studies find?";
  std::size_t left_out = 0;
  for (const Chapter& chapter : content.chapters)
    for (const std::string& finding : chapter.findings.empty() ? chapter.sentences : chapter.findings) {
      if (headline.answers.size() < kMaxAnswers)
        headline.answers.push_back(content.chapters.size() > 1 ? chapter.provenance.folder + ": " + finding
                                                               : finding);
      else
        ++left_out;
    }
  if (left_out > 0) headline.answers.push_back(fmt::format("And {} more, in the studies below.", left_out));
  put_in_headline(content, headline, [](const Chapter&, const Figure&) { return true; });
  return headline;
}

std::string warnings_text(const Headline& headline) {
  const std::size_t count = headline.warnings.size();
  return fmt::format("{} warning{}{}", count, count == 1 ? "" : "s", count == 1 ? "" : ", the first");
}

std::string headline_text(const Headline& headline) {
  constexpr std::size_t kColumns = 96;
  std::string text = headline.asked + " " + headline.origin + ".\n";
  const auto add = [&](std::string sentence) {
    std::erase_if(sentence, [](char c) { return c == '*' || c == '`'; });
    bool first = true;
    for (const std::string& line : lines_of(sentence, kColumns)) {
      text += (first ? "  - " : "    ") + line + "\n";
      first = false;
    }
  };
  for (const std::string& answer : headline.answers) add(answer);
  std::string verdicts;
  for (const auto& [verdict, count] : headline.verdicts)
    verdicts += fmt::format("{}{} {}", verdicts.empty() ? "" : ", ", name_of(verdict), count);
  if (!verdicts.empty()) add("The paper's claims: " + verdicts + ".");
  if (!headline.warnings.empty())
    add(fmt::format("{}: {}", warnings_text(headline), headline.warnings.front()));
  return text;
}

}  // namespace trilat
