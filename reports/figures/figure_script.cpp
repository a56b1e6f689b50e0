// SPDX-License-Identifier: MIT
#include "reports/figures/figure_script.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "reports/figures/figure_look.h"
#include "reports/render/render.h"

namespace trilat {
namespace {

constexpr std::size_t kTitleCharacters = 80;
constexpr std::size_t kFewPoints = 30;  // are drawn large
constexpr double kSmallDot = 0.45, kLargeDot = 0.9;
constexpr const char* kShade = "#e4e4e4";

// Nothing is replaced in single quotes, where backquotes of double ones would run a program.
std::string gnuplot_text(const std::string& text) {
  std::string result = "'";
  for (char c : text) {
    if (c == '\'')
      result += "''";
    else
      result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result + "'";
}

std::string wrapped_title(const std::string& text) {
  std::string result;
  for (const std::string& line : lines_of(text, kTitleCharacters))
    result += (result.empty() ? "" : ".\"\\n\".") + gnuplot_text(line);
  return result;
}

bool can_draw(const Figure& figure, const FigurePoint& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && (!figure.log_x || p.x > 0.0) &&
         (!figure.log_y || p.y > 0.0);
}

bool has_interval(const Figure& figure, const FigurePoint& p) {
  return can_draw(figure, p) && std::isfinite(p.low) && std::isfinite(p.high) &&
         (!figure.log_y || p.low > 0.0);
}

bool is_box(const FigureSeries& s) {
  return s.style == FigureSeries::Style::bars || s.style == FigureSeries::Style::boxes;
}

// A fiftieth beyond the points and halves of bars, so that none lies on the frame.
std::string x_range(const Figure& figure) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const auto widen = [&](double from, double to) {
    low = std::min(low, from);
    high = std::max(high, to);
  };
  for (const FigureSeries& s : figure.series)
    for (const FigurePoint& p : s.points)
      if (can_draw(figure, p))
        widen(p.x - (is_box(s) ? 0.5 * s.width : 0.0), p.x + (is_box(s) ? 0.5 * s.width : 0.0));
  if (figure.map && !figure.map->x.empty()) {
    const double half = figure.map->x.size() < 2 ? 0.5 : 0.5 * (figure.map->x[1] - figure.map->x[0]);
    return fmt::format("set xrange [{}:{}] noextend\n", figure.map->x.front() - half,
                       figure.map->x.back() + half);
  }
  if (!figure.x_names.empty())
    return fmt::format("set xrange [-0.6:{}]\n", static_cast<double>(figure.x_names.size()) - 0.4);
  if (!(low <= high)) return figure.log_x ? "set xrange [1:10]\n" : "set xrange [0:1]\n";
  if (figure.log_x) {
    const double factor = std::max(1.2, std::pow(high / low, 0.03));
    return fmt::format("set xrange [{}:{}]\n", low / factor, high * factor);
  }
  const double pad = high > low ? 0.02 * (high - low) : 0.5;
  return fmt::format("set xrange [{}:{}]\n", low - pad, high + pad);
}

// gnuplot cannot choose a range from nothing.
std::string y_range(const Figure& figure) {
  bool any = !figure.lines.empty() || figure.map, bars = false;
  for (const FigureSeries& s : figure.series) {
    bars |= s.style == FigureSeries::Style::bars;
    any |= std::any_of(s.points.begin(), s.points.end(),
                       [&](const FigurePoint& p) { return can_draw(figure, p); });
  }
  if (!any) return figure.log_y ? "set yrange [1:10]\n" : "set yrange [0:1]\n";
  if (figure.map && !figure.map->y.empty()) {
    const double half = figure.map->y.size() < 2 ? 0.5 : 0.5 * (figure.map->y[1] - figure.map->y[0]);
    return fmt::format("set yrange [{}:{}] noextend\n", figure.map->y.front() - half,
                       figure.map->y.back() + half);
  }
  return bars && !figure.log_y ? "set yrange [0:*]\n" : "";
}

std::string settings_of(const Figure& figure) {
  std::string text =
      "set encoding utf8\nset title " + wrapped_title(figure.title) + " noenhanced\nset xlabel " +
      gnuplot_text(figure.x_label) + " noenhanced\nset ylabel " + gnuplot_text(figure.y_label) +
      " noenhanced\nset key outside above left Left reverse noenhanced samplen 3 width 1\nset border 3 lc "
      "rgb '#333333'\n"
      "set tics nomirror noenhanced\nset grid xtics ytics lc rgb '#d0d0d0' lw 0.5 dt 1\nset boxwidth 0.8\n";
  if (figure.log_x) text += "set logscale x\nset format x '%g'\n";
  if (figure.log_y) text += "set logscale y\nset format y '%g'\n";
  if (figure.equal_scales) text += "set size ratio -1\n";
  if (!figure.x_names.empty()) {
    text += "set grid noxtics\nset xtics (";
    for (std::size_t k = 0; k < figure.x_names.size(); ++k)
      text += fmt::format("{}{} {}", k ? ", " : "", gnuplot_text(figure.x_names[k]), k);
    text += ")\n";
    std::size_t characters = 0;
    for (const std::string& name : figure.x_names) characters = std::max(characters, width_of(name));
    if (characters * figure.x_names.size() > kTitleCharacters) text += "set xtics rotate by -30\n";
  }
  text += x_range(figure) + y_range(figure);
  for (std::size_t k = 0; k < figure.bands.size(); ++k)
    text += fmt::format(
        "set object {} rectangle from {}, graph 0 to {}, graph 1 behind fillcolor rgb '{}' fillstyle solid "
        "noborder\n",
        k + 1, figure.bands[k].from, figure.bands[k].to, kShade);
  return text;
}

std::string script_number(double v) { return std::isfinite(v) ? fmt::format("{}", v) : "NaN"; }

// Rows of a data block. An empty row ends a line.
class Block {
 public:
  Block(std::string& script, std::size_t index) : script_(script), name_(fmt::format("$d{}", index)) {
    script_ += name_ + " << EOD\n";
  }
  void row(std::initializer_list<double> values) {
    std::string line;
    for (double v : values) line += (line.empty() ? "" : " ") + script_number(v);
    script_ += line + '\n';
    empty_ = false;
  }
  void gap() { script_ += '\n'; }
  // Its name; a block must not be empty.
  std::string end() {
    if (empty_) script_ += "NaN NaN NaN NaN NaN NaN\n";
    script_ += "EOD\n";
    return name_;
  }

