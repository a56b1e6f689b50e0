// SPDX-License-Identifier: MIT
#include "reports/figure.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "reports/figure_axis.h"
#include "reports/render.h"

namespace trilat {
namespace {

constexpr double kWidth_px = 760.0, kPlotHeight_px = 360.0;
constexpr double kLeft_px = 72.0, kRight_px = 24.0, kBottom_px = 58.0;
constexpr double kTitle_px = 30.0, kLegendRow_px = 22.0, kSwatch_px = 26.0, kGap_px = 20.0;
constexpr double kCharacter_px = 7.2;  // wide enough for a character of 13 px in any of the fonts
constexpr int kTitleCharacters = 88;
// Okabe and Ito: told apart by colour-blind readers.
constexpr std::array<const char*, 6> kColours{"#0072b2", "#d55e00", "#009e73",
                                              "#cc79a7", "#e69f00", "#56b4e9"};

std::string xml_text(const std::string& text) {
  std::string result;
  for (char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result;
}

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

std::string text_at(double x_px, double y_px, const std::string& text, const std::string& attributes = {}) {
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\"{}{}>{}</text>\n", x_px, y_px,
                     attributes.empty() ? "" : " ", attributes, xml_text(text));
}

const std::string& group_of(const FigureSeries& series) {
  return series.group.empty() ? series.name : series.group;
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
  std::vector<std::string> groups;
  for (const FigureSeries& s : figure.series) {
    if (std::find(groups.begin(), groups.end(), group_of(s)) == groups.end()) groups.push_back(group_of(s));
    const auto colour =
        static_cast<std::size_t>(std::find(groups.begin(), groups.end(), group_of(s)) - groups.begin());
    add(s.style == FigureSeries::Style::dots ? LegendEntry::Kind::dots : LegendEntry::Kind::line, group_of(s),
        colour);
  }
  for (const FigureLine& line : figure.lines) add(LegendEntry::Kind::reference, line.label, 0);
  for (const FigureBand& band : figure.bands) add(LegendEntry::Kind::band, band.name, 0);
  return entries;
}

// One marker a colour, so that a print without colours can be read.
std::string marker(std::size_t colour, double x_px, double y_px) {
  switch (colour % 3) {
    case 0:
      return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"2.4\"/>\n", x_px, y_px);
    case 1:
      return fmt::format("<path d=\"M{:.2f} {:.2f}l3 5.2h-6z\"/>\n", x_px, y_px - 3.4);
    default:
      return fmt::format("<path d=\"M{:.2f} {:.2f}h4.4v4.4h-4.4z\"/>\n", x_px - 2.2, y_px - 2.2);
  }
}

std::string fill_of(std::size_t colour) {
  return fmt::format("fill=\"{}\" fill-opacity=\"0.65\"", kColours[colour % kColours.size()]);
}
std::string stroke_of(std::size_t colour, double width_px) {
  return fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\" stroke-linejoin=\"round\"",
                     kColours[colour % kColours.size()], width_px);
}
constexpr const char* kBandFill = "fill=\"#e4e4e4\"";
constexpr const char* kReferenceStroke = "stroke=\"#222222\" stroke-width=\"1.4\" stroke-dasharray=\"7 4\"";

std::string swatch(const LegendEntry& entry, double x_px, double middle_px) {
  switch (entry.kind) {
    case LegendEntry::Kind::dots:
      return fmt::format("<g {}>\n", fill_of(entry.colour)) +
             marker(entry.colour, x_px + kSwatch_px - 12.0, middle_px) + "</g>\n";
    case LegendEntry::Kind::line:
      return fmt::format("<path d=\"M{:.2f} {:.2f}h20\" {}/>\n", x_px, middle_px,
                         stroke_of(entry.colour, 2.0));
    case LegendEntry::Kind::reference:
      return fmt::format("<path d=\"M{:.2f} {:.2f}h20\" fill=\"none\" {}/>\n", x_px, middle_px,
                         kReferenceStroke);
    case LegendEntry::Kind::band:
      break;
  }
  return fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"20\" height=\"12\" {}/>\n", x_px,
                     middle_px - 6.0, kBandFill);
}

