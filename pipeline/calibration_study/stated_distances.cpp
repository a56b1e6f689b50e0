// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "datasets/base/words.h"
#include "datasets/mocap/mocap_text.h"
#include "datasets/session/clock/session_clock.h"
#include "pipeline/calibration/wand_views.h"
#include "pipeline/calibration_study/place_samples.h"

namespace trilat {
namespace {

double number_in(const std::string& cell, const char* column, const std::string& place) {
  double value = 0.0;
  if (parse_cell(cell, value) != CellKind::number)
    throw InputError(place, fmt::format("{} is \"{}\", which is not a number", column, cell));
  return value;
}

// A stated distance from the lens to the ball's centre.
double stated_distance_m(double value, const std::string& place) {
  constexpr double kMin_m = 0.2, kMax_m = 8.0;
  if (value >= kMin_m && value <= kMax_m) return value;
  throw InputError(place, fmt::format("distance_m is {:g}; state metres, {:g} to {:g}{}", value, kMin_m,
                                      kMax_m, in_metres_text(value, kMin_m, kMax_m)));
}

// Distances of the ball that one sensor's places state, and those that our method found there.
struct FoundBalls {
  std::vector<std::size_t> place;
  std::vector<double> stated_m, found_m;
  std::vector<double> angle_off_deg;  // where an angle is stated, too
};

// Median of the distances from what is stated to what is found, in metres.
double typical_off_m(const std::vector<double>& stated_m, const std::vector<double>& found_m) {
  std::vector<double> off_m;
  for (std::size_t i = 0; i < stated_m.size(); ++i) off_m.push_back(std::abs(found_m[i] - stated_m[i]));
  return off_m.empty() ? kNaN : median(off_m);
}

// The sensor that sees the ball where `stated` has it, at the same places; nothing when none does.
std::optional<std::size_t> sensor_that_fits(const FoundBalls& stated, const std::vector<FoundBalls>& all) {
  constexpr double kFits_m = 0.05;  // a unit's depth error, and some
  for (std::size_t s = 0; s < all.size(); ++s) {
    std::vector<double> stated_m, found_m;
    for (std::size_t i = 0; i < stated.place.size(); ++i) {
      const auto at = std::ranges::find(all[s].place, stated.place[i]);
      if (at == all[s].place.end()) continue;
      stated_m.push_back(stated.stated_m[i]);
      found_m.push_back(all[s].found_m[static_cast<std::size_t>(at - all[s].place.begin())]);
    }
    if (2 * stated_m.size() > stated.place.size() && typical_off_m(stated_m, found_m) < kFits_m) return s;
  }
  return std::nullopt;
}

// Refuses stated distances and angles that are not those of what a sensor sees, and remarks that distances
// may end at the ball's surface. `found`: one a sensor.
void check_stated(const std::string& csv, const std::vector<FoundBalls>& found, WandRecording& recording) {
  constexpr double kMaxOff_m = 0.25, kMaxBesideAnother_m = 0.08, kMaxOff_deg = 5.0;
  constexpr std::size_t kMinPlaces = 3;
  std::vector<double> more_m;
  for (std::size_t s = 0; s < found.size(); ++s) {
    const FoundBalls& balls = found[s];
    for (std::size_t i = 0; i < balls.place.size(); ++i)
      more_m.push_back(balls.found_m[i] - balls.stated_m[i]);
    if (balls.place.size() < kMinPlaces) continue;
    const double off_m = typical_off_m(balls.stated_m, balls.found_m);
    const std::optional<std::size_t> other = sensor_that_fits(balls, found);
    if (off_m > (other ? kMaxBesideAnother_m : kMaxOff_m))
      throw InputError(
          csv, fmt::format("states distances of sensor \"{}\" that differ from those at which it sees "
                           "the ball by {:.2f} m, the median of {} places{}",
                           recording.sensors[s], off_m, balls.place.size(),
                           other ? fmt::format("; they are those of sensor \"{}\"", recording.sensors[*other])
                                 : "; are the times and the sensor the recording's?"));
    if (balls.angle_off_deg.size() >= kMinPlaces && median(balls.angle_off_deg) > kMaxOff_deg)
      throw InputError(
          csv, fmt::format("states angles of sensor \"{}\" that differ from those at which it sees the "
                           "ball by {:.0f} degrees, the median of {} places; angle_deg is from the lens' "
                           "axis, in degrees",
                           recording.sensors[s], median(balls.angle_off_deg), balls.angle_off_deg.size()));
  }
  if (more_m.size() < kMinPlaces) return;
  const double share = median(more_m) / recording.ball_radius_m;
  if (share > 0.7 && share < 1.3)
    recording.notes.push_back(
        fmt::format("{}: the ball is found {:.1f} cm farther than stated, about its radius: distance_m is "
                    "that of the ball's centre, not of its surface",
                    csv, median(more_m) * kCentimetresPerMetre));
}

constexpr std::array kPlaceColumns{"from_s", "to_s", "sensor", "distance_m", "angle_deg"};
constexpr std::size_t kNeededColumns = 4;

// Cells without a byte order mark and blanks around them.
std::vector<std::string> plain_cells(std::string_view line) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf", kBlanks = " \t";
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  std::vector<std::string> cells = split_csv(line);
  for (std::string& cell : cells) {
    cell.erase(0, std::min(cell.find_first_not_of(kBlanks), cell.size()));
    cell.erase(cell.find_last_not_of(kBlanks) + 1);
  }
  return cells;
}

// Place of each column; the length of the line for one that is not there.
std::array<std::size_t, kPlaceColumns.size()> place_columns(const std::vector<std::string>& names,
                                                            const std::string& place) {
  std::array<std::size_t, kPlaceColumns.size()> at{};
  for (std::size_t c = 0; c < at.size(); ++c) {
    at[c] = static_cast<std::size_t>(std::ranges::find(names, kPlaceColumns[c]) - names.begin());
    if (at[c] == names.size() && c < kNeededColumns)
      throw InputError(
          place, fmt::format("has no column {}; needed are {}", kPlaceColumns[c],
                             fmt::join(kPlaceColumns.begin(), kPlaceColumns.begin() + kNeededColumns, ", ")));
  }
  return at;
}

// Seconds from the first to the last depth frame of a sensor.
double depth_length_s(const SessionReader& session, HostTime start) {
  double length_s = 0.0;
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    const std::uint64_t count = session.counts(s).depth_frames;
    if (count == 0) continue;
    const FrameStamp last = session.stamps(s, FrameStream::depth, count - 1, 1).front();
    length_s = std::max(length_s, (fit_sensor_clock(session, s)(last) - start).seconds());
  }
  return length_s;
}

}  // namespace