 private:
  std::string& script_;
  std::string name_;
  bool empty_ = true;
};

// Everything of one legend entry: one element of the plot for what is drawn of it, one more for its
// intervals.
struct Entry {
  std::vector<const FigureSeries*> series;
  FigureLook look;
};

std::vector<Entry> entries_of(const Figure& figure) {
  const std::vector<FigureLook> looks = looks_of(figure);
  std::vector<Entry> entries;
  for (std::size_t k = 0; k < figure.series.size(); ++k) {
    const FigureSeries& s = figure.series[k];
    const auto same = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) {
      return group_of(*e.series.front()) == group_of(s) && e.series.front()->style == s.style;
    });
    if (same == entries.end())
      entries.push_back({{&s}, looks[k]});
    else
      same->series.push_back(&s);
  }
  return entries;
}

class Script {
 public:
  explicit Script(const Figure& figure) : figure_(figure), text_(settings_of(figure)) {}

  std::string text() {
    if (figure_.map) add_map(*figure_.map);
    const std::vector<Entry> entries = entries_of(figure_);
    for (const bool boxes : {true, false})
      for (const Entry& e : entries)
        if (is_box(*e.series.front()) == boxes) boxes ? add_boxes(e) : add_points(e);
    for (const FigureLine& line : figure_.lines)
      if (!figure_.log_y || line.y > 0.0)
        plots_.push_back(fmt::format("{} with lines lw 1.5 dt 2 lc rgb '#222222' title {}",
                                     script_number(line.y), gnuplot_text(line.label)));
    std::set<std::string> named;
    for (const FigureBand& band : figure_.bands)
      if (named.insert(band.name).second)
        plots_.push_back(fmt::format("keyentry with boxes fillstyle solid noborder lc rgb '{}' title {}",
                                     kShade, gnuplot_text(band.name)));
    if (plots_.empty()) plots_.push_back("NaN notitle");
    text_ += "plot ";
    for (std::size_t k = 0; k < plots_.size(); ++k) text_ += (k ? ", \\\n  " : "") + plots_[k];
    return text_ + "\n";
  }

