// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/wand_errors.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/known_names.h"
#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "datasets/mocap/csv_cell.h"
#include "datasets/mocap/line_reader.h"
#include "datasets/session/clock/session_clock.h"
#include "evaluators/wand/printed_wand.h"
#include "pipeline/calibration/calibrate_wand.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

struct WandFinder {
  const char* name;
  bool is_ours = false;
  PrintedWandOptions printed = {};
};

std::vector<WandFinder> make_finders() {
  const PrintedWandOptions printed,
      corrected{Reading::corrected, Binarisation::corrected, Reading::corrected, Reading::corrected};
  PrintedWandOptions eq1 = corrected, e1 = corrected, e2 = corrected, e3 = corrected, mid_range = corrected;
  eq1.invalid_pixels = Reading::printed;
  e1.binarisation = Binarisation::printed;
  e2.projection = Reading::printed;
  e3.centre = Reading::printed;
  mid_range.binarisation = Binarisation::mid_range;
  return {{"as printed", false, printed},
          {"corrected, but eq. 1 as printed", false, eq1},
          {"corrected, but E1 as printed", false, e1},
          {"corrected, but E2 as printed", false, e2},
          {"corrected, but E3 as printed", false, e3},
          {"corrected", false, corrected},
          {"corrected by the mid-range", false, mid_range},
          {"ours", true}};
}

const std::vector<WandFinder>& finders() {
  static const std::vector<WandFinder> all = make_finders();
  return all;
}

// One sensor's depth frames, by the time of their exposure on the host clock.
struct DepthFrames {
  std::vector<HostTime> times;
  DepthRays rays;

  // At most `count` of those within a hold, spread over it.
  std::vector<std::uint64_t> within(const WandPlace& place, std::uint64_t count) const {
    const auto first = std::ranges::lower_bound(times, place.first) - times.begin();
    const auto last = std::ranges::upper_bound(times, place.last) - times.begin();
    const auto all = static_cast<std::uint64_t>(std::max<std::ptrdiff_t>(0, last - first));
    std::vector<std::uint64_t> frames;
    for (std::uint64_t k = 0; k < std::min(count, all); ++k)
      frames.push_back(static_cast<std::uint64_t>(first) + k * all / std::min(count, all));
    return frames;
  }
};

std::vector<DepthFrames> depth_frames(const SessionReader& session) {
  std::vector<DepthFrames> sensors;
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    DepthFrames& frames = sensors.emplace_back();
    const std::uint64_t count = session.counts(s).depth_frames;
    if (count == 0) continue;
    const SensorClockMap host_from_sensor = fit_sensor_clock(session, s);
    for (const FrameStamp& stamp : session.stamps(s, FrameStream::depth, 0, count))
      frames.times.push_back(host_from_sensor(stamp));
    frames.rays = depth_rays(session.header().sensors[s].intrinsics);
  }
  return sensors;
}

// What every method found at one place.
struct PlaceOutcome {
  std::vector<Eigen::Vector3d> centre_in_sensor_m;  // by method; NaN without an answer
  std::vector<WandStatus> status;
};

// The mean of the frames in which the ball was found, when it was in at least half of them.
void add_outcome(const std::vector<WandSighting>& sightings, PlaceOutcome& outcome) {
  std::vector<TimedSighting> found;
  WandStatus failure = sightings.empty() ? WandStatus::not_looked : WandStatus::no_wand;
  for (const WandSighting& sighting : sightings)
    if (sighting.status == WandStatus::found)
      found.push_back({HostTime{static_cast<std::int64_t>(found.size())}, sighting});
    else
      failure = sighting.status;
  const bool answered = !found.empty() && 2 * found.size() >= sightings.size();
  outcome.status.push_back(answered ? WandStatus::found : failure);
  outcome.centre_in_sensor_m.push_back(
      answered ? mean_of_rest(found, 0, WandPositionOptions{}.deviation).centre_in_sensor_m
               : Eigen::Vector3d::Constant(kNotMeasured));
}

