// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/marker_track.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/rig/campaign.h"
#include "evaluators/alignment/interpolation.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

MarkerTrack::MarkerTrack(MocapTake positions, std::vector<std::vector<std::size_t>> markers_of_point,
                         Duration longest_gap, bool has_z_up)
    : positions_(std::move(positions)),
      markers_of_point_(std::move(markers_of_point)),
      longest_gap_(longest_gap),
      has_z_up_(has_z_up) {}

// Position of a marker; `after` is the first frame that is not before t.
Eigen::Vector3d MarkerTrack::marker_at(std::size_t marker, std::size_t after, MocapTime t) const {
  const std::vector<Eigen::Vector3d>& position_m = positions_.position_m[marker];
  const auto is_near = [&](std::size_t frame) {
    const Duration off = positions_.time[frame] < t ? t - positions_.time[frame] : positions_.time[frame] - t;
    return off <= longest_gap_;
  };
  const auto is_there = [&](std::size_t frame) { return position_m[frame].x() == position_m[frame].x(); };
  while (after < position_m.size() && !is_there(after) && is_near(after)) ++after;
  if (after == position_m.size() || !is_there(after)) return Eigen::Vector3d::Constant(kNaN);
  if (positions_.time[after] == t) return position_m[after];
  std::size_t before = after;
  while (before > 0 && (!(positions_.time[before] < t) || (!is_there(before) && is_near(before)))) --before;
  if (!(positions_.time[before] < t) || !is_there(before)) return Eigen::Vector3d::Constant(kNaN);
  return interpolate(t, positions_.time[before], position_m[before], positions_.time[after],
                     position_m[after], longest_gap_)
      .value_or(Eigen::Vector3d::Constant(kNaN));
}

void MarkerTrack::at(MocapTime t, std::span<Eigen::Vector3d> points) const {
  const auto earlier = [](MocapTime a, MocapTime b) { return a < b; };
  const auto after = static_cast<std::size_t>(std::ranges::lower_bound(positions_.time, t, earlier) -
                                              positions_.time.begin());
  for (std::size_t j = 0; j < points.size(); ++j) {
    const std::vector<std::size_t>& markers = markers_of_point_[j];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::size_t marker : markers) sum += marker_at(marker, after, t);
    points[j] = markers.empty() ? Eigen::Vector3d::Constant(kNaN)
                                : Eigen::Vector3d(sum / static_cast<double>(markers.size()));
    if (has_z_up_) points[j] = y_up_from_z_up(points[j]);
  }
}

MocapTime MarkerTrack::end() const { return positions_.time.empty() ? MocapTime{} : positions_.time.back(); }

std::vector<bool> MarkerTrack::repeated_frames() const {
  std::vector<bool> repeated(positions_.time.size(), false);
  for (std::size_t frame = 1; frame < positions_.time.size(); ++frame) {
    bool any = false, same = true;
    for (const std::vector<Eigen::Vector3d>& position_m : positions_.position_m) {
      if (position_m.empty() || !position_m[frame].allFinite()) continue;
      any = true;
      same = same && position_m[frame] == position_m[frame - 1];
    }
    repeated[frame] = any && same;
  }
  return repeated;
}

