// SPDX-License-Identifier: MIT
// One source, compiled once for each instruction set. Sums and products are written out and never fused,
// functions are polynomials of our own and nothing is summed across lanes: so every set and every width gives
// the same bits.
#include "datasets/synthetic/range_trials.h"

#include <numbers>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"

// SSE2 is there on every x86-64; these bring nothing beyond SSE4 and AVX-512 here.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "datasets/synthetic/range_trials.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

#include "datasets/synthetic/depth/random_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trilat {
namespace HWY_NAMESPACE {

struct Vector3 {
  Doubles x, y, z;
};

HWY_INLINE Doubles Number(double value) { return hn::Set(D(), value); }

// (0, 1) from two words, as RandomStream does: 53 bits and a half.
HWY_INLINE Doubles OpenUnit(Bits low, Bits high) {
  const U u;
  const Bits bits = hn::ShiftRight<11>(
      hn::Or(hn::ShiftLeft<32>(high), hn::And(low, hn::Set(u, std::uint64_t{0xFFFFFFFF}))));
  // Exact in two halves: 2^52 and 2^84 are added as bit patterns and taken away again.
  const Bits lower = hn::And(bits, hn::Set(u, std::uint64_t{0xFFFFFFFF}));
  const Bits upper = hn::ShiftRight<32>(bits);
  const Doubles lower_value =
      hn::BitCast(D(), hn::Or(lower, hn::Set(u, std::uint64_t{0x4330000000000000}))) - Number(0x1p52);
  const Doubles upper_value =
      hn::BitCast(D(), hn::Or(upper, hn::Set(u, std::uint64_t{0x4530000000000000}))) - Number(0x1p84);
  // The sum of the largest bits rounds up to 1.
  return hn::Min((upper_value + lower_value + Number(0.5)) * Number(0x1p-53), Number(1.0 - 0x1p-53));
}

// The numbers of a vector of trials.
class RandomStream {
 public:
  HWY_INLINE RandomStream(std::uint64_t seed, Bits trial) : seed_(seed), trial_(trial) {}

  HWY_INLINE Doubles uniform(std::uint32_t index) const {
    Doubles first, second;
    pair(index, first, second);
    return first;
  }

  HWY_INLINE void pair(std::uint32_t index, Doubles& first, Doubles& second) const {
    const U u;
    Bits c0 = hn::Set(u, std::uint64_t{index});
    Bits c1 = trial_;
    Bits c2 = hn::ShiftRight<32>(trial_);
    Bits c3 = hn::Set(u, static_cast<std::uint64_t>(Purpose::range_trial));
    Philox(seed_, c0, c1, c2, c3);
    first = OpenUnit(c0, c1);
    second = OpenUnit(c2, c3);
  }

