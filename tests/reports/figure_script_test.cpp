// SPDX-License-Identifier: MIT
// The commands that draw a figure, whole: each number in them follows from the figure's by hand.
#include <regex>

#include <gmock/gmock.h>

#include "reports/figures/draw_figures.h"
#include "reports/figures/figure_look.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;
using Style = FigureSeries::Style;

Figure figure_of(std::vector<FigureSeries> series) {
  Figure figure{.id = "f", .title = "t", .caption = "c", .x_label = "x", .y_label = "y"};
  figure.series = std::move(series);
  return figure;
}

constexpr const char* kHead =
    "set encoding utf8\nset border 3 lc rgb '#333333' lw 0.6\nset tics nomirror noenhanced scale 0.5\n"
    "set grid xtics ytics lc rgb '#d8d8d8' lw 0.4 dt 1\n";

TEST(GnuplotScript, DrawsCurvesWithIntervalsBandsAndALegend) {
  Figure figure = figure_of({{.name = "a",
                              .style = Style::line_and_dots,
                              .points = {{1, 10, 8, 12}, {2, kNaN}, {2, 20}},
                              .method = "linear"},
                             {.name = "b", .style = Style::band, .points = {{1, 5, 4, 6}, {3, 7, kNaN, 9}}}});
  figure.x_label = "sensors";
  figure.y_label = "it's %";
  figure.bands = {{0.5, 1.5, "accepted"}, {2, 3, "accepted"}};
  figure.lines = {{15.0, "limit"}};
  // The picture has 178 x 90 mm: 18 mm at the left, 5 at the right, 13 below, 10.3 above. The axes are 2 %
  // and 4 % longer at each end than the data
  EXPECT_EQ(gnuplot_script(figure), std::string(kHead) + R"(set xrange [0.96:3.04]
set object 1 rectangle from 0.5, graph 0 to 1.5, graph 1 behind fillcolor rgb '#e4e4e4' fillstyle solid noborder
set object 2 rectangle from 2, graph 0 to 3, graph 1 behind fillcolor rgb '#e4e4e4' fillstyle solid noborder
set multiplot layout 1,1 margins 0.1011,0.9719,0.1444,0.8856 spacing 0.0674,0.1111
set yrange [3.36:20.64]
set ylabel 'it''s %' noenhanced
set xlabel 'sensors' noenhanced offset 0,0.4
set xtics 1
set format x '% h'
$d0 << EOD
1 10 8 12

2 20 20 20
EOD
$d1 << EOD
1 5 4 6
3 7 7 7
EOD
unset key
set key at screen 0.0112, screen 0.9889 left top Left reverse noenhanced samplen 2 width 1 vertical maxrows 1
plot $d0 using 1:3:(0):($4-$3) with vectors heads size screen 0.004,90 lw 0.8 lc rgb '#0072b2' notitle, \
  $d0 using 1:2 with linespoints pt 7 ps 0.55 lw 1.2 dt 1 lc rgb '#0072b2' notitle, \
  $d1 using 1:3:4 with filledcurves lc rgb '#d55e00' fillstyle transparent solid 0.2 noborder notitle, \
  $d1 using 1:2 with lines lw 1.2 dt 1 lc rgb '#d55e00' notitle, \
  15 with lines lw 1 dt 2 lc rgb '#222222' notitle, \
  keyentry with linespoints pt 7 ps 0.55 lw 1.2 dt 1 lc rgb '#0072b2' title 'a', \
  keyentry with lines lw 1.2 dt 1 lc rgb '#d55e00' title 'b', \
  keyentry with lines lw 1 dt 2 lc rgb '#222222' title 'limit', \
  keyentry with boxes fillstyle solid noborder lc rgb '#e4e4e4' title 'accepted'
unset multiplot
)");
}