std::vector<WandPlace> read_stated_places(const std::filesystem::path& csv, const SessionReader& session) {
  constexpr std::size_t kReadBytes = 1 << 16;
  LineReader lines(csv, kReadBytes);
  std::string_view line;
  const std::vector<std::string> names = lines.next(line) ? plain_cells(line) : std::vector<std::string>{};
  const auto at = place_columns(names, lines.place());
  std::vector<std::string> sensors;
  for (const SensorDescription& sensor : session.header().sensors) sensors.push_back(sensor.name);
  const HostTime start = start_of_depth(session);
  const double length_s = depth_length_s(session, start);
  std::vector<WandPlace> places;
  while (lines.next(line)) {
    if (line.empty()) continue;
    const std::vector<std::string> cells = plain_cells(line);
    if (cells.size() != names.size())
      throw InputError(lines.place(),
                       fmt::format("has {} cells under {} columns", cells.size(), names.size()));
    const auto number = [&](std::size_t c) {
      return number_in(cells[at[c]], kPlaceColumns[c], lines.place());
    };
    const double from_s = number(0), to_s = number(1);
    if (!(to_s > from_s)) throw InputError(lines.place(), "to_s must be later than from_s");
    if (to_s < 0.0 || from_s > length_s)
      throw InputError(
          lines.place(),
          fmt::format("from {:g} to {:g} s lies outside the recording, whose depth lasts {:.1f} s", from_s,
                      to_s, length_s));
    const auto sensor = std::ranges::find(sensors, cells[at[2]]);
    if (sensor == sensors.end())
      throw InputError(lines.place(), fmt::format("names sensor \"{}\"; {}", cells[at[2]],
                                                  known_names(cells[at[2]], sensors)));
    WandPlace place{start + duration_from_s(from_s), start + duration_from_s(to_s)};
    place.sensor = static_cast<std::size_t>(sensor - sensors.begin());
    place.distance_m = stated_distance_m(number(3), lines.place());
    if (!places.empty())
      place.place =
          places.back().place + (place.first != places.back().first || place.last != places.back().last);
    if (at[4] < names.size() && !cells[at[4]].empty()) place.angle_rad = number(4) * kRadPerDegree;
    places.push_back(place);
  }
  if (places.empty()) throw InputError(csv.string(), "states no place");
  return places;
}

WandRecording measure_stated_distances(const StatedDistances& stated, std::uint64_t frames,
                                       const RunControl& control) {
  const SessionReader session(stated.session);
  WandRecording recording;
  recording.truth = WandTruth::stated;
  recording.ball_radius_m = stated.ball_radius_m;
  recording.frames = frames;
  const std::vector<WandPlace> places = read_stated_places(stated.places, session);
  const std::vector<PlaceOutcome> outcomes = measure_places(session, places, recording, control);
  std::vector<FoundBalls> found(recording.sensors.size());
  for (std::size_t p = 0; p < places.size(); ++p) {
    if (outcomes[p].status.back() != WandStatus::found) continue;
    const Eigen::Vector3d& centre_m = outcomes[p].centre_in_sensor_m.back();  // by ours
    FoundBalls& balls = found[places[p].sensor];
    balls.place.push_back(places[p].place);
    balls.stated_m.push_back(places[p].distance_m);
    balls.found_m.push_back(centre_m.norm());
    if (places[p].angle_rad)
      balls.angle_off_deg.push_back(std::abs(angle_of(centre_m) - *places[p].angle_rad) * kDegreesPerRad);
  }
  check_stated(stated.places.string(), found, recording);
  return recording;
}

}  // namespace trilat
