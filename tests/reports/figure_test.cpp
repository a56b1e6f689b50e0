// SPDX-License-Identifier: MIT
#include "reports/figure.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "reports/figure_axis.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> labels_of(const FigureAxis& axis) {
  std::vector<std::string> labels;
  for (const AxisTick& tick : axis.ticks)
    if (!tick.label.empty()) labels.push_back(tick.label);
  return labels;
}

Figure small_figure() {
  Figure figure;
  figure.id = "small";
  figure.title = "A title";
  figure.x_label = "x (m)";
  figure.y_label = "y (cm)";
  figure.series = {{"dots", FigureSeries::Style::dots, {{0.0, 0.0}, {100.0, 6.0}}, {}}};
  return figure;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(FigureAxis, TicksAreOneTwoOrFiveApart) {
  EXPECT_THAT(labels_of(linear_axis({0.0, 6.0})), ElementsAre("0", "1", "2", "3", "4", "5", "6"));
  EXPECT_THAT(labels_of(linear_axis({0.0, 7.0})), ElementsAre("0", "2", "4", "6", "8"));
  EXPECT_THAT(labels_of(linear_axis({0.0, 30.0})), ElementsAre("0", "5", "10", "15", "20", "25", "30"));
  EXPECT_THAT(labels_of(linear_axis({-0.1, 0.5})),
              ElementsAre("-0.1", "0.0", "0.1", "0.2", "0.3", "0.4", "0.5"));
}

TEST(FigureAxis, ATightAxisEndsAFiftiethBeyondTheValues) {
  const FigureAxis axis = linear_axis_tight({0.0, 100.0});
  EXPECT_DOUBLE_EQ(axis.low, -2.0);
  EXPECT_DOUBLE_EQ(axis.high, 102.0);
  EXPECT_THAT(labels_of(axis), ElementsAre("0", "20", "40", "60", "80", "100"));
}

TEST(FigureAxis, ALogAxisEndsAtOneTwoOrFive) {
  const FigureAxis axis = log_axis({0.3, 40.0, 0.0, -1.0, kNan});
  EXPECT_DOUBLE_EQ(axis.low, 0.2);
  EXPECT_DOUBLE_EQ(axis.high, 50.0);
  EXPECT_THAT(labels_of(axis), ElementsAre("0.2", "0.5", "1", "2", "5", "10", "20", "50"));
  EXPECT_NEAR(axis.at(std::sqrt(0.2 * 50.0)), 0.5, 1e-12);
}

TEST(FigureAxis, ALogAxisOfManyDecadesLabelsPowersOfTenOnly) {
  EXPECT_THAT(labels_of(log_axis({0.01, 10000.0})),
              ElementsAre("0.01", "0.1", "1", "10", "100", "1000", "10000"));
}

TEST(FigureAxis, OneValueOrNoneStillSpansSomething) {
  for (const std::vector<double>& values :
       {std::vector<double>{}, {kNan}, {0.0}, {5.0}, {-3.0}, {10.0, 10.0}})
    for (const FigureAxis& axis : {linear_axis(values), linear_axis_tight(values), log_axis(values)}) {
      EXPECT_LT(axis.low, axis.high);
      EXPECT_GE(axis.ticks.size(), 2u);
      for (const AxisTick& tick : axis.ticks) {
        EXPECT_GE(axis.at(tick.value), -1e-9);
        EXPECT_LE(axis.at(tick.value), 1.0 + 1e-9);
      }
    }
}

// The axis spans -2 to 102 over 664 px from 72 px on; a title line and a legend row lie above 65 px.
TEST(Figure, ABandLiesWhereItsEndsAre) {
  Figure figure = small_figure();
  figure.bands = {{10.0, 60.0, "a band"}};
  EXPECT_THAT(svg_of(figure), HasSubstr("<rect x=\"148.62\" y=\"65.00\" width=\"319.23\" height=\"360.00\""));
}

TEST(Figure, ABandBeyondTheAxisIsCutAndOneOutsideIsLeftOut) {
  Figure figure = small_figure();
  figure.bands = {{50.0, 1e9, "a band"}};
  EXPECT_THAT(svg_of(figure), HasSubstr("<rect x=\"404.00\" y=\"65.00\" width=\"332.00\" height=\"360.00\""));
  const std::size_t plain = count_of(svg_of(figure), "<rect");
  figure.bands = {{200.0, 300.0, "a band"}};
  EXPECT_EQ(count_of(svg_of(figure), "<rect"), plain - 1);
}

// y spans 0 to 6 over 360 px that end at 425 px.
TEST(Figure, AReferenceLineLiesAtItsValueAndWidensTheAxis) {
  Figure figure = small_figure();
  figure.lines = {{3.0, "limit"}};
  EXPECT_THAT(svg_of(figure), AllOf(HasSubstr("M72.00 245.00h664.00\" fill=\"none\" stroke=\"#222222\""),
                                    HasSubstr(">limit</text>")));
  figure.lines = {{12.0, "limit"}};
  EXPECT_THAT(svg_of(figure), HasSubstr(">12</text>"));
}

TEST(Figure, TextIsEscaped) {
  Figure figure = small_figure();
  figure.title = "a < b & \"c\" > d\n";
  figure.series[0].name = "<script>";
  const std::string svg = svg_of(figure);
  EXPECT_THAT(svg, AllOf(HasSubstr("a &lt; b &amp; &quot;c&quot; &gt; d"), HasSubstr("&lt;script&gt;"),
                         Not(HasSubstr("<script"))));
}

TEST(Figure, WhatIsNoNumberIsNotDrawn) {
  Figure figure = small_figure();
  figure.series[0].points.push_back({50.0, kNan});
  figure.series[0].points.push_back({kNan, 5.0});
  figure.series[0].points.push_back({std::numeric_limits<double>::infinity(), 5.0});
  const std::string svg = svg_of(figure);
  EXPECT_THAT(svg, AllOf(Not(HasSubstr("nan")), Not(HasSubstr("inf\""))));
  EXPECT_EQ(svg, svg_of(small_figure()));
}

TEST(Figure, ALogAxisLeavesOutWhatIsNotAboveZero) {
  Figure figure = small_figure();
  figure.log_y = true;
  figure.series[0].points.push_back({50.0, -1.0});
  const std::string svg = svg_of(figure);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_EQ(count_of(svg, "<circle"), 2u);  // one in the legend
}

TEST(Figure, AMissingPointEndsALine) {
  Figure figure = small_figure();
  figure.series = {
      {"line", FigureSeries::Style::line, {{0.0, 1.0}, {1.0, 2.0}, {2.0, kNan}, {3.0, 4.0}, {4.0, 5.0}}, {}}};
  const std::string svg = svg_of(figure);
  EXPECT_EQ(count_of(svg, "h0L"), 2u);
}

TEST(Figure, SeriesOfOneGroupShareColourAndLegend) {
  Figure figure = small_figure();
  figure.series = {{"unit 0", FigureSeries::Style::line, {{0.0, 1.0}, {1.0, 2.0}}, "depth"},
                   {"unit 1", FigureSeries::Style::line, {{0.0, 2.0}, {1.0, 3.0}}, "depth"}};
  const std::string svg = svg_of(figure);
  EXPECT_EQ(count_of(svg, ">depth</text>"), 1u);
  EXPECT_EQ(count_of(svg, "stroke=\"#0072b2\""), 3u);
  EXPECT_THAT(csv_of(figure), HasSubstr("unit 1,0,2\r\n"));
}

TEST(Figure, AnEmptyFigureIsDrawnWithItsAxes) {
  EXPECT_THAT(svg_of(Figure{}), AllOf(HasSubstr("<svg"), HasSubstr("</svg>"), Not(HasSubstr("nan"))));
  Figure figure = small_figure();
  figure.series = {{"nothing", FigureSeries::Style::line, {}, {}},
                   {"no dots", FigureSeries::Style::dots, {}, {}}};
  figure.log_y = true;
  EXPECT_THAT(svg_of(figure), AllOf(HasSubstr("nothing"), Not(HasSubstr("nan"))));
}

TEST(Figure, EqualFiguresGiveEqualBytes) { EXPECT_EQ(svg_of(small_figure()), svg_of(small_figure())); }

TEST(Figure, ItsNumbersAreUnroundedAndMissingOnesEmpty) {
  Figure figure = small_figure();
  figure.series = {{"a, b", FigureSeries::Style::dots, {{1.0 / 3.0, 2.0}, {1.0, kNan}}, {}}};
  EXPECT_EQ(csv_of(figure), "series,x,y\r\n\"a, b\",0.3333333333333333,2\r\n\"a, b\",1,\r\n");
}

}  // namespace
}  // namespace trilat