// The title and the legend, above the data; `top_px` moves below them.
std::string head_of(const Figure& figure, double& top_px) {
  std::string svg;
  top_px = kTitle_px - 6.0;
  for (const std::string& line : wrapped(figure.title, kTitleCharacters)) {
    svg += text_at(kLeft_px, top_px, line, "font-size=\"14\" font-weight=\"bold\"");
    top_px += 19.0;
  }
  double x_px = kLeft_px;
  for (const LegendEntry& entry : legend_of(figure)) {
    const double width_px = kSwatch_px + kCharacter_px * static_cast<double>(characters_of(entry.name));
    if (x_px > kLeft_px && x_px + width_px > kWidth_px - kRight_px) {
      x_px = kLeft_px;
      top_px += kLegendRow_px;
    }
    svg += swatch(entry, x_px, top_px) + text_at(x_px + kSwatch_px, top_px + 4.5, entry.name);
    x_px += width_px + kGap_px;
  }
  top_px += kLegendRow_px;
  return svg;
}

// The rectangle of the data and its axes.
struct Plot {
  FigureAxis x, y;
  double top_px = 0.0;

  double width_px() const { return kWidth_px - kLeft_px - kRight_px; }
  double bottom_px() const { return top_px + kPlotHeight_px; }
  double x_px(double value) const { return kLeft_px + x.at(value) * width_px(); }
  double y_px(double value) const { return bottom_px() - y.at(value) * kPlotHeight_px; }
  bool can_draw(const FigurePoint& p) const {
    return std::isfinite(p.x) && std::isfinite(p.y) && (!y.is_log || p.y > 0.0);
  }
};

Plot plot_of(const Figure& figure, double top_px) {
  std::vector<double> x, y;
  for (const FigureSeries& s : figure.series)
    for (const FigurePoint& p : s.points) {
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || (figure.log_y && p.y <= 0.0)) continue;
      x.push_back(p.x);
      y.push_back(p.y);
    }
  for (const FigureLine& line : figure.lines) y.push_back(line.y);
  return {linear_axis_tight(x), figure.log_y ? log_axis(y) : linear_axis(y), top_px};
}

std::string bands_of(const Figure& figure, const Plot& plot) {
  std::string svg;
  for (const FigureBand& band : figure.bands) {
    const double from = std::max(band.from, plot.x.low), to = std::min(band.to, plot.x.high);
    if (!(from < to)) continue;
    svg +=
        fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" {}/>\n",
                    plot.x_px(from), plot.top_px, plot.x_px(to) - plot.x_px(from), kPlotHeight_px, kBandFill);
  }
  return svg;
}

std::string axes_of(const Figure& figure, const Plot& plot) {
  std::string grid, ticks, labels;
  for (const AxisTick& tick : plot.x.ticks) {
    const double x_px = plot.x_px(tick.value);
    ticks += fmt::format("M{:.2f} {:.2f}v5", x_px, plot.bottom_px());
    labels += text_at(x_px, plot.bottom_px() + 20.0, tick.label, "text-anchor=\"middle\"");
  }
  for (const AxisTick& tick : plot.y.ticks) {
    const double y_px = plot.y_px(tick.value);
    ticks += fmt::format("M{:.2f} {:.2f}h-{}", kLeft_px, y_px, tick.label.empty() ? 3 : 5);
    if (tick.label.empty()) continue;
    grid += fmt::format("M{:.2f} {:.2f}h{:.2f}", kLeft_px, y_px, plot.width_px());
    labels += text_at(kLeft_px - 9.0, y_px + 4.5, tick.label, "text-anchor=\"end\"");
  }
  labels += text_at(kLeft_px + 0.5 * plot.width_px(), plot.bottom_px() + 44.0, figure.x_label,
                    "text-anchor=\"middle\" font-size=\"14\"");
  const double middle_px = plot.top_px + 0.5 * kPlotHeight_px;
  labels += text_at(
      20.0, middle_px, figure.y_label,
      fmt::format("text-anchor=\"middle\" font-size=\"14\" transform=\"rotate(-90 20 {:.2f})\"", middle_px));
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"#cccccc\" stroke-width=\"0.6\"/>\n", grid) +
         fmt::format("<path d=\"{}M{:.2f} {:.2f}v{:.2f}h{:.2f}\" fill=\"none\" stroke=\"#222222\"/>\n", ticks,
                     kLeft_px, plot.top_px, kPlotHeight_px, plot.width_px()) +
         labels;
}

