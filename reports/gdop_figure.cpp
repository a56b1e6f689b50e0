// SPDX-License-Identifier: MIT
#include "reports/gdop_figure.h"

#include <fmt/format.h>

#include "reports/table.h"

namespace trilat {
namespace {

constexpr double kBest = 1.0, kWorst = 5.0;  // what lies beyond has the colour of the end

}  // namespace

Figure gdop_figure(const GdopMap& map, const ResultsSummary& summary) {
  Figure figure;
  figure.id = usable_id("figure-gdop-" + summary.study);
  figure.title = fmt::format("GDOP of the rig {:g} m above the floor, {}{}", map.height_m, summary.campaign,
                             summary.simulated ? ", simulated" : "");
  figure.caption = fmt::format(
      "How many times the error of a range a trilaterated position is off: the root of the sum of the "
      "variances "
      "along the three axes, for ranges of variance 1. Geometry alone, of the sensors that have the point in "
      "view (70.6 x 60 degrees, 0.5 to 4.5 m). White: fewer than three have. {} and more are one colour. "
      "Calibration of take {}{}.",
      kWorst, map.take, summary.simulated ? "; simulated" : "");
  figure.x_label = "x (m)";
  figure.y_label = "z (m)";
  figure.equal_scales = true;
  figure.map = FigureMap{map.x_m, map.z_m, map.gdop, "GDOP", kBest, kWorst};
  for (std::size_t s = 0; s < map.sensors.size(); ++s)
    figure.series.push_back({fmt::format("{}, {:.2f} m high", map.sensors[s], map.position_m[s][1]),
                             FigureSeries::Style::dots,
                             {{map.position_m[s][0], map.position_m[s][2]}}});
  return figure;
}

}  // namespace trilat
