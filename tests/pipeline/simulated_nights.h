// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "datasets/base/philox.h"
#include "pipeline/errors/error_changes.h"

namespace trilat {

// How two nights differ. All of it is simulated: persons with errors of their own (3 cm an axis, fixed) and
// an own unrest, errors that drift with 1 s (1.5 cm an axis) and jitter (3 mm), shared by the methods but
// for a quarter of their own.
struct NightModel {
  std::size_t participants = 16;
  double duration_s = 35.0;
  bool same_recordings = true;  // else the same persons walk again
  double worse = 0.0;           // relative growth of the errors of method 0
};

class SimulatedNights {
 public:
  static constexpr std::size_t kMethods = 5, kGroups = 4, kAxes = 3;
  static constexpr double kRate_hz = 10.0, kDrift_s = 1.0;

  explicit SimulatedNights(std::uint64_t seed) : seed_(seed) {}

  struct Night {
    ErrorsByJoint before, now;
    std::vector<std::string> takes;
  };
  // `number`: which recordings, baseline and run of the code on them.
  Night night(std::uint64_t number, const NightModel& model) const {
    Night night;
    for (ErrorsByJoint* errors : {&night.before, &night.now}) {
      errors->conditions = {"walking"};
      errors->groups = {"head", "shoulder", "elbow", "wrist"};
      errors->methods = {"nonlinear", "linear", "mean", "rts", "window"};
    }
    for (std::size_t p = 0; p < model.participants; ++p) {
      night.takes.push_back("p" + std::to_string(p));
      add_take(number, p, model, night);
    }
    return night;
  }

 private:
  using Vector = std::array<double, kAxes>;

  // One joint's drift by all methods: the shared part and each method's own.
  struct Drift {
    std::array<Vector, kMethods + 1> value{};
    void step(const RandomStream& random, std::uint32_t& draw, double keep) {
      const double fresh = std::sqrt(1.0 - keep * keep);
      for (Vector& v : value)
        for (double& x : v) x = keep * x;
      for (std::size_t k = 0; k < (kMethods + 1) * kAxes; k += 2) {
        const auto pair = random.normal_pair(draw++);
        value[k / kAxes][k % kAxes] += fresh * pair[0];
        value[(k + 1) / kAxes][(k + 1) % kAxes] += fresh * pair[1];
      }
    }
  };

  static double length_of(const Vector& bias, const Drift& drift, std::size_t method, double scale,
                          double jitter) {
    constexpr double kOwn = 0.5;  // a quarter of the variance
    double squared = 0.0;
    for (std::size_t a = 0; a < kAxes; ++a) {
      const double w =
          std::sqrt(1.0 - kOwn * kOwn) * drift.value[kMethods][a] + kOwn * drift.value[method][a];
      const double error_m = bias[a] + 0.015 * scale * w + 0.003 * jitter;
      squared += error_m * error_m;
    }
    return std::sqrt(squared);
  }

  void add_take(std::uint64_t number, std::size_t p, const NightModel& model, Night& night) const {
    const auto instants = static_cast<std::uint64_t>(model.duration_s * kRate_hz);
    const double keep = std::exp(-1.0 / (kRate_hz * kDrift_s));
    for (std::size_t g = 0; g < kGroups; ++g) {
      const RandomStream random{seed_, Purpose::test, (number * 64 + p) * kGroups + g};
      const RandomStream again{seed_ + 1000, Purpose::test, (number * 64'000 + p) * kGroups + g};
      std::uint32_t draw = 0, draw_again = 0;
      Vector bias{};
      for (double& b : bias) b = 0.03 * random.normal(draw++);
      const double scale = std::exp(0.3 * random.normal(draw++));
      Drift old, fresh;
      old.step(random, draw, 0.0);
      fresh.step(again, draw_again, 0.0);
      std::array<double, kMethods> before_m{}, now_m{};
      for (std::uint64_t i = 0; i < instants; ++i) {
        old.step(random, draw, keep);
        fresh.step(again, draw_again, keep);
        const double jitter = random.normal(draw++);
        for (std::size_t m = 0; m < kMethods; ++m) {
          before_m[m] += length_of(bias, old, m, scale, jitter);
          now_m[m] += length_of(bias, model.same_recordings ? old : fresh, m, scale, jitter) *
                      (m == 0 ? 1.0 + model.worse : 1.0);
        }
      }
      for (std::size_t m = 0; m < kMethods; ++m) {
        const std::string& group = night.now.groups[g];
        TakeJointRow row{night.takes[p], night.takes[p], "walking", group, group, night.now.methods[m]};
        row.asked = row.answered = instants;
        row.mae_m = before_m[m] / static_cast<double>(instants);
        night.before.rows.push_back(row);
        row.mae_m = now_m[m] / static_cast<double>(instants);
        night.now.rows.push_back(row);
      }
    }
  }

  std::uint64_t seed_;
};

}  // namespace trilat