std::string dots_of(const FigureSeries& series, const Plot& plot, std::size_t colour) {
  std::string svg = fmt::format("<g {}>\n", fill_of(colour));
  for (const FigurePoint& p : series.points)
    if (plot.can_draw(p)) svg += marker(colour, plot.x_px(p.x), plot.y_px(p.y));
  return svg + "</g>\n";
}

std::string line_of(const FigureSeries& series, const Plot& plot, std::size_t colour, double width_px) {
  std::string path;
  bool drawing = false;
  for (const FigurePoint& p : series.points) {
    if (plot.can_draw(p))
      path += fmt::format("{}{:.2f} {:.2f}", drawing ? "L" : "M", plot.x_px(p.x), plot.y_px(p.y));
    drawing = plot.can_draw(p);
  }
  if (path.empty()) return {};
  return fmt::format("<path d=\"{}\" {}/>\n", path, stroke_of(colour, width_px));
}

std::string data_of(const Figure& figure, const Plot& plot) {
  std::string svg;
  const std::vector<LegendEntry> legend = legend_of(figure);
  for (const FigureSeries& s : figure.series) {
    const auto entry = std::find_if(legend.begin(), legend.end(),
                                    [&](const LegendEntry& e) { return e.name == group_of(s); });
    const std::size_t colour = entry == legend.end() ? 0 : entry->colour;
    svg += s.style == FigureSeries::Style::dots ? dots_of(s, plot, colour)
                                                : line_of(s, plot, colour, s.group.empty() ? 2.0 : 1.0);
  }
  for (const FigureLine& line : figure.lines)
    if (plot.can_draw({0.0, line.y}))
      svg += fmt::format("<path d=\"M{:.2f} {:.2f}h{:.2f}\" fill=\"none\" {}/>\n", kLeft_px,
                         plot.y_px(line.y), plot.width_px(), kReferenceStroke);
  return svg;
}

}  // namespace

std::string svg_of(const Figure& figure) {
  double top_px = 0.0;
  const std::string head = head_of(figure, top_px);
  const Plot plot = plot_of(figure, top_px);
  const double height_px = plot.bottom_px() + kBottom_px;
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:g}\" height=\"{1:g}\" viewBox=\"0 0 {0:g} "
             "{1:g}\" role=\"img\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\" "
             "fill=\"#222222\">\n<title>{2}</title>\n<rect width=\"{0:g}\" height=\"{1:g}\" "
             "fill=\"#ffffff\"/>\n",
             kWidth_px, height_px, xml_text(figure.title)) +
         head + bands_of(figure, plot) + axes_of(figure, plot) + data_of(figure, plot) + "</svg>\n";
}

std::string csv_of(const Figure& figure) {
  std::string text = "series,x,y\r\n";
  const auto number = [](double v) { return std::isfinite(v) ? fmt::format("{}", v) : std::string(); };
  for (const FigureSeries& s : figure.series)
    for (const FigurePoint& p : s.points)
      text += csv_field(s.name) + ',' + number(p.x) + ',' + number(p.y) + "\r\n";
  return text;
}

}  // namespace trilat
