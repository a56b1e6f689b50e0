// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "reports/figures/draw_figures.h"
#include "reports/figures/figure_look.h"
#include "reports/render/render.h"

namespace trilat {
namespace {

constexpr double kColumn_mm = 85.0, kPage_mm = 178.0;
constexpr double kLetter_mm = 1.55, kLine_mm = 4.3;  // of 8 pt: a wide letter's width, a line's height
constexpr double kTitle_mm = 6.0;                    // a panel's
constexpr double kBetweenRows_mm = 10.0;
constexpr std::size_t kFewPoints = 30;  // are drawn large
constexpr double kSmallDot = 0.4, kLargeDot = 0.55;
constexpr const char* kShade = "#e4e4e4";
constexpr std::size_t kPanelColumns = 3;

using Style = FigureSeries::Style;

// Text in single quotes, in which nothing is replaced: backquotes in double ones would run a program.
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

// Names of ticks are formats.
std::string without_formats(const std::string& text) {
  std::string result;
  for (char c : text) result += c == '%' ? std::string("%%") : std::string(1, c);
  return result;
}

bool can_draw(const Figure& figure, const FigurePoint& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && (!figure.log_x || p.x > 0.0) &&
         (!figure.log_y || p.y > 0.0);
}

bool can_draw(const Figure& figure, const FigureLine& line) { return !figure.log_y || line.y > 0.0; }

bool has_interval(const Figure& figure, const FigurePoint& p) {
  return can_draw(figure, p) && std::isfinite(p.low) && std::isfinite(p.high) &&
         !((figure.y_names.empty() ? figure.log_y : figure.log_x) && p.low <= 0.0);
}

std::size_t longest(const std::vector<std::string>& names) {
  std::size_t most = 0;
  for (const std::string& name : names) most = std::max(most, width_of(name));
  return most;
}

// The range of an axis.
struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void pad(bool logarithmic, double share) {
    if (!(low <= high)) {
      low = logarithmic ? 1.0 : 0.0;
      high = logarithmic ? 10.0 : 1.0;
    } else if (logarithmic) {
      const double factor = std::max(1.2, std::pow(high / low, share));
      low /= factor;
      high *= factor;
    } else {
      const double more = high > low ? share * (high - low) : 0.5;
      low -= more;
      high += more;
    }
  }
};

Range names_range(const std::vector<std::string>& names) {
  return {-0.6, static_cast<double>(names.size()) - 0.4};
}

Range x_range(const Figure& figure) {
  if (!figure.x_names.empty()) return names_range(figure.x_names);
  Range range;
  for (const FigureSeries& s : figure.series)
    for (const FigurePoint& p : s.points) {
      if (!can_draw(figure, p)) continue;
      range.add(p.x);
      if (figure.y_names.empty() || !has_interval(figure, p)) continue;
      range.add(p.low);
      range.add(p.high);
    }
  if (!figure.y_names.empty() && !figure.log_x) range.add(0.0);
  range.pad(figure.log_x, 0.02);
  if (!figure.y_names.empty() && !figure.log_x && range.low < 0.0 && range.low > -0.03 * range.high)
    range.low = 0.0;
  return range;
}

// Each panel has its own.
Range y_range(const Figure& figure, std::size_t panel) {
  if (!figure.y_names.empty()) return names_range(figure.y_names);
  Range range;
  for (const FigureSeries& s : figure.series)
    for (const FigurePoint& p : s.points) {
      if (s.panel != panel || !can_draw(figure, p)) continue;
      range.add(p.y);
      for (const double end : {p.low, p.high})
        if (!figure.log_y || end > 0.0) range.add(end);
    }
  for (const FigureLine& line : figure.lines)
    if (can_draw(figure, line)) range.add(line.y);
  range.pad(figure.log_y, 0.04);
  return range;
}

std::string script_number(double v) { return std::isfinite(v) ? fmt::format("{}", v) : "NaN"; }

// Everything of one legend entry in one panel.
struct Entry {
  std::vector<const FigureSeries*> series;
  FigureLook look;
};

std::vector<Entry> entries_of(const Figure& figure, std::size_t panel) {
  const std::vector<FigureLook> looks = looks_of(figure);
  std::vector<Entry> entries;
  for (std::size_t k = 0; k < figure.series.size(); ++k) {
    const FigureSeries& s = figure.series[k];
    if (s.panel != panel) continue;
    const auto same = std::ranges::find_if(entries, [&](const Entry& e) {
      return group_of(*e.series.front()) == group_of(s) && e.series.front()->style == s.style;
    });
    if (same == entries.end())
      entries.push_back({{&s}, looks[k]});
    else
      same->series.push_back(&s);
  }
  return entries;
}

std::size_t panels_of(const Figure& figure) { return std::max<std::size_t>(1, figure.panels.size()); }

// Panels with named rows stand side by side, so that the names stand once; in one column below each other.
std::size_t columns_of(const Figure& figure) {
  const std::size_t most = figure.width == FigureWidth::column ? 1
                           : figure.y_names.empty()            ? kPanelColumns
                                                               : panels_of(figure);
  return std::min(most, panels_of(figure));
}

std::size_t rows_of(const Figure& figure) {
  return (panels_of(figure) + columns_of(figure) - 1) / columns_of(figure);
}

// One a group that has points, of all panels.
std::vector<Entry> all_entries(const Figure& figure) {
  std::vector<Entry> entries;
  for (std::size_t p = 0; p < panels_of(figure); ++p)
    for (Entry& e : entries_of(figure, p)) {
      const bool is_drawn = std::ranges::any_of(e.series, [&](const FigureSeries* s) {
        return std::ranges::any_of(s->points,
                                   [&](const FigurePoint& point) { return can_draw(figure, point); });
      });
      const bool is_there = std::ranges::any_of(entries, [&](const Entry& other) {
        return group_of(*other.series.front()) == group_of(*e.series.front());
      });
      if (is_drawn && !is_there) entries.push_back(std::move(e));
    }
  return entries;
}

// Counts, between which no tick belongs.
bool has_whole_x(const Figure& figure) {
  return std::ranges::all_of(figure.series, [](const FigureSeries& s) {
    return std::ranges::all_of(s.points, [](const FigurePoint& p) { return p.x == std::round(p.x); });
  });
}

// Ticks at powers of ten or at round numbers, as many as there is room for.
double tick_step(const Range& range, bool logarithmic, double room_mm) {
  constexpr double kTick_mm = 10.0;
  const double most = std::max(2.0, room_mm / kTick_mm);
  if (logarithmic) return std::pow(10.0, std::max(1.0, std::ceil(std::log10(range.high / range.low) / most)));
  const double step = (range.high - range.low) / most, power = std::pow(10.0, std::floor(std::log10(step)));
  for (const double times : {1.0, 2.0, 5.0})
    if (step <= times * power) return times * power;
  return 10.0 * power;
}

std::string tick_names(const char* axis, const std::vector<std::string>& names, bool blank) {
  std::string text = fmt::format("set {}tics (", axis);
  for (std::size_t k = 0; k < names.size(); ++k)
    text += fmt::format("{}{} {}", k ? ", " : "", blank ? "''" : gnuplot_text(without_formats(names[k])), k);
  return text + ")\n";
}

class Script {
 public:
  explicit Script(const Figure& figure)
      : figure_(figure), size_(size_of(figure)), legend_(all_entries(figure)), x_(x_range(figure)) {
    std::set<std::string> bands;
    for (const FigureBand& band : figure.bands)
      if (bands.insert(band.name).second) band_names_.push_back(band.name);
    for (const Entry& e : legend_) legend_names_.push_back(group_of(*e.series.front()));
    for (const FigureLine& line : figure.lines)
      if (can_draw(figure, line)) lines_.push_back(line);
    for (const FigureLine& line : lines_) legend_names_.push_back(line.label);
    legend_names_.insert(legend_names_.end(), band_names_.begin(), band_names_.end());
  }

