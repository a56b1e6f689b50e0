// SPDX-License-Identifier: MIT
#include "reports/figure.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "reports/figure_axis.h"
#include "reports/figure_head.h"
#include "reports/render.h"
#include "reports/svg_marks.h"

namespace trilat {
namespace {

constexpr double kPlotHeight_px = 360.0, kBottom_px = 58.0;
constexpr double kDot_px = 2.4, kLargeDot_px = 4.0;
constexpr std::size_t kFewPoints = 30;  // are drawn large

// The rectangle of the data and its axes.
struct Plot {
  FigureAxis x, y;
  double top_px = 0.0;

  double width_px() const { return kFigureWidth_px - kFigureLeft_px - kFigureRight_px; }
  double bottom_px() const { return top_px + kPlotHeight_px; }
  double x_px(double value) const { return kFigureLeft_px + x.at(value) * width_px(); }
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
    ticks += fmt::format("M{:.2f} {:.2f}h-{}", kFigureLeft_px, y_px, tick.label.empty() ? 3 : 5);
    if (tick.label.empty()) continue;
    grid += fmt::format("M{:.2f} {:.2f}h{:.2f}", kFigureLeft_px, y_px, plot.width_px());
    labels += text_at(kFigureLeft_px - 9.0, y_px + 4.5, tick.label, "text-anchor=\"end\"");
  }
  labels += text_at(kFigureLeft_px + 0.5 * plot.width_px(), plot.bottom_px() + 44.0, figure.x_label,
                    "text-anchor=\"middle\" font-size=\"14\"");
  const double middle_px = plot.top_px + 0.5 * kPlotHeight_px;
  labels += text_at(
      20.0, middle_px, figure.y_label,
      fmt::format("text-anchor=\"middle\" font-size=\"14\" transform=\"rotate(-90 20 {:.2f})\"", middle_px));
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"#cccccc\" stroke-width=\"0.6\"/>\n", grid) +
         fmt::format("<path d=\"{}M{:.2f} {:.2f}v{:.2f}h{:.2f}\" fill=\"none\" stroke=\"#222222\"/>\n", ticks,
                     kFigureLeft_px, plot.top_px, kPlotHeight_px, plot.width_px()) +
         labels;
}

std::string dots_of(const FigureSeries& series, const Plot& plot, std::size_t colour) {
  const double radius_px = series.points.size() <= kFewPoints ? kLargeDot_px : kDot_px;
  std::string svg = fmt::format("<g {}>\n", fill_of(colour));
  for (const FigurePoint& p : series.points)
    if (plot.can_draw(p)) svg += marker(colour, plot.x_px(p.x), plot.y_px(p.y), radius_px);
  return svg + "</g>\n";
}

// A step of no length begins each stretch, so that one of a single point shows as its round end.
std::string line_of(const FigureSeries& series, const Plot& plot, std::size_t colour) {
  std::string path;
  bool drawing = false;
  for (const FigurePoint& p : series.points) {
    if (plot.can_draw(p))
      path += fmt::format("{}{:.2f} {:.2f}{}", drawing ? "L" : "M", plot.x_px(p.x), plot.y_px(p.y),
                          drawing ? "" : "h0");
    drawing = plot.can_draw(p);
  }
  if (path.empty()) return {};
  return fmt::format("<path d=\"{}\" {}/>\n", path, stroke_of(colour, series.group.empty() ? 2.0 : 1.0));
}

// Lines lie below dots, and what is compared with above both.
std::string data_of(const Figure& figure, const Plot& plot) {
  const std::vector<std::string> groups = groups_of(figure);
  std::string lines, dots, references;
  for (const FigureSeries& s : figure.series) {
    const auto colour =
        static_cast<std::size_t>(std::find(groups.begin(), groups.end(), group_of(s)) - groups.begin());
    if (s.style == FigureSeries::Style::dots)
      dots += dots_of(s, plot, colour);
    else
      lines += line_of(s, plot, colour);
  }
  for (const FigureLine& line : figure.lines)
    if (plot.can_draw({plot.x.low, line.y}))
      references += fmt::format("<path d=\"M{:.2f} {:.2f}h{:.2f}\" {}/>\n", kFigureLeft_px, plot.y_px(line.y),
                                plot.width_px(), kReferenceStroke);
  return lines + dots + references;
}

}  // namespace

std::string svg_of(const Figure& figure) {
  const FigureHead head = figure_head(figure);
  const Plot plot = plot_of(figure, head.height_px);
  const double height_px = plot.bottom_px() + kBottom_px;
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:g}\" height=\"{1:g}\" viewBox=\"0 0 {0:g} "
             "{1:g}\" role=\"img\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\" "
             "fill=\"#222222\">\n<title>{2}</title>\n<rect width=\"{0:g}\" height=\"{1:g}\" "
             "fill=\"#ffffff\"/>\n",
             kFigureWidth_px, height_px, xml_text(figure.title)) +
         head.svg + bands_of(figure, plot) + axes_of(figure, plot) + data_of(figure, plot) + "</svg>\n";
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