namespace {

// "120 positions (RWrist 116, head 4)"; nothing where there are none.
std::string counted_by_name(const MocapTake& positions, std::int64_t MissingCounts::*count) {
  constexpr std::size_t kMaxNames = 8;
  std::int64_t sum = 0;
  std::vector<std::pair<std::int64_t, std::string>> names;
  for (std::size_t a = 0; a < positions.missing.size(); ++a) {
    const std::int64_t own = positions.missing[a].*count;
    sum += own;
    if (own > 0) names.emplace_back(own, positions.header.assets[a].name);
  }
  if (sum == 0) return "";
  std::ranges::stable_sort(names, std::greater{}, &std::pair<std::int64_t, std::string>::first);
  std::string text;
  for (std::size_t k = 0; k < std::min(kMaxNames, names.size()); ++k)
    text += fmt::format("{}{} {}", k == 0 ? "" : ", ", names[k].second, names[k].first);
  if (names.size() > kMaxNames) text += fmt::format(" and {} more", names.size() - kMaxNames);
  return fmt::format("{} positions ({})", sum, text);
}

// The step to which all positions are rounded where it is a centimetre or more; positions that hardly differ
// show none.
std::optional<double> rounding_m(const MocapTake& positions) {
  constexpr std::size_t kMaxFrames = 1000, kMinValues = 20;
  constexpr double kNear_m = 1e-6;
  for (const double step_m : {0.1, 0.01}) {
    std::set<double> values;
    bool all = true;
    for (const std::vector<Eigen::Vector3d>& position_m : positions.position_m) {
      const std::size_t stride = 1 + position_m.size() / kMaxFrames;
      for (std::size_t frame = 0; all && frame < position_m.size(); frame += stride)
        for (const double x_m : position_m[frame]) {
          if (!std::isfinite(x_m)) continue;
          all = all && std::abs(x_m - step_m * std::round(x_m / step_m)) < kNear_m;
          values.insert(x_m);
        }
    }
    if (all && values.size() >= kMinValues) return step_m;
  }
  return std::nullopt;
}

// Stretches in which all stand still, and a rate of frames that is lower than the stated one.
std::vector<std::string> repeat_texts(const MarkerTrack& track) {
  constexpr double kMaxRepeated = 0.2;  // of the other frames
  const Duration kMinFrozen = duration_from_s(1.0);
  const std::vector<bool> repeated = track.repeated_frames();
  const std::vector<MocapTime>& time = track.positions().time;
  std::vector<std::string> frozen;
  std::size_t in_frozen = 0, elsewhere = 0;
  for (std::size_t first = 0, end = 0; first < time.size(); first = end) {
    for (end = first + 1; end < time.size() && repeated[end];) ++end;
    const bool is_long = time[end - 1] - time[first] >= kMinFrozen;
    (is_long ? in_frozen : elsewhere) += end - first - 1;
    if (is_long)
      frozen.push_back(fmt::format("{:.2f} to {:.2f} s", (time[first] - MocapTime{}).seconds(),
                                   (time[end - 1] - MocapTime{}).seconds()));
  }
  std::vector<std::string> texts;
  constexpr std::size_t kMaxNamed = 4;
  if (!frozen.empty())
    texts.push_back(fmt::format(
        "repeats all its positions to the last digit from {} after its first frame{}, as a system does that "
        "lost the person; leave these frames without positions",
        fmt::join(std::span(frozen).first(std::min(kMaxNamed, frozen.size())), ", "),
        frozen.size() > kMaxNamed ? fmt::format(" and {} times more", frozen.size() - kMaxNamed) : ""));
  const double share =
      static_cast<double>(elsewhere) / std::max(1.0, static_cast<double>(time.size() - in_frozen));
  if (const auto step_m = rounding_m(track.positions()))
    texts.push_back(
        fmt::format("has all positions in whole steps of {:g} cm: errors below that are its rounding; export "
                    "it with more decimals",
                    100.0 * *step_m));
  else if (share > kMaxRepeated)
    texts.push_back(fmt::format(
        "repeats the positions of the frame before in {:.0f} % of its frames, so its true rate is {:.0f} % "
        "of the stated one, and what moves stands still between; export it at the rate of the capture",
        100.0 * share, 100.0 * (1.0 - share)));
  return texts;
}

}  // namespace

std::vector<std::string> suspicious_names(const MarkerTrack& track) {
  std::vector<std::string> odd = track.positions().taken_as;
  for (std::string& text : repeat_texts(track)) odd.push_back(std::move(text));
  for (const auto& [count, what] :
       {std::pair{&MissingCounts::held, "repeat the one before to the last digit while others move"},
        std::pair{&MissingCounts::at_origin, "are exactly (0, 0, 0), which is written for what is missing"},
        std::pair{&MissingCounts::filled,
                  "are one value again and again, which is written for what is missing"}})
    if (const std::string named = counted_by_name(track.positions(), count); !named.empty())
      odd.push_back(fmt::format("{} {}; they are not used as measurements", named, what));
  const MocapAnomalies& counted = track.positions().anomalies;
  if (counted.truncated_last_row || counted.repeated_frames > 0 || counted.partial_poses > 0)
    odd.push_back(
        fmt::format("{}{} repeated frames and {} incomplete poses were left out; `trilat info` says more",
                    counted.truncated_last_row ? "is cut off in its last row; " : "", counted.repeated_frames,
                    counted.partial_poses));
  if (counted.frames_promised > 0)
    odd.push_back(fmt::format("has {} frames where its header promises {}: was it cut?", counted.frames_there,
                              counted.frames_promised));
  if (counted.printed_time_differs > 0)
    odd.push_back(
        fmt::format("{} printed times are more than a frame off what frame number and rate give; is the "
                    "export's frame rate right?",
                    counted.printed_time_differs));
  return odd;
}

}  // namespace trilat