  std::string text() {
    text_ = settings() + layout();
    for (std::size_t p = 0; p < panels_of(figure_); ++p) add_panel(p);
    return text_ + "unset multiplot\n";
  }

 private:
  std::string settings() const {
    std::string text =
        "set encoding utf8\nset border 3 lc rgb '#333333' lw 0.6\n"
        "set tics nomirror noenhanced scale 0.5\nset grid xtics ytics lc rgb '#d8d8d8' lw 0.4 dt 1\n";
    if (figure_.log_x) text += "set logscale x\n";
    if (figure_.log_y) text += "set logscale y\n";
    if (!figure_.x_names.empty()) text += "set grid noxtics\n";
    if (!figure_.y_names.empty()) text += "set grid noytics\n";
    text += fmt::format("set xrange [{}:{}]\n", x_.low, x_.high);
    for (std::size_t k = 0; k < figure_.bands.size(); ++k)
      text += fmt::format(
          "set object {} rectangle from {}, graph 0 to {}, graph 1 behind fillcolor rgb '{}' fillstyle solid "
          "noborder\n",
          k + 1, figure_.bands[k].from, figure_.bands[k].to, kShade);
    return text;
  }

  // Legend above all panels, then their titles; room for names and numbers at their left and below.
  std::string layout() const {
    const double across = 1.0 / size_.width_mm, up = 1.0 / size_.height_mm;
    return fmt::format(
        "set multiplot layout {},{} margins {:.4f},{:.4f},{:.4f},{:.4f} spacing {:.4f},{:.4f}\n",
        rows_of(figure_), columns_of(figure_), across * left_mm(), 1.0 - across * kRight_mm, up * foot_mm(),
        1.0 - up * (static_cast<double>(legend_rows()) * kLine_mm + kTitle_mm), across * between_mm(),
        up * kBetweenRows_mm);
  }
  double left_mm() const {
    return figure_.y_names.empty() ? 18.0 : 3.0 + kLetter_mm * static_cast<double>(longest(figure_.y_names));
  }
  double between_mm() const { return figure_.y_names.empty() ? 12.0 : 4.0; }
  double foot_mm() const { return has_turned_names() ? 25.0 : 13.0; }
  double panel_width_mm() const {
    const auto columns = static_cast<double>(columns_of(figure_));
    return (size_.width_mm - left_mm() - kRight_mm - (columns - 1.0) * between_mm()) / columns;
  }
  bool has_turned_names() const {
    return kLetter_mm * static_cast<double>((longest(figure_.x_names) + 1) * figure_.x_names.size()) >
           panel_width_mm();
  }