TEST(GnuplotScript, DrawsNamedRowsInPanelsSideBySideAndThePapersMarksHollow) {
  Figure figure = figure_of(
      {{.name = "ours", .points = {{10, 0, 9, 11}, {4, 1}}, .method = "mean"},
       {.name = "ours, wrist", .points = {{6, 1, 5, 8}}, .group = "ours", .method = "mean", .panel = 1},
       {.name = "the paper", .points = {{8.7, 0}}, .method = "truth", .panel = 1, .hollow = true}});
  figure.x_label = "error (cm)";
  figure.y_label = "method";
  figure.y_names = {"100 % printed", "mean"};
  figure.panels = {"head", "wrist"};
  const FigureSize size = size_of(figure);
  EXPECT_DOUBLE_EQ(size.width_mm, 178.0);
  EXPECT_DOUBLE_EQ(size.height_mm, 30.0 + 2 * 4.4);
  // 3 mm and 13 letters of 1.55 mm stand at the left; the axis of errors begins at 0
  EXPECT_EQ(gnuplot_script(figure), std::string(kHead) + R"(set grid noytics
set xrange [0:11.22]
set multiplot layout 1,2 margins 0.1301,0.9719,0.3351,0.7345 spacing 0.0225,0.2577
set yrange [1.6:-0.6]
set title 'head' noenhanced offset 0,-0.6
set ylabel 'method' noenhanced
set ytics ('100 %% printed' 0, 'mean' 1)
set xlabel 'error (cm)' noenhanced offset 0,0.4
set xtics 2
set format x '% h'
$d0 << EOD
10 0 9 11
4 1 4 4
EOD
unset key
set key at screen 0.0112, screen 0.9742 left top Left reverse noenhanced samplen 2 width 1 vertical maxrows 1
plot $d0 using 3:2:($4-$3):(0) with vectors heads size screen 0.004,90 lw 0.8 lc rgb '#cc79a7' notitle, \
  $d0 using 1:2 with points pt 11 ps 0.55 lc rgb '#cc79a7' notitle, \
  keyentry with points pt 11 ps 0.55 lc rgb '#cc79a7' title 'ours', \
  keyentry with points pt 6 ps 0.77 lc rgb '#000000' title 'the paper'
set yrange [1.6:-0.6]
set title 'wrist' noenhanced offset 0,-0.6
unset ylabel
set ytics ('' 0, '' 1)
unset xlabel
set xtics 2
set format x '% h'
$d1 << EOD
6 1 5 8
EOD
$d2 << EOD
8.7 0 8.7 8.7
EOD
unset key
plot $d1 using 3:2:($4-$3):(0) with vectors heads size screen 0.004,90 lw 0.8 lc rgb '#cc79a7' notitle, \
  $d1 using 1:2 with points pt 11 ps 0.55 lc rgb '#cc79a7' notitle, \
  $d2 using 1:2 with points pt 6 ps 0.77 lc rgb '#000000' notitle
unset multiplot
)");
  const Figure narrow = narrow_figure(figure);
  EXPECT_DOUBLE_EQ(size_of(narrow).width_mm, 85.0);
  EXPECT_DOUBLE_EQ(size_of(narrow).height_mm, 30.0 + 2 * 2 * 4.4 + 10.0);
  EXPECT_THAT(gnuplot_script(narrow), HasSubstr("set multiplot layout 2,1 "));
}

