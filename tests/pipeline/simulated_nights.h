// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "datasets/base/philox.h"
#include "pipeline/gate/paired_cells.h"

namespace trilat {

// How two nights differ when nothing is wrong, and what goes wrong when something does. All of it is
// simulated: persons with errors of their own (3 cm an axis, fixed) and an own unrest, errors that wander
// with 1 s (1.5 cm an axis) and jitter (3 mm), shared by the methods but for a quarter of their own.
struct NightModel {
  std::size_t participants = 16;
  double duration_s = 35.0;
  // How much of what wanders is drawn anew: 0.1 for code that takes other decisions in the same recordings, 1
  // for other recordings of the same persons.
  double redrawn = 0.1;
  bool same_inputs = true;
  double worse = 0.0;           // relative growth of the errors of method 0 in group 0
  double lost_share = 0.0;      // of the answers of method 0 in group 0
  double flipped_share = 1e-3;  // of all answers, either way
  double clamped_share = 0.02;  // of all answers
  double more_clamped = 0.0;    // of those of method 0 in group 0, tonight
};

class SimulatedNights {
 public:
  static constexpr std::size_t kMethods = 5, kGroups = 4, kAxes = 3;
  static constexpr double kRate_hz = 10.0, kWander_s = 1.0;

  explicit SimulatedNights(std::uint64_t seed) : seed_(seed) {}

  // `number`: which recordings, baseline and run of the code on them.
  PairedStudy night(std::uint64_t number, const NightModel& model) const {
    PairedStudy study;
    study.study = "simulated";
    study.axes = {1, 1, kGroups, kMethods, {0, 1, 2, 3}};
    study.alignments = {"none"};
    study.groups = {"head", "shoulder", "elbow", "wrist"};
    study.methods = {"nonlinear", "linear", "mean", "rts", "window"};
    for (std::size_t p = 0; p < model.participants; ++p)
      study.takes.push_back(take(number, p, model, study.axes));
    return study;
  }

 private:
  using Vector = std::array<double, kAxes>;

  // One joint's wander by all methods: the shared part and each method's own.
  struct Wander {
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

  static double length_of(const Vector& bias, const Wander& wander, std::size_t method, double scale,
                          double jitter) {
    constexpr double kOwn = 0.5;  // a quarter of the variance
    double squared = 0.0;
    for (std::size_t a = 0; a < kAxes; ++a) {
      const double w =
          std::sqrt(1.0 - kOwn * kOwn) * wander.value[kMethods][a] + kOwn * wander.value[method][a];
      const double error_m = bias[a] + 0.015 * scale * w + 0.003 * jitter;
      squared += error_m * error_m;
    }
    return std::sqrt(squared);
  }

  static PairedAnswer answer(bool none, double error_m, bool clamped) {
    if (none) return {{kNoNumber, kNoNumber}, SolveStatus::iteration_limit};
    return {{error_m, kNoNumber}, clamped ? SolveStatus::clamped : SolveStatus::converged};
  }

  static Wander mixed(const Wander& old, const Wander& fresh, double redrawn) {
    Wander result;
    for (std::size_t m = 0; m <= kMethods; ++m)
      for (std::size_t a = 0; a < kAxes; ++a)
        result.value[m][a] =
            std::sqrt(1.0 - redrawn * redrawn) * old.value[m][a] + redrawn * fresh.value[m][a];
    return result;
  }

  PairedTake take(std::uint64_t number, std::size_t p, const NightModel& model,
                  const PairedAxes& axes) const {
    PairedTake result{"p" + std::to_string(p), "p" + std::to_string(p), "walking", {}, {}};
    const auto instants = static_cast<std::uint64_t>(model.duration_s * kRate_hz);
    PairedTakeSums sums(axes, (instants + 9) / 10);
    const double keep = std::exp(-1.0 / (kRate_hz * kWander_s));
    for (std::size_t g = 0; g < kGroups; ++g) {
      const RandomStream random{seed_, Purpose::test, (number * 64 + p) * kGroups + g};
      const RandomStream again{seed_ + 1000, Purpose::test, (number * 64'000 + p) * kGroups + g};
      std::uint32_t draw = 0, draw_again = 0;
      Vector bias{};
      for (double& b : bias) b = 0.03 * random.normal(draw++);
      const double scale = std::exp(0.3 * random.normal(draw++));
      Wander old, fresh;
      old.step(random, draw, 0.0);
      fresh.step(again, draw_again, 0.0);
      for (std::uint64_t i = 0; i < instants; ++i) {
        old.step(random, draw, keep);
        fresh.step(again, draw_again, keep);
        const Wander now = mixed(old, fresh, model.redrawn);
        const double jitter = random.normal(draw++);
        for (std::size_t m = 0; m < kMethods; ++m) {
          const bool bad = m == 0 && g == 0;
          const double before_m = length_of(bias, old, m, scale, jitter);
          const double now_m = length_of(bias, now, m, scale, jitter) * (bad ? 1.0 + model.worse : 1.0);
          const bool no_before = random.uniform(draw++) < model.flipped_share / 2.0;
          const bool no_now =
              again.uniform(draw_again++) < model.flipped_share / 2.0 + (bad ? model.lost_share : 0.0);
          const double v = random.uniform(draw++);
          const bool clamped_before = v < model.clamped_share;
          const bool flips = again.uniform(draw_again++) < model.flipped_share;
          const bool clamped_now = (v < model.clamped_share + (bad ? model.more_clamped : 0.0)) != flips;
          sums.add(i / 10, g, m, 1, answer(no_before, before_m, clamped_before),
                   answer(no_now, now_m, clamped_now));
        }
      }
    }
    sums.finish(result);
    return result;
  }

  std::uint64_t seed_;
};

}  // namespace trilat
