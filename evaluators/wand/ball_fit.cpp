// SPDX-License-Identifier: MIT
#include "evaluators/wand/ball_fit.h"

#include <algorithm>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>

#include "datasets/base/median.h"
namespace trilat {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kRoundingVariance_m2 = 1e-6 / 12.0;  // depths are whole millimetres
constexpr std::size_t kCoarsePixels = 300;            // enough for the first steps
constexpr double kMaxBehindShare = 0.25;      // in the first steps, when the centre may be somewhat off
constexpr double kMaxInnerBehindShare = 0.1;  // once pixels are chosen by the noise
constexpr double kGateSigmas = 4.0;
constexpr int kBeside_px = 2;            // none is used so near one that is hidden
constexpr double kMaxNoiseFactor = 2.5;  // an image may be noisier than the model, within reason

// Point at which a ray meets the ball: t d = point, |t d - c| = r. With d_z = 1, t is the depth along z.
struct Intersection {
  double depth_m;
  double sine;               // of the angle between ray and surface normal
  double cosine;             // of the same
  Vector3d depth_by_centre;  // derivatives
  double depth_by_radius;
};

std::optional<Intersection> intersect_ball(const RayDepth& pixel, const Vector3d& centre, double radius_m) {
  const Vector3d d(pixel.x, pixel.y, 1.0);
  const double a = d.squaredNorm();
  const double b = d.dot(centre);
  const double distance2 = (centre - (b / a) * d).squaredNorm();  // of the centre from the ray
  const double half_chord2 = radius_m * radius_m - distance2;
  if (!(half_chord2 > 0.0)) return std::nullopt;
  const double half_chord = std::sqrt(half_chord2);
  const double length = std::sqrt(a);
  const double t = b / a - half_chord / length;
  const double scale = 1.0 / (half_chord * length);
  return Intersection{t, std::sqrt(distance2) / radius_m, half_chord / radius_m, scale * (centre - t * d),
                      -radius_m * scale};
}

double variance_m2(const BallFitOptions& options, const Intersection& meeting) {
  const double axial_m = options.noise.sigma_m(meeting.depth_m, std::acos(std::min(1.0, meeting.cosine)));
  const double lateral_m = options.lateral_sigma_m * meeting.sine / meeting.cosine;
  return axial_m * axial_m + lateral_m * lateral_m + kRoundingVariance_m2;
}

struct Sums {
  Matrix4d normal = Matrix4d::Zero();
  Vector4d right = Vector4d::Zero();
  double chi2 = 0.0;
  double residual2_m2 = 0.0;
  double variance_m2 = 0.0;
  int used = 0;
  int looked_at = 0;  // in the first steps: also those beyond the gate, and of these those behind the ball
  int behind = 0;

  void add(const Intersection& meeting, double residual_m, double pixel_variance_m2) {
    Vector4d row;
    row << meeting.depth_by_centre, meeting.depth_by_radius;
    const double weight = 1.0 / pixel_variance_m2;
    normal.noalias() += weight * row * row.transpose();
    right += weight * residual_m * row;
    chi2 += weight * residual_m * residual_m;
    residual2_m2 += residual_m * residual_m;
    variance_m2 += pixel_variance_m2;
    ++used;
  }
};

// Beyond the first, a pixel lies in the ball's disc without counting: it sees the surface at too large an
// angle or lies less than `pixels_inside` inside the outline.
double max_sine(const Vector3d& centre, const BallFitOptions& options, double pixels_inside) {
  const double outline_px = options.radius_m / (centre.norm() * options.pixel_rad);
  return std::min(std::sin(options.max_angle_rad), 1.0 - pixels_inside / outline_px);
}

class Fitter {
 public:
  Fitter(std::span<const RayDepth> pixels, const Vector3d& start, const BallFitOptions& options)
      : pixels_(pixels), options_(options), centre_(start) {}

  BallFit run() {
    const double r = options_.radius_m;
    const auto on_ball = std::ranges::count_if(
        pixels_, [&](const RayDepth& pixel) { return intersect_ball(pixel, centre_, r).has_value(); });
    const std::size_t stride = static_cast<std::size_t>(on_ball) / kCoarsePixels + 1;
    for (const double gate_m : {0.6 * r, 0.6 * r, 0.6 * r, 0.3 * r, 0.3 * r}) {
      const Sums sums = coarse(gate_m, stride);
      if (sums.behind > kMaxBehindShare * sums.looked_at) {
        failed(BallFitStatus::see_through_pixels);
        return result_;
      }
      if (!step(sums)) return result_;
    }
    for (int i = 0; i < 2; ++i)
      if (!choose() || !step(sums_of_chosen())) return result_;
    if (choose()) descend();
    return result_;
  }