TEST(GnuplotScript, DrawsPanelsOfPowersBelowEachOtherInAColumn) {
  Figure figure = figure_of({{.name = "s1",
                              .style = Style::line,
                              .points = {{1e-4, 2, 1, 4}, {0.1, 8, 0, 9}, {0, 1}, {1, -1}},
                              .group = "s"},
                             {.name = "s2", .style = Style::line, .points = {{1e-3, 3}}, .group = "s"},
                             {.name = "t", .points = {{1e-3, 6}}, .panel = 1}});
  for (int k = 0; k < 30; ++k) figure.series.back().points.push_back({0.01, 6.0});
  figure.log_x = figure.log_y = true;
  figure.width = FigureWidth::column;
  figure.panels = {"one", "two"};
  figure.lines = {{5, "five"}, {-1, "nowhere"}};
  EXPECT_DOUBLE_EQ(size_of(figure).height_mm, 24.0 + 2 * 50.0);
  const std::string script = gnuplot_script(figure);
  // a factor of 1.2 more at each end; a tick every 10 mm at most, of 62
  EXPECT_THAT(script, testing::StartsWith(std::string(kHead) + R"(set logscale x
set logscale y
set xrange [8.333333333333334e-05:0.12]
set multiplot layout 2,1 margins 0.2118,0.9412,0.1048,0.9169 spacing 0.1412,0.0806
set yrange [0.8333333333333334:10.799999999999999]
set title 'one' noenhanced offset 0,-0.6
set ylabel 'y' noenhanced
set format y '%g'
unset xlabel
set xtics 10
set format x ''
$d0 << EOD
0.0001 2 1 4
0.1 8 8 8


0.001 3 3 3
EOD
unset key
)"));
  EXPECT_THAT(script, HasSubstr("$d0 using 1:2 with lines lw 0.8 dt 1 lc rgb '#0072b2' notitle, \\\n"
                                "  5 with lines lw 1 dt 2 lc rgb '#222222' notitle, \\\n"
                                "  keyentry with lines lw 0.8 dt 1 lc rgb '#0072b2' title 's', \\\n"
                                "  keyentry with points pt 9 ps 0.55 lc rgb '#d55e00' title 't', \\\n"
                                "  keyentry with lines lw 1 dt 2 lc rgb '#222222' title 'five'\n"));
  EXPECT_THAT(script, Not(HasSubstr("nowhere")));
  // the second panel has names below, an axis of its own, and so many points that they are small and pale
  EXPECT_THAT(script, HasSubstr("set yrange [4.166666666666667:7.199999999999999]\nset title 'two'"));
  EXPECT_THAT(script, HasSubstr("set xlabel 'x' noenhanced offset 0,0.4\nset xtics 10\nset format x '%g'\n"));
  EXPECT_THAT(script, HasSubstr("plot $d1 using 1:2 with points pt 9 ps 0.4 lc rgb '#60d55e00' notitle"));
}

TEST(GnuplotScript, TurnsNamesThatHaveNoRoomSideBySide) {
  Figure figure = figure_of({{.name = "n", .style = Style::line_and_dots, .points = {{0, 4}, {3, 4}}}});
  figure.width = FigureWidth::column;
  // 62 mm: four names of ten letters need 44 x 1.55 mm, four of nine 40 x 1.55
  figure.x_names = {"2026-01-01", "2026-01-02", "2026-01-03", "2026-01-04"};
  EXPECT_THAT(gnuplot_script(figure), HasSubstr("set grid noxtics\nset xrange [-0.6:3.6]\n"));
  EXPECT_THAT(gnuplot_script(figure),
              HasSubstr("set multiplot layout 1,1 margins 0.2118,0.9412,0.4032,0.9032 spacing 0.1412,0.1613\n"
                        "set yrange [3.5:4.5]\nset ylabel 'y' noenhanced\nset xlabel 'x' noenhanced offset "
                        "0,0.4\nset xtics ('2026-01-01' 0, '2026-01-02' 1, '2026-01-03' 2, '2026-01-04' 3)\n"
                        "set xtics rotate by -30\n$d0 << EOD\n0 4 4 4\n3 4 4 4\nEOD\nunset key\nplot "));
  EXPECT_THAT(gnuplot_script(figure), Not(HasSubstr("keyentry")));  // there is one series alone
  for (std::string& name : figure.x_names) name.pop_back();
  EXPECT_THAT(gnuplot_script(figure), HasSubstr("margins 0.2118,0.9412,0.2097,0.9032"));
  EXPECT_THAT(gnuplot_script(figure), Not(HasSubstr("rotate")));
}

TEST(GnuplotScript, OfNothingItDrawsAxes) {
  Figure figure = figure_of({});
  EXPECT_THAT(gnuplot_script(figure), HasSubstr("set xrange [0:1]\n"));
  EXPECT_THAT(gnuplot_script(figure), testing::EndsWith("unset key\nplot NaN notitle\nunset multiplot\n"));
  figure.log_y = true;
  EXPECT_THAT(gnuplot_script(figure), HasSubstr("set yrange [1:10]\n"));
  figure.log_y = false;
  figure.series.push_back({.name = "without points", .points = {}});
  figure.series.push_back({.name = "other", .points = {}});
  EXPECT_THAT(gnuplot_script(figure), HasSubstr("$d0 << EOD\nNaN NaN NaN NaN NaN NaN\nEOD\n"));
  EXPECT_THAT(gnuplot_script(figure), Not(HasSubstr("keyentry")));
}

// The step between ticks and the form of a figure's numbers.
std::string ticks_of(double low, double high, bool log_x, std::size_t panels) {
  Figure figure = figure_of({{.name = "s", .points = {{low, 1}, {high, 2}}}});
  figure.log_x = log_x;
  for (std::size_t p = 0; p < panels; ++p) figure.panels.push_back("p");
  std::smatch found;
  const std::string script = gnuplot_script(figure);
  return std::regex_search(script, found, std::regex("set xtics (\\S+)")) ? found[1] : std::string();
}

TEST(GnuplotScript, TicksAreRoundNumbersOrPowersAtLeastTenMillimetresApart) {
  EXPECT_EQ(ticks_of(0.5, 1.5, false, 0), "0.1");  // 155 mm, 1.04 wide: 0.067
  EXPECT_EQ(ticks_of(0.5, 2.5, false, 0), "0.2");
  EXPECT_EQ(ticks_of(0.5, 6.5, false, 0), "0.5");
  EXPECT_EQ(ticks_of(0.5, 9.5, false, 0), "1");
  EXPECT_EQ(ticks_of(0, 1, false, 0), "1");          // none between counts
  EXPECT_EQ(ticks_of(0.5, 2.5, false, 3), "0.5");    // a panel has 43.7 mm
  EXPECT_EQ(ticks_of(1e-12, 1.0, true, 0), "10");    // of 15.5
  EXPECT_EQ(ticks_of(1e-12, 1.0, true, 3), "1000");  // of 4.4
  EXPECT_EQ(ticks_of(0.5, 2.5, false, 4), "0.5");    // three in a row, one below
}

TEST(GnuplotScript, AnAxisOfPowersIsWiderByASharedFactor) {
  Figure figure = figure_of({{.name = "s", .points = {{1e-12, 1}, {1, 2}}}});
  figure.log_x = true;
  std::smatch found;
  const std::string script = gnuplot_script(figure);
  ASSERT_TRUE(std::regex_search(script, found, std::regex("set xrange \\[([^:]*):([^\\]]*)\\]")));
  EXPECT_NEAR(std::stod(found[1]) / 1e-12, std::pow(10.0, -0.24), 1e-6);  // 2 % of twelve powers
  EXPECT_NEAR(std::stod(found[2]), std::pow(10.0, 0.24), 1e-6);
}

TEST(FigureLook, AMethodLooksAlikeInEveryFigureAndItsVariantsDifferByTheirDash) {
  const auto look = [](const char* method) {
    const FigureLook found = look_of_method(method);
    return found.colour + " " + std::to_string(found.dash) + " " + std::to_string(found.marker);
  };
  EXPECT_EQ(look("truth"), "#000000 1 7");
  EXPECT_EQ(look("the paper's"), "#000000 1 7");
  EXPECT_EQ(look("linear"), "#0072b2 1 7");
  EXPECT_EQ(look("geometric"), "#d55e00 1 9");
  EXPECT_EQ(look("nonlinear, 4 sensors"), "#009e73 1 5");
  EXPECT_EQ(look("nonlinear as printed"), "#009e73 3 5");
  EXPECT_EQ(look("nonlinear, occlusion corrected"), "#009e73 4 5");
  EXPECT_EQ(look("newton"), "#009e73 4 5");
  EXPECT_EQ(look("ceres"), "#009e73 5 5");
  EXPECT_EQ(look("ceres as printed"), "#009e73 2 5");
  EXPECT_EQ(look("tracked_mean"), "#cc79a7 2 11");
  EXPECT_EQ(look("single k1"), "#7f7f7f 1 8");
  EXPECT_EQ(look("meander"), "#7f7f7f 1 8");  // whole words only
  EXPECT_EQ(look("own"), "#7f7f7f 1 8");
}

TEST(FigureLook, OtherSeriesTakeTheColoursThatMethodsLeave) {
  std::vector<FigureSeries> series{{.name = "a", .points = {}},
                                   {.name = "l", .points = {}, .method = "linear"},
                                   {.name = "b", .points = {}}};
  series.push_back({.name = "a again", .points = {}, .group = "a"});
  std::vector<FigureLook> looks = looks_of(figure_of(series));
  EXPECT_EQ(looks[0].colour, "#d55e00");
  EXPECT_EQ(looks[0].marker, 9);
  EXPECT_EQ(looks[1].colour, "#0072b2");
  EXPECT_EQ(looks[2].colour, "#009e73");
  EXPECT_EQ(looks[3].colour, looks[0].colour);
  series.clear();
  for (int k = 0; k < 9; ++k) series.push_back({.name = std::to_string(k), .points = {}});
  looks = looks_of(figure_of(series));
  EXPECT_EQ(looks[7].dash, 1);
  EXPECT_EQ(looks[8].colour, looks[0].colour);  // eight colours, then dashes
  EXPECT_EQ(looks[8].dash, 2);
}

TEST(DrawFigures, PicturesHaveTheFiguresSizeAndNoDate) {
  Figure figure = figure_of({{.name = "s", .points = {{1, 1}, {2, 2}}}});
  const std::vector<DrawnFigure> drawn = draw_figures({figure, narrow_figure(figure)});
  ASSERT_EQ(drawn.size(), 2u);
  ASSERT_TRUE(drawn[0].is_drawn()) << "scripts/setup installs gnuplot";
  EXPECT_THAT(drawn[0].svg, HasSubstr("viewBox=\"0 0 673 340\""));  // 178 x 90 mm of 96 dpi
  EXPECT_THAT(drawn[1].svg, HasSubstr("viewBox=\"0 0 321 234\""));
  EXPECT_THAT(drawn[0].pdf, HasSubstr("/CreationDate (D:20000101000000"));
  EXPECT_THAT(drawn[0].pdf, HasSubstr("MediaBox [ 0 0 504 255 ]"));  // of 1/72 inch
}

}  // namespace
}  // namespace trilat
