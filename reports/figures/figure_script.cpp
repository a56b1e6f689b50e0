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
constexpr double kLetter_mm = 1.55, kLine_mm = 3.6;  // of 8 pt: a wide letter's width, a line's height
constexpr std::size_t kMostDirect = 8;               // lines with their names at their ends
constexpr std::size_t kFewPoints = 30;               // are drawn large
constexpr double kSmallDot = 0.4, kLargeDot = 0.55;
constexpr const char* kShade = "#e4e4e4";
constexpr std::size_t kPanelColumns = 3;

using Style = FigureSeries::Style;

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

bool has_interval(const Figure& figure, const FigurePoint& p) {
  return can_draw(figure, p) && std::isfinite(p.low) && std::isfinite(p.high) &&
         !((figure.y_names.empty() ? figure.log_y : figure.log_x) && p.low <= 0.0);
}

bool is_line(const FigureSeries& s) {
  return s.style == Style::line || s.style == Style::line_and_dots || s.style == Style::band;
}

std::size_t longest(const std::vector<std::string>& names) {
  std::size_t most = 0;
  for (const std::string& name : names) most = std::max(most, width_of(name));
  return most;
}

// What an axis shows.
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
  // 0 at the low end, 1 at the high one.
  double place(double value, bool logarithmic) const {
    return logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
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

Range y_range(const Figure& figure) {
  if (!figure.y_names.empty()) return names_range(figure.y_names);
  Range range;
  for (const FigureSeries& s : figure.series)
    for (const FigurePoint& p : s.points) {
      if (!can_draw(figure, p)) continue;
      range.add(p.y);
      for (const double end : {p.low, p.high})
        if (!figure.log_y || end > 0.0) range.add(end);
    }
  for (const FigureLine& line : figure.lines)
    if (!figure.log_y || line.y > 0.0) range.add(line.y);
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

// Panels with named rows stand side by side, so that the names stand once.
std::size_t columns_of(const Figure& figure) {
  const std::size_t most = figure.y_names.empty() ? kPanelColumns : panels_of(figure);
  return std::min(most, panels_of(figure));
}

// Names of a few lines stand at their ends instead of in a legend.
bool names_at_ends(const Figure& figure) {
  std::set<std::string> groups;
  for (const FigureSeries& s : figure.series) {
    if (!is_line(s)) return false;
    groups.insert(group_of(s));
  }
  return figure.bands.empty() && !groups.empty() && groups.size() + figure.lines.size() <= kMostDirect &&
         figure.panels.empty();
}

class Script {
 public:
  explicit Script(const Figure& figure)
      : figure_(figure),
        size_(size_of(figure)),
        x_(x_range(figure)),
        y_(y_range(figure)),
        direct_(names_at_ends(figure)) {}

  std::string text() {
    text_ = settings();
    const std::size_t panels = panels_of(figure_);
    if (panels > 1) text_ += "set multiplot\n";
    for (std::size_t p = 0; p < panels; ++p) add_panel(p);
    if (panels > 1) text_ += "unset multiplot\n";
    return text_;
  }

 private:
  std::string settings() const {
    std::string text = fmt::format(
        "set encoding utf8\nset xlabel {} noenhanced\nset ylabel {} noenhanced\nset border 3 lc rgb "
        "'#333333' lw 0.6\n"
        "set tics nomirror noenhanced scale 0.5\nset grid xtics ytics lc rgb '#d8d8d8' lw 0.4 dt 1\nset "
        "key outside above left Left reverse noenhanced samplen 2 width 1\n",
        gnuplot_text(figure_.x_label), gnuplot_text(figure_.y_label));
    if (direct_) text += "unset key\n";
    if (figure_.log_x)
      text += "set logscale x\nset format x '%g'\n" + decades("x", x_, panel_width_mm() / 10.0);
    if (figure_.log_y) text += "set logscale y\nset format y '%g'\n";
    if (!figure_.x_names.empty()) {
      text += "set grid noxtics\n" + ticks("x", figure_.x_names);
      const double room_mm = (size_.width_mm - 18.0) / static_cast<double>(columns_of(figure_));
      if (static_cast<double>(longest(figure_.x_names) + 1) * kLetter_mm *
              static_cast<double>(figure_.x_names.size()) >
          room_mm)
        text += "set xtics rotate by -30\n";
    }
    if (!figure_.y_names.empty())
      text += "set grid noytics\n" + ticks("y", figure_.y_names) + steps("x", x_, panel_width_mm() / 9.0);
    text +=
        fmt::format("set xrange [{}:{}]\nset yrange [{}:{}]\n", x_.low, x_.high,
                    figure_.y_names.empty() ? y_.low : y_.high, figure_.y_names.empty() ? y_.high : y_.low);
    for (std::size_t k = 0; k < figure_.bands.size(); ++k)
      text += fmt::format(
          "set object {} rectangle from {}, graph 0 to {}, graph 1 behind fillcolor rgb '{}' fillstyle solid "
          "noborder\n",
          k + 1, figure_.bands[k].from, figure_.bands[k].to, kShade);
    return text;
  }

  // So many powers of ten as there is room for.
  static std::string decades(const char* axis, const Range& range, double room) {
    const double step = std::ceil(std::log10(range.high / range.low) / std::max(1.0, room));
    return step > 1.0 ? fmt::format("set {}tics {:g}\n", axis, std::pow(10.0, step)) : std::string();
  }

  // Round numbers, as many as there is room for.
  static std::string steps(const char* axis, const Range& range, double room) {
    const double step = (range.high - range.low) / std::max(2.0, room);
    const double power = std::pow(10.0, std::floor(std::log10(step)));
    const double times = step / power <= 1.0   ? 1.0
                         : step / power <= 2.0 ? 2.0
                         : step / power <= 5.0 ? 5.0
                                               : 10.0;
    return fmt::format("set {}tics {:g}\n", axis, times * power);
  }

  double panel_width_mm() const {
    const double names_mm = kLetter_mm * static_cast<double>(longest(figure_.y_names));
    return (size_.width_mm - 18.0 - names_mm) / static_cast<double>(columns_of(figure_)) - 4.0;
  }

  static std::string ticks(const char* axis, const std::vector<std::string>& names) {
    std::string text = fmt::format("set {}tics (", axis);
    for (std::size_t k = 0; k < names.size(); ++k)
      text += fmt::format("{}{} {}", k ? ", " : "", gnuplot_text(without_formats(names[k])), k);
    return text + ")\n";
  }

  void add_panel(std::size_t panel) {
    plots_.clear();
    titled_ = !direct_ && figure_.panels.empty();
    if (!figure_.panels.empty()) place_panel(panel);
    const std::vector<Entry> entries = entries_of(figure_, panel);
    for (const Entry& e : entries) add_points(e);
    for (const FigureLine& line : figure_.lines)
      if (!figure_.log_y || line.y > 0.0)
        plots_.push_back(fmt::format("{} with lines lw 1 dt 2 lc rgb '#222222' {}", script_number(line.y),
                                     title_of(line.label)));
    if (titled_) {
      std::set<std::string> named;
      for (const FigureBand& band : figure_.bands)
        if (named.insert(band.name).second)
          plots_.push_back(fmt::format("keyentry with boxes fillstyle solid noborder lc rgb '{}' title {}",
                                       kShade, gnuplot_text(band.name)));
    }
    if (direct_) name_ends(entries);
    if (plots_.empty()) plots_.push_back("NaN notitle");
    text_ += "plot ";
    for (std::size_t k = 0; k < plots_.size(); ++k) text_ += (k ? ", \\\n  " : "") + plots_[k];
    text_ += panel == 0 && !figure_.panels.empty() ? "\nunset label\nunset arrow\n" : "\n";
  }

  std::string title_of(const std::string& name) const {
    return titled_ ? "title " + gnuplot_text(name) : std::string("notitle");
  }

  // Margins in the whole figure's units; the legend stands above all of them.
  void place_panel(std::size_t panel) {
    const std::size_t columns = columns_of(figure_), rows = (panels_of(figure_) + columns - 1) / columns;
    const std::size_t column = panel % columns, row = panel / columns;
    const double left_mm =
        figure_.y_names.empty() ? 15.0 : 3.0 + kLetter_mm * static_cast<double>(longest(figure_.y_names));
    const double gap_mm = 4.0, head_mm = 5.0, foot_mm = 12.0, legend_mm = legend_rows() * kLine_mm;
    const double width_mm = (size_.width_mm - left_mm - 3.0 - gap_mm * static_cast<double>(columns - 1)) /
                            static_cast<double>(columns);
    const double height_mm = (size_.height_mm - legend_mm - foot_mm - head_mm * static_cast<double>(rows)) /
                             static_cast<double>(rows);
    const double x_mm = left_mm + static_cast<double>(column) * (width_mm + gap_mm);
    const double top_mm =
        legend_mm + head_mm * static_cast<double>(row + 1) + height_mm * static_cast<double>(row);
    const bool lowest = row + 1 == rows || panel + columns >= panels_of(figure_);
    text_ += fmt::format(
        "set lmargin at screen {:.4f}\nset rmargin at screen {:.4f}\nset tmargin at screen {:.4f}\nset "
        "bmargin at screen {:.4f}\nset title {} noenhanced offset 0,-0.8\n",
        x_mm / size_.width_mm, (x_mm + width_mm) / size_.width_mm, 1.0 - top_mm / size_.height_mm,
        1.0 - (top_mm + height_mm) / size_.height_mm, gnuplot_text(figure_.panels[panel]));
    if (figure_.y_names.empty())
      text_ += column == 0 ? fmt::format("set ylabel {} noenhanced\nset format y '{}'\n",
                                         gnuplot_text(figure_.y_label), figure_.log_y ? "%g" : "% h")
                           : std::string("unset ylabel\nset format y ''\n");
    else if (column > 0)
      text_ += "unset ylabel\nset ytics format ''\n" + blank_ticks(figure_.y_names.size());
    if (figure_.x_names.empty())
      text_ += fmt::format("set format x '{}'\n", lowest ? (figure_.log_x ? "%g" : "% h") : "");
    text_ += lowest && column == columns / 2
                 ? "set xlabel " + gnuplot_text(figure_.x_label) + " noenhanced offset 0,0.5\n"
                 : std::string("unset xlabel\n");
    text_ += "unset key\n";
    if (panel == 0) add_legend();
  }

  // The legend of all panels, in lines above them.
  void add_legend() {
    const std::vector<Entry> entries = all_entries();
    const std::size_t across = legend_columns();
    for (std::size_t k = 0; k < entries.size() && entries.size() > 1; ++k) {
      const double x_mm = 3.0 + static_cast<double>(k % across) * legend_entry_mm(),
                   y_mm = kLine_mm * (static_cast<double>(k / across) + 0.6);
      const auto at = [&](double off_mm) {
        return fmt::format("screen {:.4f}, screen {:.4f}", (x_mm + off_mm) / size_.width_mm,
                           1.0 - y_mm / size_.height_mm);
      };
      const Entry& e = entries[k];
      text_ += fmt::format("set label {} at {} left noenhanced\n", gnuplot_text(group_of(*e.series.front())),
                           at(6.0));
      if (e.series.front()->style != Style::dots)
        text_ += fmt::format("set arrow from {} to {} nohead lw 1.2 dt {} lc rgb '{}'\n", at(0.0), at(4.5),
                             e.look.dash, e.look.colour);
      if (!is_line(*e.series.front()) || e.series.front()->style == Style::line_and_dots)
        text_ += fmt::format("set label '' at {} point {}\n", at(2.2),
                             marks_of(e, kLargeDot) + " lc rgb '" + e.look.colour + "'");
    }
  }

  // One a group, of all panels.
  std::vector<Entry> all_entries() const {
    std::vector<Entry> entries;
    for (std::size_t p = 0; p < panels_of(figure_); ++p)
      for (Entry& e : entries_of(figure_, p))
        if (std::ranges::none_of(entries, [&](const Entry& other) {
              return group_of(*other.series.front()) == group_of(*e.series.front());
            }))
          entries.push_back(std::move(e));
    return entries;
  }

  static std::string blank_ticks(std::size_t count) {
    std::string text = "set ytics (";
    for (std::size_t k = 0; k < count; ++k) text += fmt::format("{}'' {}", k ? ", " : "", k);
    return text + ")\n";
  }

  double legend_entry_mm() const {
    std::size_t characters = 0;
    for (const FigureSeries& s : figure_.series) characters = std::max(characters, width_of(group_of(s)));
    return kLetter_mm * static_cast<double>(characters) + 9.0;
  }
  std::size_t legend_columns() const {
    return static_cast<std::size_t>(std::max(1.0, std::floor((size_.width_mm - 4.0) / legend_entry_mm())));
  }
  double legend_rows() const {
    const std::size_t entries = all_entries().size(), across = legend_columns();
    return entries < 2 ? 0.0 : static_cast<double>((entries + across - 1) / across);
  }

  // Each name beside the last point of its first line, moved apart where they would lie on each other.
  void name_ends(const std::vector<Entry>& entries) {
    struct End {
      double place = 0.0;
      std::string name, colour;
    };
    std::vector<End> ends;
    const auto add = [&](double y, const std::string& name, const std::string& colour) {
      ends.push_back({y_.place(y, figure_.log_y), name, colour});
    };
    for (const Entry& e : entries) {
      const FigurePoint* last = nullptr;
      for (const FigurePoint& p : e.series.front()->points)
        if (can_draw(figure_, p) && (!last || p.x > last->x)) last = &p;
      if (last) add(last->y, group_of(*e.series.front()), e.look.colour);
    }
    for (const FigureLine& line : figure_.lines)
      if (!figure_.log_y || line.y > 0.0) add(line.y, line.label, "#222222");
    std::ranges::stable_sort(ends, {}, &End::place);
    const double gap = kLine_mm / (size_.height_mm - 14.0);
    for (std::size_t k = 1; k < ends.size(); ++k)
      ends[k].place = std::max(ends[k].place, ends[k - 1].place + gap);
    double most = 1.0;
    for (std::size_t k = ends.size(); k-- > 0; most -= gap)
      ends[k].place = most = std::min(ends[k].place, most);
    std::vector<std::string> names;
    for (const End& end : ends) {
      names.push_back(end.name);
      text_ += fmt::format("set label {} at graph 1.015, graph {:.4f} left noenhanced textcolor rgb '{}'\n",
                           gnuplot_text(end.name), end.place, end.colour);
    }
    text_ += fmt::format("set rmargin at screen {:.4f}\n",
                         1.0 - (4.0 + kLetter_mm * static_cast<double>(longest(names))) / size_.width_mm);
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
    plots_.push_back(fmt::format("{} using 1:2 with {} {}", name,
                                 drawn_as(entry, most <= kFewPoints ? kLargeDot : kSmallDot),
                                 title_of(group_of(*entry.series.front()))));
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

  const Figure& figure_;
  FigureSize size_;
  Range x_, y_;
  bool direct_, titled_ = true, empty_ = true;
  std::string text_;
  std::vector<std::string> plots_;
  std::size_t blocks_ = 0;
};

}  // namespace

FigureSize size_of(const Figure& figure) {
  const bool narrow = figure.width == FigureWidth::column;
  FigureSize size{narrow ? kColumn_mm : kPage_mm, narrow ? 62.0 : 90.0};
  const auto rows = static_cast<double>((panels_of(figure) + columns_of(figure) - 1) / columns_of(figure));
  if (!figure.y_names.empty())
    size.height_mm = 26.0 + 4.4 * static_cast<double>(figure.y_names.size());
  else if (!figure.panels.empty())
    size.height_mm = 18.0 + 48.0 * rows;
  return size;
}

std::string gnuplot_script(const Figure& figure) { return Script(figure).text(); }

}  // namespace trilat