PlaceOutcome find_at(const SessionReader& session, const DepthFrames& frames, const WandPlace& place,
                     double ball_radius_m, std::uint64_t count) {
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  std::vector<std::vector<WandSighting>> sightings(finders().size());
  for (const std::uint64_t frame : frames.within(place, count)) {
    session.depth_frame(place.sensor, frame, depth_mm);
    const DepthImageView image{kDepthWidth, kDepthHeight, depth_mm};
    for (std::size_t m = 0; m < sightings.size(); ++m) {
      PrintedWandOptions printed = finders()[m].printed;
      printed.ball_radius_m = ball_radius_m;
      sightings[m].push_back(finders()[m].is_ours
                                 ? find_wand(image, frames.rays, {.ball_radius_m = ball_radius_m})
                                 : find_wand_as_printed(image, frames.rays, printed));
    }
  }
  PlaceOutcome outcome;
  for (const std::vector<WandSighting>& of_method : sightings) add_outcome(of_method, outcome);
  return outcome;
}

double angle_of(const Eigen::Vector3d& point_in_sensor_m) {
  return std::atan2(point_in_sensor_m.head<2>().norm(), point_in_sensor_m.z());
}

// A place whose angle nobody states has that of the ball as ours finds it.
void add_samples(const WandPlace& place, const PlaceOutcome& outcome, WandRecording& recording) {
  double angle_rad = place.angle_rad.value_or(kNotMeasured);
  if (const Eigen::Vector3d& found_m = outcome.centre_in_sensor_m.back();
      std::isnan(angle_rad) && found_m.allFinite())
    angle_rad = angle_of(found_m);
  for (std::size_t m = 0; m < outcome.status.size(); ++m) {
    const Eigen::Vector3d& found_m = outcome.centre_in_sensor_m[m];
    WandSample& sample =
        recording.samples.emplace_back(WandSample{m, place.sensor, place.place, place.distance_m, angle_rad});
    sample.distance_error_m = std::abs(found_m.norm() - place.distance_m);
    if (place.ball_in_sensor_m) sample.error_m = (found_m - *place.ball_in_sensor_m).norm();
    ++recording.statuses[m][name_of(outcome.status[m])];
  }
}

// Calls `use` with each place and what was found there, in their order.
void measure_places(const SessionReader& session, const std::vector<WandPlace>& places,
                    WandRecording& recording, const Watch& watch,
                    const std::function<void(const WandPlace&, const PlaceOutcome&)>& use) {
  recording.simulated = session.header().simulated;
  for (const SensorDescription& sensor : session.header().sensors) recording.sensors.push_back(sensor.name);
  recording.statuses.resize(finders().size());
  const std::vector<DepthFrames> frames = depth_frames(session);
  std::vector<PlaceOutcome> outcomes(places.size());
  std::atomic<std::size_t> done{0};
  parallel_for_index(places.size(), 1, [&](std::size_t p) {
    watch.check();
    outcomes[p] =
        find_at(session, frames[places[p].sensor], places[p], recording.ball_radius_m, recording.frames);
    watch.tell(static_cast<double>(++done) / static_cast<double>(places.size()));
  });
  for (std::size_t p = 0; p < places.size(); ++p) {
    add_samples(places[p], outcomes[p], recording);
    use(places[p], outcomes[p]);
  }
}

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

// What a sensor sees of the ball at the places that are stated for it.
struct FoundBalls {
  std::vector<std::size_t> place;
  std::vector<double> stated_m, found_m;
  std::vector<double> angle_off_deg;  // where an angle is stated, too
};

// Median of the distances from what is stated to what is found, in metres.
double typical_off_m(const std::vector<double>& stated_m, const std::vector<double>& found_m) {
  std::vector<double> off_m;
  for (std::size_t i = 0; i < stated_m.size(); ++i) off_m.push_back(std::abs(found_m[i] - stated_m[i]));
  return off_m.empty() ? kNotMeasured : median(off_m);
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
                    "that of the ball's "
                    "centre, not of its surface",
                    csv, median(more_m) * kCentimetresPerMetre));
}

}  // namespace

const std::vector<std::string>& wand_method_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const WandFinder& finder : finders()) all.emplace_back(finder.name);
    return all;
  }();
  return names;
}