  std::size_t legend_rows() const {
    if (legend_names_.size() < 2) return 0;
    const double entry_mm = kLetter_mm * static_cast<double>(longest(legend_names_)) + 18.0;
    const auto across = static_cast<std::size_t>(std::max(1.0, std::floor(size_.width_mm / entry_mm)));
    return (legend_names_.size() + across - 1) / across;
  }

  void add_panel(std::size_t panel) {
    plots_.clear();
    text_ += axes(panel);
    for (const Entry& e : entries_of(figure_, panel)) add_points(e);
    for (const FigureLine& line : lines_)
      plots_.push_back(fmt::format("{} with lines {} notitle", script_number(line.y), kLineLook));
    text_ += "unset key\n";
    if (panel == 0 && legend_rows() > 0) add_legend();
    if (plots_.empty()) plots_.push_back("NaN notitle");
    text_ += "plot ";
    for (std::size_t k = 0; k < plots_.size(); ++k) text_ += (k ? ", \\\n  " : "") + plots_[k];
    text_ += "\n";
  }

  std::string axes(std::size_t panel) const {
    const std::size_t columns = columns_of(figure_), column = panel % columns;
    const bool lowest = panel + columns >= panels_of(figure_), has_names = !figure_.y_names.empty();
    const Range y = y_range(figure_, panel);
    std::string text = has_names ? fmt::format("set yrange [{}:{}]\n", y.high, y.low)
                                 : fmt::format("set yrange [{}:{}]\n", y.low, y.high);
    if (!figure_.panels.empty())
      text += fmt::format("set title {} noenhanced offset 0,-0.6\n", gnuplot_text(figure_.panels[panel]));
    text += column == 0 ? fmt::format("set ylabel {} noenhanced\n", gnuplot_text(figure_.y_label))
                        : std::string("unset ylabel\n");
    if (has_names) text += tick_names("y", figure_.y_names, column > 0);
    if (!has_names && figure_.log_y) text += "set format y '%g'\n";
    text += lowest && column == (columns_of(figure_) - 1) / 2
                ? fmt::format("set xlabel {} noenhanced offset 0,0.4\n", gnuplot_text(figure_.x_label))
                : std::string("unset xlabel\n");
    if (!figure_.x_names.empty())
      return text + tick_names("x", figure_.x_names, !lowest) +
             (has_turned_names() ? "set xtics rotate by -30\n" : "");
    return text + fmt::format("set xtics {:g}\nset format x '{}'\n",
                              std::max(tick_step(x_, figure_.log_x, panel_width_mm()),
                                       has_whole_x(figure_) ? 1.0 : 0.0),
                              !lowest         ? ""
                              : figure_.log_x ? "%g"
                                              : "% h");
  }

  // Drawn with the first panel, for all.
  void add_legend() {
    text_ += fmt::format(
        "set key at screen {:.4f}, screen {:.4f} left top Left reverse noenhanced samplen 2 width 1 vertical "
        "maxrows {}\n",
        2.0 / size_.width_mm, 1.0 - 1.0 / size_.height_mm, legend_rows());
    const auto add = [&](const std::string& look, const std::string& name) {
      plots_.push_back("keyentry with " + look + " title " + gnuplot_text(name));
    };
    for (const Entry& e : legend_) add(drawn_as(e, kLargeDot), group_of(*e.series.front()));
    for (const FigureLine& line : lines_) add(std::string("lines ") + kLineLook, line.label);
    for (const std::string& name : band_names_)
      add(fmt::format("boxes fillstyle solid noborder lc rgb '{}'", kShade), name);
  }