 private:
  std::uint64_t seed_;
  Bits trial_;
};

// Horner's rule, the highest power first.
template <std::size_t n>
HWY_INLINE Doubles Polynomial(Doubles x, const double (&coefficient)[n]) {
  Doubles sum = Number(coefficient[0]);
  for (std::size_t i = 1; i < n; ++i) sum = sum * x + Number(coefficient[i]);
  return sum;
}

// Sine and cosine of `turn` times 2 pi, turn in (0, 1): Taylor series within an eighth of a turn of the
// nearest quarter, exact to rounding.
HWY_INLINE void SineCosine(Doubles turn, Doubles& sine, Doubles& cosine) {
  static constexpr double kSine[] = {
      -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0,
      -1.0 / 5040.0,          1.0 / 120.0,        -1.0 / 6.0,        1.0};
  static constexpr double kCosine[] = {1.0 / 20922789888000.0,
                                       -1.0 / 87178291200.0,
                                       1.0 / 479001600.0,
                                       -1.0 / 3628800.0,
                                       1.0 / 40320.0,
                                       -1.0 / 720.0,
                                       1.0 / 24.0,
                                       -1.0 / 2.0,
                                       1.0};
  const Doubles quarters = turn * Number(4.0);
  const Doubles nearest = hn::Round(quarters);
  const Doubles angle = (quarters - nearest) * Number(std::numbers::pi / 2.0);
  const Doubles square = angle * angle;
  const Doubles s = angle * Polynomial(square, kSine);
  const Doubles c = Polynomial(square, kCosine);
  const auto odd = hn::Or(nearest == Number(1.0), nearest == Number(3.0));
  const Doubles first = hn::IfThenElse(odd, c, s);
  const Doubles second = hn::IfThenElse(odd, s, c);
  const auto lower_half = hn::And(nearest > Number(1.5), nearest < Number(3.5));
  const auto left_half = hn::And(nearest > Number(0.5), nearest < Number(2.5));
  sine = hn::IfThenElse(lower_half, hn::Neg(first), first);
  cosine = hn::IfThenElse(left_half, hn::Neg(second), second);
}

// Natural logarithm of numbers in (0, 1]: 2 atanh((m - 1) / (m + 1)) of the mantissa m in [2/3, 4/3).
HWY_INLINE Doubles Logarithm(Doubles x) {
  static constexpr double kAtanh[] = {1.0 / 21.0, 1.0 / 19.0, 1.0 / 17.0, 1.0 / 15.0, 1.0 / 13.0, 1.0 / 11.0,
                                      1.0 / 9.0,  1.0 / 7.0,  1.0 / 5.0,  1.0 / 3.0,  1.0};
  const U u;
  const Bits bits = hn::BitCast(u, x);
  const Bits offset = hn::Sub(bits, hn::Set(u, std::uint64_t{0x3FE5555555555555}));  // of 2/3
  const Bits negated_exponent =
      hn::ShiftRight<52>(hn::Sub(hn::Set(u, std::uint64_t{0x000FFFFFFFFFFFFF}), offset));
  const Doubles m = hn::BitCast(D(), hn::Add(bits, hn::ShiftLeft<52>(negated_exponent)));
  const Doubles exponent =
      hn::BitCast(D(), hn::Or(negated_exponent, hn::Set(u, std::uint64_t{0x4330000000000000}))) -
      Number(0x1p52);
  const Doubles s = (m - Number(1.0)) / (m + Number(1.0));
  const Doubles series = s * Polynomial(s * s, kAtanh);
  return series + series - exponent * Number(std::numbers::ln2);
}

// RandomStream::normal, by the functions above.
HWY_INLINE Doubles Normal(const RandomStream& draws, std::uint32_t index) {
  Doubles first, second, sine, cosine;
  draws.pair(index, first, second);
  SineCosine(second, sine, cosine);
  return hn::Sqrt(Number(-2.0) * Logarithm(first)) * cosine;
}

// A vector of this length, its direction uniform on the sphere.
HWY_INLINE Vector3 InAnyDirection(const RandomStream& draws, std::uint32_t index, Doubles length) {
  const Doubles height = Number(2.0) * draws.uniform(index) - Number(1.0);
  const Doubles radius = length * hn::Sqrt(Number(1.0) - height * height);
  Doubles sine, cosine;
  SineCosine(draws.uniform(index + 1), sine, cosine);
  return {radius * cosine, length * height, radius * sine};
}

HWY_INLINE Doubles Between(double low, double high, Doubles share) {
  return Number(low) + Number(high - low) * share;
}

HWY_INLINE Vector3 TrueJoint(const RangeTrialModel& model, const RandomStream& draws) {
  if (model.joint == TrialJoint::centre) return {Number(0.0), Number(1.0), Number(0.0)};
  return {Between(-0.6, 0.6, draws.uniform(trial_index::kJoint)),
          Between(0.1, 1.9, draws.uniform(trial_index::kJoint + 1)),
          Between(-0.6, 0.6, draws.uniform(trial_index::kJoint + 2))};
}

HWY_INLINE Vector3 Displacement(const RangeTrialModel& model, const RandomStream& draws,
                                std::uint32_t index) {
  return InAnyDirection(draws, index + 1, Between(model.low_m, model.high_m, draws.uniform(index)));
}

// One uniform gives the sign and, within its half, the magnitude.
HWY_INLINE Doubles SignedError(const RangeTrialModel& model, Doubles uniform) {
  const Doubles twice = uniform + uniform;
  const auto positive = uniform > Number(0.5);
  const Doubles magnitude =
      Between(model.low_m, model.high_m, hn::IfThenElse(positive, twice - Number(1.0), twice));
  return hn::IfThenElse(positive, magnitude, hn::Neg(magnitude));
}

HWY_INLINE Doubles RangeError(const RangeTrialModel& model, const RandomStream& draws, std::uint32_t index) {
  if (model.error == TrialError::range_signed) return SignedError(model, draws.uniform(index));
  const double mean_m = 0.5 * (model.low_m + model.high_m);
  return Number(mean_m * 1.2533141373155003) * Normal(draws, index);  // sqrt(pi / 2)
}

HWY_INLINE Doubles DistanceTo(const std::array<double, 3>& sensor_m, const Vector3& x_m) {
  const Doubles x = x_m.x - Number(sensor_m[0]);
  const Doubles y = x_m.y - Number(sensor_m[1]);
  const Doubles z = x_m.z - Number(sensor_m[2]);
  return hn::Sqrt(x * x + y * y + z * z);
}

HWY_INLINE void StoreVector3(const Vector3& v, double* rows, std::size_t stride) {
  hn::StoreU(v.x, D(), rows);
  hn::StoreU(v.y, D(), rows + stride);
  hn::StoreU(v.z, D(), rows + 2 * stride);
}

HWY_INLINE void MakeOneVector(const RangeTrialModel& model, Bits trial, const RangeTrialRows& rows,
                              std::size_t column) {
  const RandomStream draws(model.seed, trial);
  const bool displaced = model.error == TrialError::displacement;
  const Vector3 truth = TrueJoint(model, draws);
  StoreVector3(truth, rows.truth_m + column, rows.stride);
  Vector3 sum{Number(0.0), Number(0.0), Number(0.0)};
  for (int i = 0; i < model.sensors; ++i) {
    const auto row = static_cast<std::size_t>(i);
    const std::uint32_t index =
        trial_index::kSensor + trial_index::kPerSensor * static_cast<std::uint32_t>(i);
    Vector3 seen = truth;
    if (displaced || rows.mean_m) {
      const Vector3 by = Displacement(model, draws, index);
      sum = {sum.x + by.x, sum.y + by.y, sum.z + by.z};
      if (displaced) seen = {truth.x + by.x, truth.y + by.y, truth.z + by.z};
    }
    Doubles range = DistanceTo(model.sensor_m[row], seen);
    if (!displaced)
      range = hn::Max(range + RangeError(model, draws, index + trial_index::kRangeError), Number(0.0));
    hn::StoreU(range, D(), rows.range_m + row * rows.stride + column);
  }
  if (rows.mean_m) {
    const Doubles share = Number(1.0 / model.sensors);
    StoreVector3({truth.x + sum.x * share, truth.y + sum.y * share, truth.z + sum.z * share},
                 rows.mean_m + column, rows.stride);
  }
}

void MakeTrials(const RangeTrialModel& model, std::uint64_t first_trial, std::size_t count,
                const RangeTrialRows& rows) {
  const U u;
  for (std::size_t column = 0; column < count; column += hn::Lanes(u))
    MakeOneVector(model, hn::Iota(u, first_trial + column), rows, column);
}

}  // namespace HWY_NAMESPACE
}  // namespace trilat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trilat {
HWY_EXPORT(MakeTrials);

void make_range_trials(const RangeTrialModel& model, std::uint64_t first_trial, std::size_t count,
                       const RangeTrialRows& rows) {
  TRILAT_CHECK(model.sensors >= 1 && model.sensors <= RangeTrialModel::kMaxSensors, "a rig fits the model");
  TRILAT_CHECK(
      rows.truth_m && rows.range_m && rows.stride >= (count + kTrialBlock - 1) / kTrialBlock * kTrialBlock,
      "trials have rows to go to");
  HWY_DYNAMIC_DISPATCH(MakeTrials)(model, first_trial, count, rows);
}

}  // namespace trilat
#endif  // HWY_ONCE
