// SPDX-License-Identifier: MIT
#include "reports/tracking_tables.h"

#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "reports/table_cells.h"

namespace trilat {
namespace {

constexpr double kMillisecondsPerSecond = 1e3;

std::string data_text(const TrackingSummary& s) {
  return fmt::format("{}, {} sensors", s.study, s.simulated ? "simulated" : "recorded");
}

TableValue known(bool truth_known, double share) { return truth_known ? percent_cell(share) : no_cell(); }

// Rows that have `name` in common are added up, in the order of their first.
std::vector<ViewRow> sum_views(const std::vector<ViewRow>& views,
                               const std::function<std::string(const ViewRow&)>& name) {
  std::vector<ViewRow> sums;
  for (const ViewRow& row : views) {
    auto sum = std::find_if(sums.begin(), sums.end(), [&](const ViewRow& other) {
      return other.condition == row.condition && other.rule == row.rule && name(other) == name(row);
    });
    if (sum == sums.end()) {
      sums.push_back(row);
      continue;
    }
    sum->views += row.views;
    sum->rejected += row.rejected;
    sum->truth_known = sum->truth_known && row.truth_known;
    sum->hidden += row.hidden;
    sum->rightly += row.rightly;
  }
  return sums;
}

Table views_table(const TrackingSummary& s, const std::string& by,
                  const std::function<std::string(const ViewRow&)>& name) {
  Table table;
  table.id = usable_id("views-" + by + "-" + s.study);
  table.title = fmt::format("Which views are rejected, by {} ({})", by, data_text(s));
  table.columns = {{"condition", "condition", true},
                   {by, by, true},
                   {"rule", "rule", true},
                   {"views", "views"},
                   {"rejected (%)", "rejected_percent"},
                   {"truly hidden (%)", "hidden_percent"},
                   {"rightly, of the rejected (%)", "rightly_percent"},
                   {"found, of the hidden (%)", "found_percent"}};
  for (const ViewRow& row : sum_views(s.views, name))
    table.rows.push_back({TableValue::of(row.condition), TableValue::of(name(row)), TableValue::of(row.rule),
                          count_cell(row.views), percent_cell(share_of(row.rejected, row.views)),
                          known(row.truth_known, share_of(row.hidden, row.views)),
                          known(row.truth_known, share_of(row.rightly, row.rejected)),
                          known(row.truth_known, share_of(row.rightly, row.hidden))});
  table.notes = {
      "A view is one joint at one instant for which a sensor gives a position. Rules: what the tracker calls "
      "inferred; limbs that cross in front, by equation 8 as printed and corrected; what the recorded depth "
      "hides; and what methods that choose their sensors leave out.",
      "What is truly hidden only a simulation knows: less than the declared share of the joint's own surface "
      "is in the depth image."};
  return table;
}

Table exchanges_table(const TrackingSummary& s) {
  Table table;
  table.id = usable_id("exchanges-" + s.study);
  table.title = fmt::format("Left and right exchanged by a sensor ({}); exchanges that were found were {}",
                            data_text(s), s.repaired ? "undone" : "left as they were");
  table.columns = {{"condition", "condition", true},
                   {"sensor", "sensor", true},
                   {"instants", "instants"},
                   {"found (%)", "found_percent"},
                   {"stretches found", "stretches"},
                   {"truly exchanged (%)", "exchanged_percent"},
                   {"true stretches", "true_stretches"},
                   {"of them found (%)", "stretches_found_percent"},
                   {"right ones touched (%)", "touched_percent"}};
  for (const ExchangeRow& row : s.exchanges)
    table.rows.push_back(
        {TableValue::of(row.condition), TableValue::of(row.sensor), count_cell(row.instants),
         percent_cell(share_of(row.found, row.instants)), count_cell(row.stretches),
         known(row.truth_known, share_of(row.exchanged, row.instants)),
         row.truth_known ? count_cell(row.true_stretches) : no_cell(),
         known(row.truth_known, share_of(row.stretches_found, row.true_stretches)),
         known(row.truth_known, share_of(row.found - row.rightly, row.instants - row.exchanged))});
  table.notes = {
      "Found by agreement between the sensors and by what left and right cannot fake: toes, knees, elbows "
      "and the walking direction. A true stretch counts as found when 95 % of its instants are."};
  return table;
}

Table clocks_table(const TrackingSummary& s) {
  const auto ms = [](double seconds) { return TableValue::of(seconds * kMillisecondsPerSecond, 2); };
  Table table;
  table.id = usable_id("clocks-" + s.study);
  table.title = fmt::format("Offset between mocap and sensors by motion, the trackers' lag included ({})",
                            data_text(s));
  table.columns = {{"take", "take", true},       {"offset (ms)", "offset_ms"},
                   {"95 % from (ms)", "low_ms"}, {"to (ms)", "high_ms"},
                   {"drift (ppm)", "drift_ppm"}, {"± (ppm)", "drift_sigma_ppm"},
                   {"correlation", "peak"},      {"next peak / first", "second"},
                   {"outcome", "outcome", true}, {"applied", "applied", true}};
  for (const ClockRow& row : s.clocks)
    table.rows.push_back({TableValue::of(row.take), ms(row.offset_s), ms(row.low_s), ms(row.high_s),
                          TableValue::of(row.drift_ppm, 0), TableValue::of(row.drift_sigma_ppm, 0),
                          TableValue::of(row.peak, 3), TableValue::of(row.second, 3),
                          TableValue::of(row.status),
                          TableValue::of(std::string(row.applied ? "yes" : "no"))});
  table.notes = {
      "Mocap time = stated time + offset. A tracker that lags behind the body looks like a clock that is "
      "late: motion alone cannot tell one from the other, so the interval is that of clock and lag together, "
      "and the offset is "
      "only applied when the study says so. Drift is never applied."};
  return table;
}

}  // namespace

std::vector<Table> tracking_tables(const TrackingSummary& s) {
  std::vector<Table> tables;
  if (!s.views.empty()) {
    tables.push_back(views_table(s, "joint", [](const ViewRow& row) { return row.group; }));
    tables.push_back(views_table(s, "sensor", [](const ViewRow& row) { return row.sensor; }));
  }
  if (!s.exchanges.empty()) tables.push_back(exchanges_table(s));
  if (!s.clocks.empty()) tables.push_back(clocks_table(s));
  return tables;
}

}  // namespace trilat