 private:
  // Cosine squared as weight: near the outline a small shift of the centre changes depths much.
  Sums coarse(double gate_m, std::size_t stride) const {
    Sums sums;
    const double limit = max_sine(centre_, options_, 1.0);
    for (std::size_t i = 0; i < pixels_.size(); i += stride) {
      if (pixels_[i].depth_m <= 0.0) continue;
      const auto meeting = intersect_ball(pixels_[i], centre_, options_.radius_m);
      if (!meeting || meeting->sine > limit) continue;
      const double residual_m = pixels_[i].depth_m - meeting->depth_m;
      ++sums.looked_at;
      if (residual_m >= gate_m)
        ++sums.behind;
      else if (residual_m > -gate_m)
        sums.add(*meeting, residual_m, 1.0 / (meeting->cosine * meeting->cosine));
    }
    return sums;
  }

  // A pixel on the ball as it is now; the residual in units of the noise model's sigma.
  struct Seen {
    std::uint32_t pixel;
    float in_sigmas;
    double variance_m2;
    bool inner;
  };

  // All pixels with a depth, and the counts that do not depend on the gate.
  std::vector<Seen> seen_on_ball() {
    std::vector<Seen> seen;
    seen.reserve(pixels_.size());
    const double limit = max_sine(centre_, options_, 1.0);
    const double inner_limit = max_sine(centre_, options_, 2.0);
    result_.inner = result_.inner_invalid = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const auto meeting = intersect_ball(pixels_[i], centre_, options_.radius_m);
      if (!meeting || meeting->sine > limit) continue;
      const bool inner = meeting->sine <= inner_limit;
      result_.inner += inner;
      if (pixels_[i].depth_m <= 0.0) {
        result_.inner_invalid += inner;
        continue;
      }
      const double residual_m = pixels_[i].depth_m - meeting->depth_m;
      const double pixel_m2 = variance_m2(options_, *meeting);
      seen.push_back({static_cast<std::uint32_t>(i), static_cast<float>(residual_m / std::sqrt(pixel_m2)),
                      pixel_m2, inner});
    }
    return seen;
  }

  // Fills chosen_ with the pixels that agree with the ball as it is now.
  bool choose() {
    const std::vector<Seen> seen = seen_on_ball();
    if (static_cast<int>(seen.size()) < kMinBallPixels) return failed(BallFitStatus::too_few_pixels);
    const float gate = static_cast<float>(kGateSigmas * noise_factor(seen));
    chosen_.clear();
    result_.inner_agreeing = result_.inner_behind = 0;
    for (const Seen& s : seen) {
      if (std::abs(s.in_sigmas) < gate) {
        chosen_.push_back(s);
        result_.inner_agreeing += s.inner;
      } else {
        result_.inner_behind += s.inner && s.in_sigmas > 0.0F;
      }
    }
    if (result_.inner_behind > kMaxInnerBehindShare * result_.inner)
      return failed(BallFitStatus::see_through_pixels);
    leave_out_beside_hidden(seen, gate);
    return true;
  }