  static std::string marks_of(const Entry& entry, double dot) {
    const bool hollow = entry.series.front()->hollow;
    return fmt::format("pt {} ps {}", hollow ? hollow_of(entry.look.marker) : entry.look.marker,
                       hollow ? 1.4 * dot : dot);
  }

  static std::string drawn_as(const Entry& entry, double dot) {
    const FigureSeries& s = *entry.series.front();
    const FigureLook& look = entry.look;
    const std::string dots = marks_of(entry, dot);
    if (s.style == Style::dots)
      return fmt::format("points {} lc rgb '{}'", dots,
                         dot == kLargeDot ? look.colour : "#60" + look.colour.substr(1));
    return fmt::format("{} lw {} dt {} lc rgb '{}'",
                       s.style == Style::line_and_dots ? "linespoints " + dots : std::string("lines"),
                       entry.series.size() > 1 ? 0.8 : 1.2, look.dash, look.colour);
  }

  // gnuplot's circle, triangle, square and so on without their filling.
  static int hollow_of(int marker) { return marker > 4 && marker % 2 == 1 ? marker - 1 : marker; }

  void add_points(const Entry& entry) {
    std::size_t most = 0;
    bool intervals = false;
    const std::string name = begin_block();
    for (const FigureSeries* s : entry.series) {
      most = std::max(most, s->points.size());
      bool gap = true;
      for (const FigurePoint& p : s->points) {
        intervals |= has_interval(figure_, p);
        const double here = figure_.y_names.empty() ? p.y : p.x;
        if (can_draw(figure_, p))
          row({p.x, p.y, has_interval(figure_, p) ? p.low : here, has_interval(figure_, p) ? p.high : here});
        else if (!gap)
          text_ += '\n';
        gap = !can_draw(figure_, p);
      }
      if (s != entry.series.back()) text_ += '\n';
    }
    end_block();
    if (intervals && entry.series.front()->style == Style::band)
      plots_.push_back(fmt::format(
          "{} using 1:3:4 with filledcurves lc rgb '{}' fillstyle transparent solid 0.2 noborder notitle",
          name, entry.look.colour));
    else if (intervals)
      plots_.push_back(
          fmt::format("{} using {} with vectors heads size screen 0.004,90 lw 0.8 lc rgb '{}' notitle", name,
                      figure_.y_names.empty() ? "1:3:(0):($4-$3)" : "3:2:($4-$3):(0)", entry.look.colour));
    plots_.push_back(fmt::format("{} using 1:2 with {} notitle", name,
                                 drawn_as(entry, most <= kFewPoints ? kLargeDot : kSmallDot)));
  }

  // Rows of a data block, which must not be empty; an empty row ends a line.
  std::string begin_block() {
    const std::string name = fmt::format("$d{}", blocks_++);
    text_ += name + " << EOD\n";
    empty_ = true;
    return name;
  }
  void row(std::initializer_list<double> values) {
    std::string line;
    for (double v : values) line += (line.empty() ? "" : " ") + script_number(v);
    text_ += line + '\n';
    empty_ = false;
  }
  void end_block() { text_ += empty_ ? "NaN NaN NaN NaN NaN NaN\nEOD\n" : "EOD\n"; }

  static constexpr double kRight_mm = 5.0;
  static constexpr const char* kLineLook = "lw 1 dt 2 lc rgb '#222222'";

  const Figure& figure_;
  FigureSize size_;
  std::vector<Entry> legend_;
  std::vector<FigureLine> lines_;
  std::vector<std::string> band_names_, legend_names_;
  Range x_;
  std::string text_;
  std::vector<std::string> plots_;
  std::size_t blocks_ = 0;
  bool empty_ = true;
};

}  // namespace

FigureSize size_of(const Figure& figure) {
  const bool narrow = figure.width == FigureWidth::column;
  FigureSize size{narrow ? kColumn_mm : kPage_mm, narrow ? 62.0 : 90.0};
  if (!figure.y_names.empty())
    size.height_mm = 30.0 + 4.4 * static_cast<double>(figure.y_names.size() * rows_of(figure)) +
                     kBetweenRows_mm * static_cast<double>(rows_of(figure) - 1);
  else if (!figure.panels.empty())
    size.height_mm = 24.0 + 50.0 * static_cast<double>(rows_of(figure));
  return size;
}

Figure narrow_figure(Figure figure) {
  figure.width = FigureWidth::column;
  return figure;
}

std::string gnuplot_script(const Figure& figure) { return Script(figure).text(); }

}  // namespace trilat