std::size_t wand_method(const std::string& name) {
  const auto& names = wand_method_names();
  const auto found = std::ranges::find(names, name);
  TRILAT_CHECK(found != names.end(), "a way to find the ball has another name");
  return static_cast<std::size_t>(found - names.begin());
}

namespace {

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

// Where each column stands; as far as the line is long for one that is not there.
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
                                       const Watch& watch) {
  const SessionReader session(stated.session);
  WandRecording recording;
  recording.truth = WandTruth::stated;
  recording.ball_radius_m = stated.ball_radius_m;
  recording.frames = frames;
  std::vector<FoundBalls> found(session.header().sensors.size());
  measure_places(
      session, read_stated_places(stated.places, session), recording, watch,
      [&](const WandPlace& place, const PlaceOutcome& outcome) {
        if (outcome.status.back() != WandStatus::found) return;
        FoundBalls& balls = found[place.sensor];
        const Eigen::Vector3d& centre_m = outcome.centre_in_sensor_m.back();
        balls.place.push_back(place.place);
        balls.stated_m.push_back(place.distance_m);
        balls.found_m.push_back(centre_m.norm());
        if (place.angle_rad)
          balls.angle_off_deg.push_back(std::abs(angle_of(centre_m) - *place.angle_rad) * kDegreesPerRad);
      });
  check_stated(stated.places.string(), found, recording);
  return recording;
}

namespace {

constexpr std::size_t kFolds = 10;
constexpr std::size_t kFirstPlaces = 3;  // which fix the wand's frame, and are never left out

const RestingBall* seen_by(const WandPosition& position, std::size_t sensor) {
  for (const RestingBall& ball : position.seen)
    if (ball.sensor == sensor) return &ball;
  return nullptr;
}

// The ball in the world where all sensors but one see it; nothing where no other does.
std::optional<Eigen::Vector3d> seen_by_others(const WandPosition& position, std::size_t sensor,
                                              const std::vector<SensorPose>& poses) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const RestingBall& ball : position.seen) {
    if (ball.sensor == sensor) continue;
    sum_m += poses[ball.sensor].world_from_sensor * ball.centre_in_sensor_m;
    count += 1.0;
  }
  if (count == 0.0) return std::nullopt;
  return sum_m / count;
}

// Whether a ball is wholly inside the image and not beyond where depth reaches.
bool is_whole_in_view(const DepthIntrinsics& intrinsics, const Eigen::Vector3d& ball_m, double radius_m) {
  constexpr double kMin_m = 0.2, kMax_m = 8.0;
  if (!(ball_m.z() > radius_m) || ball_m.norm() < kMin_m || ball_m.norm() > kMax_m) return false;
  const std::optional<Eigen::Vector2d> pixel = project(intrinsics, ball_m);
  const double margin_px = intrinsics.fx_px * radius_m / ball_m.z();
  return pixel && pixel->x() > margin_px && pixel->x() < intrinsics.width_px - margin_px &&
         pixel->y() > margin_px && pixel->y() < intrinsics.height_px - margin_px;
}

// The positions of one fold, or all others.
WandViews part_of(const WandViews& views, std::size_t fold, bool inside) {
  WandViews part = views;
  part.positions.clear();
  part.positions_of_first = 0;
  for (std::size_t p = 0; p < views.positions.size(); ++p) {
    const bool is_inside = p >= kFirstPlaces && p % kFolds == fold;
    if (is_inside != inside) continue;
    part.positions.push_back(views.positions[p]);
    part.positions_of_first += p < views.positions_of_first;
  }
  return part;
}

