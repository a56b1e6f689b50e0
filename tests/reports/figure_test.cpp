// SPDX-License-Identifier: MIT
#include "reports/figures/figure.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <regex>

#include <gmock/gmock.h>

#include "reports/figures/draw_figures.h"
#include "reports/figures/figure_look.h"
#include "reports/figures/figures.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Figure small_figure() {
  Figure figure;
  figure.id = "small-figure_1.5";
  figure.title = "A title";
  figure.x_label = "x (m)";
  figure.y_label = "y (cm)";
  figure.series = {{"dots", FigureSeries::Style::dots, {{0.0, 0.0}, {100.0, 6.0}}}};
  return figure;
}

FigureSeries line_of(const std::string& name, std::vector<FigurePoint> points) {
  return {name, FigureSeries::Style::line, std::move(points)};
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// The rows of the first data block.
std::vector<std::string> rows_of(const std::string& script) {
  std::vector<std::string> rows;
  const std::size_t begin = script.find("<< EOD\n") + 7;
  for (std::size_t at = begin; script.compare(at, 4, "EOD\n") != 0;) {
    const std::size_t end = script.find('\n', at);
    rows.push_back(script.substr(at, end - at));
    at = end + 1;
  }
  return rows;
}

DrawnFigure drawn(const Figure& figure) { return draw_figures({figure}).at(0); }

TEST(FigureScript, TheAxisEndsAFiftiethBeyondThePoints) {
  EXPECT_THAT(gnuplot_script(small_figure()), HasSubstr("set xrange [-2:102]"));
}

TEST(FigureScript, NothingInATextIsACommand) {
  Figure figure = small_figure();
  figure.x_label = "it's `date` and \"x\"\n; system 'y'";
  figure.series[0].name = "a'; set output 'b";
  figure.lines = {{1.0, "`c`"}};
  const std::string script = gnuplot_script(figure);
  EXPECT_THAT(script, AllOf(HasSubstr("set xlabel 'it''s `date` and \"x\" ; system ''y''' "),
                            HasSubstr("title 'a''; set output ''b'"), HasSubstr("title '`c`'")));
}

TEST(FigureScript, WhatIsNoNumberIsNotDrawnAndEndsALine) {
  Figure figure = small_figure();
  figure.series = {line_of("line", {{0.0, 1.0}, {1.0, kNan}, {2.0, kNan}, {3.0, 4.0}, {kNan, 5.0}})};
  EXPECT_THAT(rows_of(gnuplot_script(figure)), ElementsAre("0 1 1 1", "", "3 4 4 4", ""));
}

TEST(FigureScript, ALogAxisLeavesOutWhatIsNotAboveZero) {
  Figure figure = small_figure();
  figure.log_y = true;
  figure.series[0].points = {{0.0, 0.0}, {50.0, -1.0}, {100.0, 6.0, -1.0, 7.0}};
  const std::string script = gnuplot_script(figure);
  EXPECT_THAT(rows_of(script), ElementsAre("100 6 6 6"));  // an interval that goes below zero has no place
  EXPECT_THAT(script, Not(HasSubstr("with vectors")));
}

TEST(FigureScript, SeriesOfOneGroupAreOneEntryOfTheLegend) {
  Figure figure = small_figure();
  figure.series = {line_of("unit 0", {{0.0, 1.0}, {1.0, 2.0}}), line_of("unit 1", {{0.0, 2.0}, {1.0, 3.0}})};
  figure.series[0].group = figure.series[1].group = "depth";
  const std::string script = gnuplot_script(figure);
  EXPECT_EQ(occurrences(script, "set label 'depth'"), 1u);  // at the end of the line
  EXPECT_THAT(rows_of(script), ElementsAre("0 1 1 1", "1 2 2 2", "", "0 2 2 2", "1 3 3 3"));
}

TEST(FigureScript, BandsOfOneNameAreOneEntryOfTheLegend) {
  Figure figure = small_figure();
  figure.bands = {{0.0, 10.0, "worse"}, {50.0, 60.0, "worse"}};
  const std::string script = gnuplot_script(figure);
  EXPECT_EQ(occurrences(script, "rectangle from"), 2u);
  EXPECT_EQ(occurrences(script, "title 'worse'"), 1u);
}

TEST(FigureScript, NamesStandAtTheTicks) {
  Figure figure = small_figure();
  figure.x_names = {"head", "wrist"};
  EXPECT_THAT(gnuplot_script(figure), HasSubstr("set xtics ('head' 0, 'wrist' 1)"));
}

TEST(FigureScript, AMapCutsWhatLiesBeyondItsColours) {
  Figure figure = small_figure();
  figure.map =
      FigureMap{{0.0, 1.0}, {5.0}, {std::numeric_limits<double>::infinity(), kNan}, "GDOP", 1.0, 10.0};
  EXPECT_THAT(rows_of(gnuplot_script(figure)), ElementsAre("0 5 10", "1 5 NaN", ""));
}

TEST(FigureLook, AMethodLooksTheSameInEveryFigure) {
  Figure one = small_figure(), other = small_figure();
  one.series = {line_of("truth", {}), line_of("linear", {}), line_of("nonlinear", {})};
  other.series = {line_of("something", {}), line_of("nonlinear", {})};
  for (Figure* figure : {&one, &other})
    for (FigureSeries& s : figure->series)
      if (s.name != "something") s.method = s.name;
  const auto a = looks_of(one), b = looks_of(other);
  EXPECT_EQ(a[2].colour, b[1].colour);
  EXPECT_EQ(a[0].colour, "#000000");
  EXPECT_NE(b[0].colour, b[1].colour);
}

TEST(FigureLook, VariantsShareAColourAndDifferInTheirDash) {
  const FigureLook plain = look_of_method("nonlinear");
  for (const char* variant : {"nonlinear as printed", "nonlinear, occlusion corrected"}) {
    EXPECT_EQ(look_of_method(variant).colour, plain.colour) << variant;
    EXPECT_NE(look_of_method(variant).dash, plain.dash) << variant;
  }
  EXPECT_NE(look_of_method("linear").colour, plain.colour);
  EXPECT_EQ(look_of_method("tracked_mean").dash, look_of_method("tracked mean").dash);
  EXPECT_NE(look_of_method("meander").colour, look_of_method("mean").colour);  // whole words only
}

double luminance(const std::string& colour) {
  double sum = 0.0;
  constexpr double kWeights[3] = {0.2126, 0.7152, 0.0722};
  for (std::size_t k = 0; k < 3; ++k) {
    const double c = std::stoi(colour.substr(1 + 2 * k, 2), nullptr, 16) / 255.0;
    sum += kWeights[k] * (c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return sum;
}

double contrast(const std::string& a, const std::string& b) {
  const double x = luminance(a) + 0.05, y = luminance(b) + 0.05;
  return std::max(x, y) / std::min(x, y);
}

TEST(FigureLook, ColoursStandOutFromLightAndDarkPages) {
  for (const char* method : {"linear", "geometric", "nonlinear", "mean", "median", "window", "single", "rts"})
    for (const char* page : {"#ffffff", "#15171b"})
      EXPECT_GE(contrast(look_of_method(method).colour, page), 3.0) << method << " on " << page;
}

TEST(FigureSvg, EveryMarkerOfTheLegendIsInThePlotAlsoWithIntervals) {
  Figure figure = small_figure();
  FigureSeries dots{"dots", FigureSeries::Style::dots, {}};
  FigureSeries line{"line", FigureSeries::Style::line_and_dots, {}};
  for (int i = 0; i < 5; ++i) {
    dots.points.push_back({1.0 * i, 2.0 + i, 1.5 + i, 2.5 + i});
    line.points.push_back({1.0 * i, 9.0 - i, 8.5 - i, 9.5 - i});
  }
  figure.series = {dots, line};
  const std::string svg = drawn(figure).svg;
  std::map<std::string, int> markers;
  const std::regex use("<use xlink:href='#(gp[A-Za-z0-9]+)'[^>]*color='([^']*)'");
  for (std::sregex_iterator m(svg.begin(), svg.end(), use), end; m != end; ++m)
    ++markers[(*m)[1].str() + (*m)[2].str()];
  EXPECT_THAT(markers, testing::SizeIs(2));
  for (const auto& [marker, count] : markers) EXPECT_EQ(count, 5 + 1) << marker;  // and one in the legend
}

TEST(Figure, ItsNumbersAreUnroundedAndMissingOnesEmpty) {
  Figure figure = small_figure();
  figure.series = {{"a, b", FigureSeries::Style::dots, {{1.0 / 3.0, 2.0}, {1.0, kNan}}}};
  EXPECT_EQ(csv_of(figure), "series,x (m),y (cm)\r\n\"a, b\",0.3333333333333333,2\r\n\"a, b\",1,\r\n");
}

TEST(Figure, NumbersOfIntervalsNamesAndMapsAreThereToo) {
  Figure figure = small_figure();
  figure.x_names = {"head", "wrist"};
  figure.series = {{"a", FigureSeries::Style::dots, {{1.2, 3.0, 2.0, 4.0}}}};
  EXPECT_EQ(csv_of(figure), "series,x (m),y (cm),low (cm),high (cm)\r\na,wrist,3,2,4\r\n");
  figure = small_figure();
  figure.map = FigureMap{{0.5}, {5.0}, {2.0}, "GDOP"};
  EXPECT_EQ(csv_of(figure), "series,x (m),y (cm),GDOP\r\ndots,0,0,\r\ndots,100,6,\r\nGDOP,0.5,5,2\r\n");
}

TEST(DrawFigures, EveryStyleIsDrawnAsSvgAndAsPdf) {
  Figure figure = small_figure();
  figure.x_names = {"head", "wrist"};
  figure.lines = {{3.0, "limit"}};
  figure.bands = {{0.2, 0.4, "good"}};
  figure.series = {{"dots", FigureSeries::Style::dots, {{1.0, 3.0, 2.0, 4.0}}},
                   line_of("line", {{0.0, 1.0}, {1.0, 2.0}}),
                   {"both", FigureSeries::Style::line_and_dots, {{0.0, 1.0}, {1.0, 2.0}}}};
  const DrawnFigure picture = drawn(figure);
  for (const char* name : {"dots", "line", "both", "limit", "good", "head"})
    EXPECT_NE(picture.svg.find(std::string(">") + name + "<"), std::string::npos) << name;
  EXPECT_EQ(picture.svg.find("A title"), std::string::npos);  // stands around the picture
  EXPECT_THAT(picture.pdf, StartsWith("%PDF"));
}

TEST(DrawFigures, EqualFiguresGiveEqualBytes) {
  const auto first = draw_figures({small_figure(), small_figure()}), second = draw_figures({small_figure()});
  EXPECT_EQ(first[0].svg, second[0].svg);
  EXPECT_EQ(first[0].pdf, second[0].pdf);
  EXPECT_EQ(first[0].svg, first[1].svg);  // nothing is left over from one to the next
}

TEST(DrawFigures, AFigureWithoutNumbersIsDrawnWithItsAxes) {
  Figure figure = small_figure();
  figure.log_y = figure.log_x = true;
  figure.series = {line_of("nothing", {}), {"no dots", FigureSeries::Style::dots, {}}};
  EXPECT_THAT(drawn(Figure{}).svg, HasSubstr("</svg>"));
  EXPECT_THAT(drawn(figure).svg, HasSubstr("nothing"));
  EXPECT_THAT(draw_figures({}), IsEmpty());
}

TEST(DrawFigures, NoDiskIsNeeded) {
  const char* before = std::getenv("TMPDIR");
  const std::string folder = before ? before : "";
  ::setenv("TMPDIR", "/dev/full", 1);
  EXPECT_THAT(drawn(small_figure()).svg, HasSubstr("</svg>"));
  before ? ::setenv("TMPDIR", folder.c_str(), 1) : ::unsetenv("TMPDIR");
}

TEST(DrawFigures, TextIsEscaped) {
  Figure figure = small_figure();
  figure.x_label = "a < b & c > d `touch x`";
  figure.series[0].name = "<b>_{x}";
  const std::string svg = drawn(figure).svg;
  for (const char* text : {">a &lt; b &amp; c > d `touch x`<", ">&lt;b>_{x}<"})
    EXPECT_NE(svg.find(text), std::string::npos) << text;
}

TEST(DrawFigures, NothingIsFetchedFromElsewhere) {
  const std::string svg = drawn(small_figure()).svg;
  EXPECT_FALSE(std::regex_search(svg, std::regex("(xlink:href|src|href)\\s*=\\s*[\"']?(http|file|//)")));
}

HistoryEntry night_of(const std::string& day, double error_m) {
  HistoryEntry night;
  night.time = day + "T03:00:00Z";
  night.error_m = {{"walk | mean | walking | average", error_m}, {"walk | mean | walking | head", 1.0}};
  return night;
}

TEST(HistoryFigure, HasTheAveragesByNightAndShadesWhatWasAccepted) {
  History history;
  history.entries = {night_of("2026-01-01", 0.05), night_of("2026-01-02", 0.06)};
  history.entries[0].accepted = true;
  history.entries[0].reason = "the first night";
  const auto figure = history_figure(history);
  ASSERT_TRUE(figure);
  EXPECT_THAT(figure->x_names, ElementsAre("2026-01-01", "2026-01-02"));
  ASSERT_EQ(figure->series.size(), 1u);
  EXPECT_DOUBLE_EQ(figure->series[0].points[1].y, 6.0);
  ASSERT_EQ(figure->bands.size(), 1u);
  EXPECT_THAT(history_sentences(history),
              ElementsAre(HasSubstr("2026-01-02: quiet"), HasSubstr("2026-01-01: the first night")));
  history.entries[1].alarms = {"worse"};
  EXPECT_THAT(history_sentences(history)[0], HasSubstr("1 alarm**, the first: worse"));
  EXPECT_FALSE(history_figure({}));
}

TEST(FigureScript, PanelsShareTheirAxesAndHaveOneLegend) {
  Figure figure = small_figure();
  figure.panels = {"one", "two"};
  figure.series = {line_of("a", {{0.0, 1.0}, {1.0, 2.0}}), line_of("b", {{0.0, 10.0}, {1.0, 20.0}})};
  figure.series[1].panel = 1;
  const std::string script = gnuplot_script(figure);
  EXPECT_THAT(script,
              AllOf(HasSubstr("set multiplot"), HasSubstr("set title 'one'"), HasSubstr("set title 'two'")));
  EXPECT_EQ(occurrences(script, "set yrange ["), 1u);
  for (const char* name : {"set label 'a' at screen", "set label 'b' at screen"})
    EXPECT_EQ(occurrences(script, name), 1u);
  EXPECT_THAT(drawn(figure).svg, HasSubstr(">x (m)<"));
}

TEST(FigureScript, OnePanelHasItsLegendToo) {
  Figure figure = small_figure();
  figure.panels = {"one"};
  figure.series = {line_of("a", {{0.0, 1.0}, {1.0, 2.0}}), line_of("b", {{0.0, 10.0}, {1.0, 20.0}})};
  const std::string svg = drawn(figure).svg;
  for (const char* text : {">one<", ">a<", ">b<"}) EXPECT_EQ(occurrences(svg, text), 1u) << text;
}

TEST(FigureScript, NamedRowsHaveTheirIntervalsAlongTheNumbers) {
  Figure figure = small_figure();
  figure.y_names = {"best", "worst"};
  figure.series = {{"ours", FigureSeries::Style::dots, {{2.0, 0.0, 1.5, 2.5}, {4.0, 1.0}}}};
  const std::string script = gnuplot_script(figure);
  EXPECT_THAT(rows_of(script), ElementsAre("2 0 1.5 2.5", "4 1 4 4"));
  EXPECT_THAT(script,
              AllOf(HasSubstr("using 3:2:($4-$3):(0) with vectors"), HasSubstr("set yrange [1.6:-0.6]")));
  EXPECT_EQ(csv_of(figure),
            "series,x (m),y (cm),low (m),high (m)\r\nours,2,best,1.5,2.5\r\nours,4,worst,,\r\n");
}

}  // namespace
}  // namespace trilat
