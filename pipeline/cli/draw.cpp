// SPDX-License-Identifier: MIT
// `trilat draw`: one depth frame as a picture, with the bodies and the wand's ball that were found in it.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>
#include <png.h>

#include "datasets/base/error.h"
#include "datasets/session/clock/session_clock.h"
#include "datasets/session/session_reader.h"
#include "evaluators/wand/find_wand.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/skeleton_preview.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

struct DrawArguments {
  std::filesystem::path session, calibration, output;
  std::string sensor;
  std::uint64_t frame = 0;
  double ball_radius_m = FindWandOptions{}.ball_radius_m;
  bool force = false;
};

constexpr int kScale = 2;  // pixels of the picture for one of the sensor
constexpr double kMinDistance_m = 0.5, kMaxDistance_m = 4.5;
const cv::Scalar kWhite(255, 255, 255), kBall(255, 0, 255), kWand(255, 160, 255);

// The depths from 0.5 m to 4.5 m as colours; black where nothing was seen.
cv::Mat in_colours(const cv::Mat& depth_mm) {
  constexpr double kSlope = 255.0 / (1e3 * (kMaxDistance_m - kMinDistance_m));
  cv::Mat grey, picture;
  depth_mm.convertTo(grey, CV_8UC1, -kSlope, 255.0 + 1e3 * kMinDistance_m * kSlope);
  cv::applyColorMap(grey, picture, cv::COLORMAP_TURBO);
  picture.setTo(cv::Scalar(0, 0, 0), depth_mm == 0);
  return picture;
}

// Tints the ball's pixels and what holds it: what is connected with it within eight of its radii, and no
// deeper than it.
void tint_wand(cv::Mat& picture, const DepthImageView& image, const DepthRays& rays,
               const Eigen::Vector3d& centre_m, double radius_m) {
  cv::Mat mask = cv::Mat::zeros(image.height_px, image.width_px, CV_8UC1), parts;
  const auto distance_m = [&](int row, int column) {
    const std::uint16_t depth_mm = image.at_mm(column, row);
    return depth_mm == 0 ? std::numeric_limits<double>::infinity()
                         : (rays.point_in_sensor_m(column, row, 1e-3 * depth_mm) - centre_m).norm();
  };
  for (int row = 0; row < mask.rows; ++row)
    for (int column = 0; column < mask.cols; ++column)
      if (distance_m(row, column) < 8.0 * radius_m &&
          1e-3 * image.at_mm(column, row) < centre_m.z() + radius_m)
        mask.at<std::uint8_t>(row, column) = 1;
  cv::connectedComponents(mask, parts);
  const auto middle = project(rays.intrinsics, centre_m);
  if (!middle) return;
  const cv::Point ball(static_cast<int>(std::lround(middle->x())),
                       static_cast<int>(std::lround(middle->y())));
  if (!ball.inside(cv::Rect(0, 0, mask.cols, mask.rows))) return;  // only a part of it is in the image
  for (int row = 0; row < mask.rows; ++row)
    for (int column = 0; column < mask.cols; ++column)
      if (mask.at<std::uint8_t>(row, column) != 0 && parts.at<int>(row, column) == parts.at<int>(ball)) {
        const cv::Scalar& colour = distance_m(row, column) < 1.2 * radius_m ? kBall : kWand;
        picture.at<cv::Vec3b>(row, column) =
            cv::Vec3b(static_cast<std::uint8_t>(colour[0]), static_cast<std::uint8_t>(colour[1]),
                      static_cast<std::uint8_t>(colour[2]));
      }
}

// The bodies that a sensor gave nearest to a time, at most 50 ms off; none without.
BodyFrame bodies_at(const SessionReader& session, std::size_t sensor, HostTime time) {
  constexpr std::int64_t kMax_ns = 50'000'000;
  const std::uint64_t count = session.counts(sensor).body_frames;
  if (count == 0) return {};
  const SensorClockMap host_from_sensor = fit_sensor_clock(session, sensor);
  const std::vector<FrameStamp> stamps = session.stamps(sensor, FrameStream::bodies, 0, count);
  std::uint64_t nearest = 0;
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::max();
  for (std::uint64_t i = 0; i < count; ++i)
    if (const std::int64_t off_ns = std::abs((host_from_sensor(stamps[i]) - time).ns); off_ns < least_ns) {
      least_ns = off_ns;
      nearest = i;
    }
  return least_ns <= kMax_ns ? session.body_frames(sensor, nearest, 1).front() : BodyFrame{};
}

