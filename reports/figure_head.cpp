// SPDX-License-Identifier: MIT
#include "reports/figure_head.h"

#include <algorithm>

#include <fmt/format.h>

#include "reports/svg_marks.h"

namespace trilat {
namespace {

constexpr double kTitleBaseline_px = 24.0, kTitleLine_px = 19.0;
constexpr double kLegendRow_px = 22.0, kSwatch_px = 26.0, kGap_px = 20.0;
constexpr double kCharacter_px = 7.2;  // wide enough for a character of 13 px in any of the fonts
constexpr std::size_t kTitleCharacters = 80;
constexpr double kLegendDot_px = 3.0;

std::size_t characters_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::vector<std::string> wrapped(const std::string& text, std::size_t characters) {
  std::vector<std::string> lines{""};
  std::string word;
  const auto end_word = [&] {
    if (word.empty()) return;
    if (!lines.back().empty() && characters_of(lines.back()) + 1 + characters_of(word) > characters)
      lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
    word.clear();
  };
  for (char c : text) c == ' ' || c == '\n' ? end_word() : word.push_back(c);
  end_word();
  return lines;
}

// What stands in the legend, each once, in the order of the figure.
struct LegendEntry {
  enum class Kind { dots, line, band, reference } kind;
  std::string name;
  std::size_t colour = 0;
};

std::vector<LegendEntry> legend_of(const Figure& figure) {
  std::vector<LegendEntry> entries;
  const auto add = [&](LegendEntry::Kind kind, const std::string& name, std::size_t colour) {
    for (const LegendEntry& e : entries)
      if (e.kind == kind && e.name == name) return;
    if (!name.empty()) entries.push_back({kind, name, colour});
  };
  const std::vector<std::string> groups = groups_of(figure);
  for (const FigureSeries& s : figure.series)
    add(s.style == FigureSeries::Style::dots ? LegendEntry::Kind::dots : LegendEntry::Kind::line, group_of(s),
        static_cast<std::size_t>(std::find(groups.begin(), groups.end(), group_of(s)) - groups.begin()));
  for (const FigureLine& line : figure.lines) add(LegendEntry::Kind::reference, line.label, 0);
  for (const FigureBand& band : figure.bands) add(LegendEntry::Kind::band, band.name, 0);
  return entries;
}

std::string swatch(const LegendEntry& entry, double x_px, double middle_px) {
  switch (entry.kind) {
    case LegendEntry::Kind::dots:
      return fmt::format("<g {}>\n", fill_of(entry.colour)) +
             marker(entry.colour, x_px + kSwatch_px - 12.0, middle_px, kLegendDot_px) + "</g>\n";
    case LegendEntry::Kind::line:
      return fmt::format("<path d=\"M{:.2f} {:.2f}h20\" {}/>\n", x_px, middle_px,
                         stroke_of(entry.colour, 2.0));
    case LegendEntry::Kind::reference:
      return fmt::format("<path d=\"M{:.2f} {:.2f}h20\" {}/>\n", x_px, middle_px, kReferenceStroke);
    case LegendEntry::Kind::band:
      break;
  }
  return fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"20\" height=\"12\" {}/>\n", x_px,
                     middle_px - 6.0, kBandFill);
}

}  // namespace

const std::string& group_of(const FigureSeries& series) {
  return series.group.empty() ? series.name : series.group;
}

std::vector<std::string> groups_of(const Figure& figure) {
  std::vector<std::string> groups;
  for (const FigureSeries& s : figure.series)
    if (std::find(groups.begin(), groups.end(), group_of(s)) == groups.end()) groups.push_back(group_of(s));
  return groups;
}

FigureHead figure_head(const Figure& figure) {
  FigureHead head{{}, kTitleBaseline_px};
  for (const std::string& line : wrapped(figure.title, kTitleCharacters)) {
    head.svg += text_at(kFigureLeft_px, head.height_px, line, "font-size=\"14\" font-weight=\"bold\"");
    head.height_px += kTitleLine_px;
  }
  double x_px = kFigureLeft_px;
  for (const LegendEntry& entry : legend_of(figure)) {
    const double width_px = kSwatch_px + kCharacter_px * static_cast<double>(characters_of(entry.name));
    if (x_px > kFigureLeft_px && x_px + width_px > kFigureWidth_px - kFigureRight_px) {
      x_px = kFigureLeft_px;
      head.height_px += kLegendRow_px;
    }
    head.svg +=
        swatch(entry, x_px, head.height_px) + text_at(x_px + kSwatch_px, head.height_px + 4.5, entry.name);
    x_px += width_px + kGap_px;
  }
  head.height_px += kLegendRow_px;
  return head;
}

}  // namespace trilat