 private:
  void add_map(const FigureMap& map) {
    // dark is good: from blue through green to yellow, ordered in grey too
    text_ +=
        "set palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 '#fde725')\n";
    text_ += fmt::format("set cbrange [{}:{}]\nset cblabel {} noenhanced\n", map.least, map.most,
                         gnuplot_text(map.label));
    Block block(text_, blocks_++);
    for (std::size_t r = 0; r < map.y.size(); ++r) {
      for (std::size_t c = 0; c < map.x.size(); ++c) {
        const double value = map.values[r * map.x.size() + c];
        block.row({map.x[c], map.y[r], std::isnan(value) ? value : std::clamp(value, map.least, map.most)});
      }
      block.gap();
    }
    plots_.push_back(block.end() + " using 1:2:3 with image pixels notitle");
  }

  void add_boxes(const Entry& entry) {
    const bool bars = entry.series.front()->style == FigureSeries::Style::bars;
    Block block(text_, blocks_++);
    for (const FigureSeries* s : entry.series)
      for (const FigurePoint& p : s->points) {
        if (!can_draw(figure_, p) || !std::isfinite(p.low) || !std::isfinite(p.high)) continue;
        if (bars)
          block.row({p.x, p.y, p.x - 0.5 * s->width, p.x + 0.5 * s->width, p.low, p.high});
        else
          block.row({p.x, p.low, p.least, p.most, p.high, s->width, p.y});
      }
    const std::string name = block.end(), title = gnuplot_text(group_of(*entry.series.front()));
    if (bars) {
      // where colours come round again, hatched
      const std::string fill = entry.look.dash == 1 ? std::string("solid 0.75 noborder")
                                                    : fmt::format("pattern {} border", entry.look.dash + 2);
      plots_.push_back(fmt::format("{} using 1:2:3:4:5:6 with boxxyerror lc rgb '{}' fillstyle {} title {}",
                                   name, entry.look.colour, fill, title));
      return;
    }
    plots_.push_back(fmt::format(
        "{} using 1:2:3:4:5:6 with candlesticks whiskerbars 0.5 lc rgb '{}' lw 1.2 fillstyle solid 0.35 "
        "border title {}",
        name, entry.look.colour, title));
    plots_.push_back(
        fmt::format("{} using 1:7:7:7:7:6 with candlesticks lc rgb '#222222' lw 2 notitle", name));
  }

  void add_points(const Entry& entry) {
    const FigureSeries::Style style = entry.series.front()->style;
    std::size_t most = 0;
    bool intervals = false;
    Block block(text_, blocks_++);
    for (const FigureSeries* s : entry.series) {
      most = std::max(most, s->points.size());
      bool gap = true;
      for (const FigurePoint& p : s->points) {
        intervals |= has_interval(figure_, p);
        if (can_draw(figure_, p))
          block.row(
              {p.x, p.y, has_interval(figure_, p) ? p.low : p.y, has_interval(figure_, p) ? p.high : p.y});
        else if (!gap)
          block.gap();
        gap = !can_draw(figure_, p);
      }
      if (s != entry.series.back()) block.gap();
    }
    const std::string name = block.end(), title = gnuplot_text(group_of(*entry.series.front()));
    const FigureLook& look = entry.look;
    const std::string dots =
        fmt::format("pt {} ps {}", look.marker, most <= kFewPoints ? kLargeDot : kSmallDot);
    const double width = entry.series.size() > 1 ? 1.0 : 2.0;
    if (style == FigureSeries::Style::dots)
      plots_.push_back(fmt::format("{} using 1:2 with points {} lc rgb '{}' title {}", name, dots,
                                   most <= kFewPoints ? look.colour : "#60" + look.colour.substr(1), title));
    else
      plots_.push_back(fmt::format("{} using 1:2 with {} lw {} dt {} lc rgb '{}' title {}", name,
                                   style == FigureSeries::Style::line ? "lines" : "linespoints " + dots,
                                   width, look.dash, look.colour, title));
    // behind its entry, with which it is switched off; yerrorbars would blank the markers under their points
    if (intervals)
      plots_.push_back(fmt::format(
          "{} using 1:3:(0):($4-$3) with vectors heads size screen 0.005,90 lw 1.2 lc rgb '{}' notitle", name,
          look.colour));
  }

  const Figure& figure_;
  std::string text_;
  std::vector<std::string> plots_;
  std::size_t blocks_ = 0;
};

}  // namespace

std::string gnuplot_script(const Figure& figure) { return Script(figure).text(); }

}  // namespace trilat