std::vector<WandPlace> left_out_places(const WandViews& views, const SessionReader& session,
                                       const CalibrateWandOptions& options) {
  std::vector<std::optional<Eigen::Vector3d>> known_m(views.positions.size());
  if (options.world)
    for (const KnownPoint& known : known_positions(*options.world, views.positions))
      known_m[known.point] = known.point_in_world_m;
  std::vector<WandPlace> places;
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    options.search.watch.check();
    if (part_of(views, fold, true).positions.empty()) continue;
    const std::vector<SensorPose> poses =
        calibrate_views(part_of(views, fold, false), session.path().string(), options).calibration.sensors;
    for (std::size_t p = kFirstPlaces; p < views.positions.size(); ++p) {
      if (p % kFolds != fold) continue;
      for (std::size_t s = 0; s < poses.size(); ++s) {
        const std::optional<Eigen::Vector3d> ball_m =
            options.world ? known_m[p] : seen_by_others(views.positions[p], s, poses);
        if (!ball_m) continue;
        const Eigen::Vector3d in_sensor_m = poses[s].world_from_sensor.inverse() * *ball_m;
        if (!is_whole_in_view(session.header().sensors[s].intrinsics, in_sensor_m,
                              options.search.find.ball_radius_m))
          continue;
        const RestingBall* rest = seen_by(views.positions[p], s);
        places.push_back({rest ? rest->first : views.positions[p].first,
                          rest ? rest->last : views.positions[p].last, s, p, in_sensor_m.norm(),
                          angle_of(in_sensor_m), in_sensor_m});
      }
    }
  }
  return places;
}

// The poses of one way to calibrate, less those that the campaign states.
void add_poses(const char* name, WandMethod method, const SessionReader& session, const WandViews& views,
               const CalibrateWandOptions& options, const Calibration& stated, WandRecording& recording) {
  WandCalibration made;
  try {
    made = calibrate_searched(method, session, options, views);
  } catch (const InputError& error) {
    recording.poses.push_back({.method = name, .sensor = "", .problem = error.problem()});
    return;
  }
  for (const SensorPose& pose : made.calibration.sensors) {
    const auto truth = std::ranges::find(stated.sensors, pose.name, &SensorPose::name);
    if (truth == stated.sensors.end()) continue;
    const RigidTransform off = pose.world_from_sensor * truth->world_from_sensor.inverse();
    PoseDifference& row = recording.poses.emplace_back(PoseDifference{name, pose.name});
    row.position_m = (pose.world_from_sensor.translation_m - truth->world_from_sensor.translation_m).norm();
    row.rotation_rad = Eigen::AngleAxisd(off.rotation).angle();
    if (!pose.covariance) continue;
    row.position_sigma_m = pose.position_sigma_m;
    row.rotation_sigma_rad = pose.rotation_sigma_rad;
  }
}

}  // namespace

WandRecording measure_wand(const CampaignWand& wand, const std::optional<Calibration>& stated,
                           std::uint64_t frames, const Watch& watch) {
  const std::vector<SessionReader> sessions([&] {
    std::vector<SessionReader> one;
    one.emplace_back(wand.session);
    return one;
  }());
  const SessionReader& session = sessions.front();
  CalibrateWandOptions options;
  options.search.find.ball_radius_m = wand.ball_radius_m;
  options.search.watch = {watch.stop_requested, [&](double share) { watch.tell(0.5 * share); }};
  if (!wand.mocap.empty()) {
    options.world = WandInWorld{wand.mocap, wand.asset, wand.mocap_start_host_ns};
    options.world->track = read_wand_track(wand.mocap, wand.asset);
  }
  WandViews views = view_wand(sessions, options);
  WandRecording recording;
  recording.truth = options.world ? WandTruth::optitrack : WandTruth::sensors;
  recording.ball_radius_m = wand.ball_radius_m;
  recording.frames = frames;
  calibrate_views(views, session.path().string(), options);  // says what a recording is lacking
  if (stated && options.world && stated->world == "optitrack")
    for (const auto& [name, method] : {std::pair{"wand, refined", WandMethod::wand},
                                       std::pair{"two positions, corrected", WandMethod::two_positions},
                                       std::pair{"two positions as printed", WandMethod::printed}})
      add_poses(name, method, session, views, options, *stated, recording);
  keep_useful_positions(views);
  if (views.positions.size() <= kFirstPlaces)
    throw InputError(
        wand.session.string(),
        fmt::format("shows the wand at rest at {} places that two sensors see; four are the least, "
                    "so that one can be left out",
                    views.positions.size()));
  measure_places(session, left_out_places(views, session, options), recording,
                 {watch.stop_requested, [&](double share) { watch.tell(0.5 + 0.5 * share); }},
                 [](const WandPlace&, const PlaceOutcome&) {});
  return recording;
}

}  // namespace trilat
