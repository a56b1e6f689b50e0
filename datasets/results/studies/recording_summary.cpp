// SPDX-License-Identifier: MIT
#include "datasets/results/studies/recording_summary.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json json_of(const std::vector<ClockUnit>& units) {
  Json json = Json::array();
  for (const ClockUnit& u : units)
    json.push_back(Json::array({u.asked, u.answered, u.below_2ms, u.below_4ms}));
  return json;
}

ClockUnit read_unit(const Json& json, const std::string& place) {
  const auto is_count = [](const Json& value) { return value.is_number_unsigned(); };
  if (!json.is_array() || json.size() != 4 || !std::all_of(json.begin(), json.end(), is_count))
    throw InputError(place, "must hold 4 counts: asked, answered, below 2 ms, below 4 ms");
  const ClockUnit u{json[0].get<std::uint64_t>(), json[1].get<std::uint64_t>(), json[2].get<std::uint64_t>(),
                    json[3].get<std::uint64_t>()};
  if (u.answered > u.asked || u.below_4ms > u.answered || u.below_2ms > u.below_4ms)
    throw InputError(place, "counts more answers than were asked for, or more good ones than answers");
  return u;
}

// Those of `row`, whose other counts are known.
std::vector<ClockUnit> read_units(JsonObject& object, const ClockErrorRow& row) {
  const Json& json = object.value("units");
  if (!json.is_array()) object.refuse("units", "must be an array of counts");
  std::vector<ClockUnit> units;
  ClockUnit left{row.asked, row.error.n, row.error.bins[0], row.error.bins[0] + row.error.bins[1]};
  for (std::size_t k = 0; k < json.size(); ++k) {
    const ClockUnit& u =
        units.emplace_back(read_unit(json[k], fmt::format("{}/{}", object.place_of("units"), k)));
    if (u.asked > left.asked) object.refuse("units", "must add up to the counts of the row");
    left.asked -= u.asked;
    left.answered -= u.answered;
    left.below_2ms -= u.below_2ms;
    left.below_4ms -= u.below_4ms;
  }
  if (left != ClockUnit{}) object.refuse("units", "must add up to the counts of the row");
  return units;
}

}  // namespace

Json json_of(const ClockErrorRow& r) {
  return {{"network", r.network},
          {"method", r.method},
          {"asked", r.asked},
          {"error", json_of(r.error)},
          {"below_2ms", number(r.below_2ms)},
          {"below_2ms_low", number(r.below_2ms_low)},
          {"below_2ms_high", number(r.below_2ms_high)},
          {"units", json_of(r.units)}};
}

ClockErrorRow read_clock_error(JsonObject object) {
  ClockErrorRow r;
  r.network = object.text("network");
  r.method = object.text("method");
  r.asked = object.count("asked");
  r.error = read_time_spread(object.object("error"));
  r.below_2ms = number_or_nan(object, "below_2ms");
  r.below_2ms_low = number_or_nan(object, "below_2ms_low");
  r.below_2ms_high = number_or_nan(object, "below_2ms_high");
  r.units = read_units(object, r);
  object.finish();
  return r;
}

Json json_of(const ClockFitRow& r) {
  return {{"network", r.network},
          {"offset_sigma_s", number(r.offset_sigma_s)},
          {"offset_bound_s", number(r.offset_bound_s)},
          {"within_bound_share", number(r.within_bound_share)},
          {"exchanges_used_share", number(r.exchanges_used_share)}};
}

ClockFitRow read_clock_fit(JsonObject object) {
  ClockFitRow r;
  r.network = object.text("network");
  r.offset_sigma_s = number_or_nan(object, "offset_sigma_s");
  r.offset_bound_s = number_or_nan(object, "offset_bound_s");
  r.within_bound_share = number_or_nan(object, "within_bound_share");
  r.exchanges_used_share = number_or_nan(object, "exchanges_used_share");
  object.finish();
  return r;
}

Json json_of(const QueueRow& r) {
  return {{"network", r.network},
          {"method", r.method},
          {"server", r.server},
          {"came", r.counts.came},
          {"untimed", r.counts.untimed},
          {"too_early", r.counts.too_early},
          {"too_late", r.counts.too_late},
          {"taken", r.counts.taken},
          {"taken_low", number(r.taken_low)},
          {"taken_high", number(r.taken_high)}};
}

QueueRow read_queue(JsonObject object) {
  QueueRow r;
  r.network = object.text("network");
  r.method = object.text("method");
  r.server = object.text("server");
  r.counts.came = object.count("came");
  std::uint64_t left = r.counts.came;
  for (const auto& [key, count] : {std::pair{"untimed", &QueueCounts::untimed},
                                   {"too_early", &QueueCounts::too_early},
                                   {"too_late", &QueueCounts::too_late},
                                   {"taken", &QueueCounts::taken}}) {
    r.counts.*count = object.count(key);
    if (r.counts.*count > left) object.refuse(key, "makes more frames than came");
    left -= r.counts.*count;
  }
  if (left > 0) object.refuse("came", "must be the sum of the frames without a time, dropped and taken");
  r.taken_low = number_or_nan(object, "taken_low");
  r.taken_high = number_or_nan(object, "taken_high");
  object.finish();
  return r;
}

void write_recording_summary(const std::filesystem::path& folder, const RecordingSummary& s) {
  Json json = results_head(StudyKind::recording);
  json["study"] = s.study;
  json["simulated"] = true;
  json["seed"] = s.seed;
  json["frames"] = s.frames;
  json["sensors"] = s.sensors;
  json["runs"] = s.runs;
  json["clocks"] = Json::array();
  for (const ClockErrorRow& row : s.clocks) json["clocks"].push_back(json_of(row));
  json["fits"] = Json::array();
  for (const ClockFitRow& row : s.fits) json["fits"].push_back(json_of(row));
  json["late_s"] = s.late_s;
  json["queues"] = Json::array();
  for (const QueueRow& row : s.queues) json["queues"].push_back(json_of(row));
  write_file(folder / "summary.json", json_text(json, -1) + "\n");
}

RecordingSummary read_recording_summary(const std::filesystem::path& folder) {
  const Json json = read_results_json(folder);
  JsonObject object(json, (folder / "summary.json").string(), "");
  check_results_head(object, StudyKind::recording);
  RecordingSummary s;
  s.study = object.text("study");
  object.boolean("simulated", true);
  s.seed = object.count("seed");
  s.frames = object.count("frames");
  s.sensors = object.count("sensors");
  s.runs = object.count("runs");
  for (JsonObject& entry : object.objects("clocks")) {
    s.clocks.push_back(read_clock_error(entry));
    if (s.clocks.back().units.size() != s.runs * s.sensors)
      entry.refuse("units", "must hold one row for each run and sensor");
  }
  for (JsonObject& entry : object.objects("fits")) s.fits.push_back(read_clock_fit(entry));
  s.late_s = object.number("late_s");
  for (JsonObject& entry : object.objects("queues")) s.queues.push_back(read_queue(entry));
  object.finish();
  return s;
}

}  // namespace trilat