// The person whom all sensors see, as this one would see it.
BodyFrame person_of_all(const SessionReader& session, std::size_t sensor, HostTime time,
                        const std::filesystem::path& file) {
  const Calibration calibration = read_calibration(file);
  std::vector<BodyFrame> frames;
  std::vector<RigidTransform> poses;
  const auto add = [&](std::size_t s) {
    frames.push_back(bodies_at(session, s, time));
    poses.push_back(pose_of(calibration, session.header().sensors[s].name, file.string()).world_from_sensor);
  };
  add(sensor);
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s)
    if (s != sensor) add(s);
  return fused_frame(frames, poses);
}

void write_png(const cv::Mat& picture, const std::filesystem::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(picture.cols);
  png.height = static_cast<png_uint_32>(picture.rows);
  png.format = PNG_FORMAT_BGR;
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(png), '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, picture.data, 0, nullptr) == 0)
    throw OutputError(file.string(), std::string("cannot be made: ") + png.message);
  write_file(file, std::string_view(bytes).substr(0, size));
}

int draw(const DrawArguments& a) {
  const SessionReader session(a.session);
  const std::size_t sensor = session.sensor_index(a.sensor);
  const SensorDescription& description = session.header().sensors[sensor];
  const std::uint64_t frames = session.counts(sensor).depth_frames;
  const std::string place = a.session.string() + ":/sensors/" + a.sensor;
  if (frames == 0) throw InputError(place, "has no depth frames, which are what is drawn");
  if (a.frame >= frames)
    throw InputError("--frame",
                     fmt::format("is {}; {} has depth frames 0 to {}", a.frame, place, frames - 1));
  if (description.intrinsics.width_px != kDepthWidth || description.intrinsics.height_px != kDepthHeight)
    throw InputError(place, fmt::format("must have images of {} x {} pixels", kDepthWidth, kDepthHeight));
  if (a.output.extension() != ".png") throw InputError(a.output.string(), "must end in .png");
  check_output_file({a.output, {a.session, a.calibration}, a.force});

  cv::Mat depth_mm(kDepthHeight, kDepthWidth, CV_16UC1);
  const std::span<std::uint16_t> pixels(depth_mm.ptr<std::uint16_t>(), kDepthPixels);
  session.depth_frame(sensor, a.frame, pixels);
  const HostTime time =
      fit_sensor_clock(session, sensor)(session.stamps(sensor, FrameStream::depth, a.frame, 1).front());
  cv::Mat picture = in_colours(depth_mm);

  const DepthRays rays = depth_rays(description.intrinsics);
  const DepthImageView image{kDepthWidth, kDepthHeight, pixels};
  const WandSighting wand = find_wand(image, rays, {.ball_radius_m = a.ball_radius_m});
  const bool has_ball = wand.status == WandStatus::found;
  if (has_ball) tint_wand(picture, image, rays, wand.centre_in_sensor_m, a.ball_radius_m);
  cv::resize(picture, picture, {}, kScale, kScale, cv::INTER_NEAREST);
  const BodyFrame bodies = bodies_at(session, sensor, time);
  draw_bodies(picture, bodies, description.intrinsics, kScale, kWhite);
  if (!a.calibration.empty())
    draw_bodies(picture, person_of_all(session, sensor, time, a.calibration), description.intrinsics, kScale,
                kBall);

  std::string found =
      has_ball ? fmt::format("ball at {:.3f} m", wand.centre_in_sensor_m.norm()) : name_of(wand.status);
  std::ranges::replace(found, '_', ' ');
  const std::string text =
      fmt::format("{}, depth frame {}{}: bodies: {}, {}", a.sensor, a.frame,
                  session.header().simulated ? ", simulated" : "", bodies.bodies.size(), found);
  cv::putText(picture, text, {8, picture.rows - 10}, cv::FONT_HERSHEY_SIMPLEX, 0.6, kWhite, 1, cv::LINE_AA);
  write_png(picture, a.output);
  fmt::print("{}\n{}: nearest 0.5 m red, farthest 4.5 m blue, black where nothing was seen\n", text,
             a.output.string());
  return kDone;
}

}  // namespace

void add_draw(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<DrawArguments>(app, code, "draw",
                                           "one depth frame as a picture, with bodies and the wand's ball",
                                           draw, OnInterrupt::at_once);
  verb.add_option("session", a.session, "session.h5 with depth")->required();
  verb.add_option("--sensor", a.sensor, "whose frame")->required();
  verb.add_option("--frame", a.frame, "which depth frame, from 0")->capture_default_str();
  verb.add_option("-o,--output", a.output, "depth.png")->required();
  verb.add_option("--calibration", a.calibration,
                  "poses of the sensors; draws the person whom all see together, too");
  verb.add_option("--ball-radius-m", a.ball_radius_m, "radius of the wand's ball")
      ->check(CLI::Range(0.01, 0.5))
      ->capture_default_str();
  add_force(verb, a.force);
  verb.footer("Example: trilat draw session.h5 --sensor k1 --frame 100 -o depth.png");
}

}  // namespace trilat