  // A stick or finger before the ball meets it somewhere: beside what is clearly before it, some of it lies
  // too near the ball's surface to be told from noise, and would pull the centre.
  void leave_out_beside_hidden(const std::vector<Seen>& seen, float gate) {
    const int half =
        kBeside_px + 1 + static_cast<int>(1.5 * options_.radius_m / centre_.z() / options_.pixel_rad);
    const int side = 2 * half + 1;
    std::vector<bool> beside(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), false);
    const auto at = [&](const Seen& s, int right, int down) {
      const auto cell = [&](double ray, double middle) {
        const auto from_middle = std::lround((ray - middle / centre_.z()) / options_.pixel_rad);
        return static_cast<int>(std::clamp<long>(from_middle, kBeside_px - half, half - kBeside_px)) + half;
      };
      const int row = cell(pixels_[s.pixel].y, centre_.y()) + down;
      return static_cast<std::size_t>(row * side + cell(pixels_[s.pixel].x, centre_.x()) + right);
    };
    for (const Seen& s : seen)
      if (s.in_sigmas <= -gate)
        for (int down = -kBeside_px; down <= kBeside_px; ++down)
          for (int right = -kBeside_px; right <= kBeside_px; ++right) beside[at(s, right, down)] = true;
    std::erase_if(chosen_, [&](const Seen& s) { return beside[at(s, 0, 0)]; });
  }

  // How much noisier than the model the image is, by the median: hidden pixels shall not count.
  static double noise_factor(const std::vector<Seen>& seen) {
    std::vector<float> sizes(seen.size());
    std::transform(seen.begin(), seen.end(), sizes.begin(),
                   [](const Seen& s) { return std::abs(s.in_sigmas); });
    return std::clamp(1.4826 * static_cast<double>(upper_median(sizes)), 1.0, kMaxNoiseFactor);
  }

  // Weights stay those of the centre at which the pixels were chosen.
  Sums sums_of_chosen() const {
    Sums sums;
    for (const Seen& s : chosen_)
      if (const auto meeting = intersect_ball(pixels_[s.pixel], centre_, options_.radius_m))
        sums.add(*meeting, pixels_[s.pixel].depth_m - meeting->depth_m, s.variance_m2);
    return sums;
  }

  // One Gauss-Newton step of the centre.
  bool step(const Sums& sums) {
    if (sums.used < kMinBallPixels) return failed(BallFitStatus::too_few_pixels);
    const Eigen::LDLT<Matrix3d> factors(sums.normal.topLeftCorner<3, 3>());
    if (!(factors.vectorD().minCoeff() > 1e-9 * factors.vectorD().maxCoeff()))
      return failed(BallFitStatus::rank_deficient);
    const Vector3d step_m = factors.solve(sums.right.head<3>());
    step_m_ = step_m.norm();
    if (!(step_m_ < options_.radius_m)) return failed(BallFitStatus::left_start);
    centre_ += step_m;
    return true;
  }

  void descend() {
    for (int i = 0; i < 8; ++i) {
      if (!step(sums_of_chosen())) return;
      if (step_m_ < kBallStep_m) return conclude(sums_of_chosen());
    }
    failed(BallFitStatus::iteration_limit);
  }

  void conclude(const Sums& sums) {
    const double reduced_chi2 = sums.chi2 / std::max(1, sums.used - 3);
    const double scale = std::max(1.0, reduced_chi2);
    result_.centre_in_sensor_m = centre_;
    result_.covariance_m2 = scale * sums.normal.topLeftCorner<3, 3>().ldlt().solve(Matrix3d::Identity());
    result_.rms_m = std::sqrt(sums.residual2_m2 / sums.used);
    result_.expected_rms_m = std::sqrt(sums.variance_m2 / sums.used);
    const Eigen::LDLT<Matrix4d> free_radius(sums.normal);
    result_.radius_excess_m = free_radius.solve(sums.right)[3];
    result_.radius_sigma_m = std::sqrt(scale * free_radius.solve(Vector4d::Unit(3))[3]);
    result_.used = sums.used;
    result_.status = BallFitStatus::fitted;
  }

  bool failed(BallFitStatus status) {
    result_.status = status;
    return false;
  }

  std::span<const RayDepth> pixels_;
  const BallFitOptions& options_;
  Vector3d centre_;
  double step_m_ = NAN;
  std::vector<Seen> chosen_;
  BallFit result_;
};

}  // namespace

BallFit fit_ball(std::span<const RayDepth> pixels, const Vector3d& start_in_sensor_m,
                 const BallFitOptions& options) {
  return Fitter(pixels, start_in_sensor_m, options).run();
}

DepthSensitivity depth_influence(const Vector3d& centre_in_sensor_m, const BallFitOptions& options) {
  constexpr int kHalf = 16;  // rays to each side of the middle; a thousand make sums of an integral
  const Vector3d middle = centre_in_sensor_m / centre_in_sensor_m.z();
  // Off the axis the disc is stretched by up to 1 / cos^2 of the angle.
  const double step = 1.1 * options.radius_m * middle.squaredNorm() / centre_in_sensor_m.norm() / kHalf;
  const double limit = max_sine(centre_in_sensor_m, options, 1.0);
  Matrix3d normal = Matrix3d::Zero();
  Vector3d by_error = Vector3d::Zero(), by_depth = Vector3d::Zero();
  double weights = 0.0, depths = 0.0;
  for (int row = -kHalf; row <= kHalf; ++row)
    for (int column = -kHalf; column <= kHalf; ++column) {
      const RayDepth ray{middle.x() + column * step, middle.y() + row * step, 0.0};
      const auto meeting = intersect_ball(ray, centre_in_sensor_m, options.radius_m);
      if (!meeting || meeting->sine > limit) continue;
      const double weight = 1.0 / variance_m2(options, *meeting);
      const Vector3d gradient = weight * meeting->depth_by_centre;
      normal += gradient * meeting->depth_by_centre.transpose();
      by_error += gradient;
      by_depth += meeting->depth_m * gradient;
      weights += weight;
      depths += weight * meeting->depth_m;
    }
  const Eigen::LDLT<Matrix3d> factors(normal);
  const double depth_m = depths / weights;
  return {depth_m, factors.solve(by_error), factors.solve(by_depth - depth_m * by_error)};
}

}  // namespace trilat
