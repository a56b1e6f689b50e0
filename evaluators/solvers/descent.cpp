// SPDX-License-Identifier: MIT
// One source, compiled once for each instruction set. Additions and products are written out and never fused,
// each lane goes its own way and nothing is summed across lanes: so every set and every width gives the same
// bits.
#include "evaluators/solvers/descent.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <new>
#include <type_traits>

#include "datasets/base/error.h"
#include "evaluators/solvers/range_equations.h"

// SSE2 is there on every x86-64; these bring nothing beyond SSE4 and AVX-512 here.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "evaluators/solvers/descent.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

#ifndef TRILAT_DESCENT_VIEW
#define TRILAT_DESCENT_VIEW
namespace trilat {
// Where the kernel reads and writes, whoever owns it.
struct LaneView {
  int sensors;
  std::size_t count;
  bool one_rig;
  const double *sensor_m, *range_m, *weight;
  std::size_t sensor_stride, stride;
  double *position_m, *cost_m2, *iterations;
  SolveStatus* status;
};
}  // namespace trilat
#endif

HWY_BEFORE_NAMESPACE();
namespace trilat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr double kFirstDamping = 1e-4;
constexpr double kFair = 0.25, kGood = 0.75;  // share of the predicted gain
constexpr double kExact = 0.1;                // farthest from the predicted gain
constexpr double kFastDecay = 0.05;
// Damping below which newton uses the whole Hessian: Gauss-Newton has then predicted F well. Farther off the
// Hessian is indefinite, and its steps may leave for another minimum.
constexpr double kTrusted = 2e-5;
constexpr double kRounding = 4e-15;  // of the grain: a smaller change of F is rounding

// Which descent the loop is compiled for.
template <Gradient gradient_, Damping damping_, Curvature curvature_>
struct Variant {
  static constexpr Gradient gradient = gradient_;
  static constexpr Damping damping = damping_;
  static constexpr Curvature curvature = curvature_;
};

template <class D>
struct Vector3 {
  hn::Vec<D> x, y, z;
};

template <class D>
struct Symmetric {
  hn::Vec<D> xx, xy, xz, yy, yz, zz;
};

template <class D>
HWY_INLINE Symmetric<D> AdjugateOf(const Symmetric<D>& m) {
  return {m.yy * m.zz - m.yz * m.yz, m.xz * m.yz - m.xy * m.zz, m.xy * m.yz - m.xz * m.yy,
          m.xx * m.zz - m.xz * m.xz, m.xy * m.xz - m.xx * m.yz, m.xx * m.yy - m.xy * m.xy};
}

template <class D>
HWY_INLINE hn::Vec<D> DeterminantOf(const Symmetric<D>& m, const Symmetric<D>& adjugate) {
  return m.xx * adjugate.xx + m.xy * adjugate.xy + m.xz * adjugate.xz;
}

template <class D>
HWY_INLINE hn::Vec<D> TraceOf(const Symmetric<D>& m) {
  return m.xx + m.yy + m.zz;
}

template <class D>
HWY_INLINE Vector3<D> Times(const Symmetric<D>& m, const Vector3<D>& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}

template <class D>
HWY_INLINE hn::Vec<D> Dot(const Vector3<D>& a, const Vector3<D>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class D>
HWY_INLINE hn::Vec<D> Select(hn::Mask<D> mask, hn::Vec<D> yes, hn::Vec<D> no) {
  return hn::IfThenElse(mask, yes, no);
}

template <class D>
HWY_INLINE void SelectInto(hn::Mask<D> mask, const Symmetric<D>& from, Symmetric<D>& to) {
  to = {Select<D>(mask, from.xx, to.xx), Select<D>(mask, from.xy, to.xy), Select<D>(mask, from.xz, to.xz),
        Select<D>(mask, from.yy, to.yy), Select<D>(mask, from.yz, to.yz), Select<D>(mask, from.zz, to.zz)};
}

template <class D>
HWY_INLINE void SelectInto(hn::Mask<D> mask, const Vector3<D>& from, Vector3<D>& to) {
  to = {Select<D>(mask, from.x, to.x), Select<D>(mask, from.y, to.y), Select<D>(mask, from.z, to.z)};
}

// F and its linearisation, as RangeEquations, in each lane.
template <class D>
struct LaneEquations {
  Symmetric<D> matrix;  // what the step inverts
  Vector3<D> gradient;  // J^T W f
  hn::Vec<D> cost;      // sum of w f^2
  hn::Vec<D> grain;     // sum of w |f| d: F's rounding error is some 1e-16 of it
};

// What a lane has come to; lanes that are done no longer change.
template <class D>
struct Ends {
  hn::Mask<D> active;
  hn::Vec<D> status;
  hn::Vec<D> iterations;

  HWY_INLINE void end(D d, hn::Mask<D> which, SolveStatus how, int iteration) {
    status = hn::IfThenElse(which, hn::Set(d, static_cast<double>(how)), status);
    iterations = hn::IfThenElse(which, hn::Set(d, static_cast<double>(iteration)), iterations);
    active = hn::AndNot(which, active);
  }
};

template <class D>
HWY_INLINE Ends<D> NotEnded(D d, hn::Mask<D> active, int max_iterations) {
  return {active, hn::Set(d, static_cast<double>(SolveStatus::iteration_limit)),
          hn::Set(d, static_cast<double>(max_iterations))};
}

// `known_sensors` is their number when the loop over them is written out, else 0.
template <class D, int known_sensors, bool one_rig>
struct Problems {
  using Tag = D;
  D d;
  const LaneView& view;
  std::size_t lane;

  HWY_INLINE int sensors() const { return known_sensors > 0 ? known_sensors : view.sensors; }

  HWY_INLINE hn::Vec<D> sensor(int row) const {
    const double* from = view.sensor_m + static_cast<std::size_t>(row) * view.sensor_stride;
    return one_rig ? hn::Set(d, *from) : hn::Load(d, from + lane);
  }
  HWY_INLINE hn::Vec<D> range(int i) const {
    return hn::Load(d, view.range_m + static_cast<std::size_t>(i) * view.stride + lane);
  }
  HWY_INLINE hn::Vec<D> weight(int i) const {
    return hn::Load(d, view.weight + static_cast<std::size_t>(i) * view.stride + lane);
  }
  HWY_INLINE hn::Mask<D> lanes() const { return hn::FirstN(d, std::min(hn::Lanes(d), view.count - lane)); }
  HWY_INLINE Vector3<D> start() const {
    const double* x = view.position_m + lane;
    return {hn::Load(d, x), hn::Load(d, x + view.stride), hn::Load(d, x + 2 * view.stride)};
  }
  HWY_INLINE void store(const Vector3<D>& end, hn::Vec<D> cost, const Ends<D>& ends) const {
    double* x = view.position_m + lane;
    hn::Store(end.x, d, x);
    hn::Store(end.y, d, x + view.stride);
    hn::Store(end.z, d, x + 2 * view.stride);
    hn::Store(cost, d, view.cost_m2 + lane);
    hn::Store(ends.iterations, d, view.iterations + lane);
    alignas(64) double status[kLaneBlock];
    hn::Store(ends.status, d, status);
    for (std::size_t i = 0; i < hn::Lanes(d) && lane + i < view.count; ++i)
      view.status[lane + i] = static_cast<SolveStatus>(static_cast<int>(status[i]));
  }
};

// What one sensor adds. The sums are made in a second loop: one loop for all would need more registers than
// there are.
template <class D>
struct SensorTerms {
  hn::Vec<D> x, y, z;  // from the sensor
  hn::Vec<D> q;        // the matrix gets q v v^T
  hn::Vec<D> slope;    // the gradient gets slope v
};

// `bending` is 1 where the Hessian is trusted, 0 where Gauss-Newton's part of it has to do.
template <class Kind, class P, class D = typename P::Tag>
HWY_INLINE LaneEquations<D> Linearise(const P& problems, const Vector3<D>& at, const DescentOptions& options,
                                      hn::Vec<D> bending) {
  const D d = problems.d;
  const auto zero = hn::Zero(d);
  const auto unit = hn::Set(d, options.printed_unit_m);
  const auto least = hn::Set(d, kOnSensor_m * kOnSensor_m);
  LaneEquations<D> sum{{zero, zero, zero, zero, zero, zero}, {zero, zero, zero}, zero, zero};
  SensorTerms<D> terms[kMaxSensors];
  auto bend = zero;  // sum of w (1 - r/d)
  for (int i = 0; i < problems.sensors(); ++i) {
    const auto x = at.x - problems.sensor(3 * i);
    const auto y = at.y - problems.sensor(3 * i + 1);
    const auto z = at.z - problems.sensor(3 * i + 2);
    const auto square = x * x + y * y + z * z;
    const auto distance = hn::Sqrt(square);
    const auto f = distance - problems.range(i);
    const auto w = problems.weight(i);
    sum.cost = sum.cost + w * f * f;
    sum.grain = sum.grain + w * hn::Abs(f) * distance;
    // The quotient does not wait for the root, which shortens the chain of each iteration.
    const auto inverse = hn::Set(d, 1.0) / hn::Max(square, least);
    auto q = w * inverse;
    const auto right = Kind::gradient == Gradient::printed ? unit * f : distance * f;
    const auto slope = q * right;
    if constexpr (Kind::curvature == Curvature::newton) {
      const auto curl = bending * slope;  // w (1 - r/d)
      bend = bend + curl;
      q = q - curl * inverse;
    }
    terms[i] = {x, y, z, q, slope};
  }
  for (int i = 0; i < problems.sensors(); ++i) {
    const auto& [x, y, z, q, slope] = terms[i];
    sum.gradient.x = sum.gradient.x + slope * x;
    sum.gradient.y = sum.gradient.y + slope * y;
    sum.gradient.z = sum.gradient.z + slope * z;
    const auto qx = q * x;
    const auto qy = q * y;
    sum.matrix.xx = sum.matrix.xx + qx * x;
    sum.matrix.xy = sum.matrix.xy + qx * y;
    sum.matrix.xz = sum.matrix.xz + qx * z;
    sum.matrix.yy = sum.matrix.yy + qy * y;
    sum.matrix.yz = sum.matrix.yz + qy * z;
    sum.matrix.zz = sum.matrix.zz + q * z * z;
  }
  if constexpr (Kind::curvature == Curvature::newton) {
    sum.matrix.xx = sum.matrix.xx + bend;
    sum.matrix.yy = sum.matrix.yy + bend;
    sum.matrix.zz = sum.matrix.zz + bend;
  }
  return sum;
}

template <class D>
HWY_INLINE hn::Mask<D> ObjectiveRuleHolds(D d, const DescentOptions& options, hn::Vec<D> change) {
  const auto threshold = hn::Set(d, options.threshold_m2);
  if (options.stop == StopRule::printed) return change < threshold;
  if (options.stop == StopRule::objective) return hn::Abs(change) < threshold;
  return hn::MaskFromVec(hn::Zero(d));
}

template <class D>
HWY_INLINE hn::Mask<D> StepRuleHolds(D d, const DescentOptions& options, const Vector3<D>& step) {
  if (options.stop != StopRule::step) return hn::MaskFromVec(hn::Zero(d));
  return Dot<D>(step, step) < hn::Set(d, options.step_tolerance_m * options.step_tolerance_m);
}

template <class D>
HWY_INLINE hn::Mask<D> RankDeficient(D d, const Symmetric<D>& normal, const Symmetric<D>& adjugate,
                                     hn::Vec<D> determinant) {
  const auto ratio = hn::Set(d, kRankRatio);
  const auto trace = TraceOf<D>(normal);
  const auto pairs = TraceOf<D>(adjugate);
  return hn::Not(hn::And(pairs > ratio * trace * trace, determinant > ratio * trace * pairs));
}

// The step that solves matrix * step = -gradient, by the adjugate inverse of eq. 18.
template <class D>
HWY_INLINE Vector3<D> StepOf(D d, const Symmetric<D>& adjugate, hn::Vec<D> determinant,
                             const Vector3<D>& gradient) {
  const Vector3<D> direction = Times<D>(adjugate, gradient);
  const auto scale = hn::Set(d, -1.0) / determinant;
  return {direction.x * scale, direction.y * scale, direction.z * scale};
}

// R_{k+1} = R_k - (J^T J)^-1 J^T f, eq. 14.
template <class Kind, class P>
class UndampedDescent {
 public:
  using D = typename P::Tag;

  HWY_INLINE UndampedDescent(const P& problems, const DescentOptions& options)
      : now_(problems.start()),
        equations_(Linearise<Kind>(problems, now_, options, hn::Zero(problems.d))),
        cost_(equations_.cost),
        ends_(NotEnded(problems.d, problems.lanes(), options.max_iterations)) {}

  HWY_INLINE bool goes_on(D d) const { return !hn::AllFalse(d, ends_.active); }

  HWY_INLINE void step(const P& problems, const DescentOptions& options, int k) {
    const D d = problems.d;
    const Symmetric<D> adjugate = AdjugateOf<D>(equations_.matrix);
    const auto determinant = DeterminantOf<D>(equations_.matrix, adjugate);
    const auto deficient = hn::And(ends_.active, RankDeficient(d, equations_.matrix, adjugate, determinant));
    if (HWY_UNLIKELY(!hn::AllFalse(d, deficient))) ends_.end(d, deficient, SolveStatus::rank_deficient, k);
    const Vector3<D> step = StepOf(d, adjugate, determinant, equations_.gradient);
    SelectInto<D>(ends_.active, {now_.x + step.x, now_.y + step.y, now_.z + step.z}, now_);
    equations_ = Linearise<Kind>(problems, now_, options, hn::Zero(problems.d));
    const auto change = equations_.cost - cost_;
    cost_ = Select<D>(ends_.active, equations_.cost, cost_);
    const auto diverged = hn::AndNot(hn::IsFinite(cost_), ends_.active);
    if (HWY_UNLIKELY(!hn::AllFalse(d, diverged))) ends_.end(d, diverged, SolveStatus::diverged, k + 1);
    const auto stops = hn::Or(ObjectiveRuleHolds(d, options, change), StepRuleHolds(d, options, step));
    ends_.end(d, hn::And(ends_.active, stops), SolveStatus::converged, k + 1);
  }

  HWY_INLINE void finish(const P& problems) const { problems.store(now_, cost_, ends_); }

 private:
  Vector3<D> now_;
  LaneEquations<D> equations_;
  hn::Vec<D> cost_;
  Ends<D> ends_;
};

// Damping as a share of the trace of J^T W J. It falls fast while the linearisation predicts the cost well,
// stays while it just does, and grows faster and faster while steps are taken back.
template <class D>
struct LaneDamping {
  hn::Vec<D> share, growth;

  // `factor` is for the lanes whose step was taken.
  HWY_INLINE void adapt(D d, hn::Mask<D> taken, hn::Vec<D> factor) {
    const auto two = hn::Set(d, 2.0);
    share = share * Select<D>(taken, factor, growth);
    growth = Select<D>(taken, two, growth * two);
  }
};

// How the damping changes after a step that lowered F by `gained` of the `predicted`.
template <class D>
HWY_INLINE hn::Vec<D> DampingFactor(D d, hn::Vec<D> gained, hn::Vec<D> predicted) {
  const auto less = Select<D>(gained > hn::Set(d, kFair) * predicted, hn::Set(d, 1.0), hn::Set(d, 2.0));
  const auto good = Select<D>(gained > hn::Set(d, kGood) * predicted, hn::Set(d, 1.0 / 3.0), less);
  const auto exact = hn::Abs(gained - predicted) < hn::Set(d, kExact) * predicted;
  return Select<D>(exact, hn::Set(d, kFastDecay), good);
}

// The leading minors of a matrix that is positive definite.
template <class D>
HWY_INLINE hn::Mask<D> PositiveDefinite(D d, const Symmetric<D>& m, const Symmetric<D>& adjugate,
                                        hn::Vec<D> determinant) {
  const auto zero = hn::Zero(d);
  return hn::And(hn::And(m.xx > zero, adjugate.zz > zero), determinant > zero);
}

// (J^T W J + lambda I) step = -J^T W f, or with the Hessian in its place. A step that raises F, or a matrix
// that is not positive definite, is taken back and tried again with more damping: F never rises by more than
// rounding. The last step, below the tolerance, is taken unseen.
template <class Kind, class P>
class DampedDescent {
 public:
  using D = typename P::Tag;

  HWY_INLINE DampedDescent(const P& problems, const DescentOptions& options)
      : now_(problems.start()),
        ends_(NotEnded(problems.d, problems.lanes(), options.max_iterations)),
        damping_{hn::Set(problems.d, kFirstDamping), hn::Set(problems.d, 2.0)},
        bending_(hn::Zero(problems.d)),
        weights_(hn::Zero(problems.d)) {
    const D d = problems.d;
    equations_ = Linearise<Kind>(problems, now_, options, bending_);
    cost_ = equations_.cost;
    ends_.end(d, hn::AndNot(hn::IsFinite(cost_), ends_.active), SolveStatus::diverged, 0);
    for (int i = 0; i < problems.sensors(); ++i) weights_ = weights_ + problems.weight(i);
  }

  HWY_INLINE bool goes_on(D d) const { return !hn::AllFalse(d, ends_.active); }

  HWY_INLINE void step(const P& problems, const DescentOptions& options, int k) {
    const D d = problems.d;
    const auto lambda = damping_.share * weights_;
    Symmetric<D> damped = equations_.matrix;
    damped.xx = damped.xx + lambda;
    damped.yy = damped.yy + lambda;
    damped.zz = damped.zz + lambda;
    const Symmetric<D> adjugate = AdjugateOf<D>(damped);
    const auto determinant = DeterminantOf<D>(damped, adjugate);
    const Vector3<D> step = StepOf(d, adjugate, determinant, equations_.gradient);
    auto sound = ends_.active;
    if constexpr (Kind::curvature == Curvature::newton)
      sound = hn::And(sound, PositiveDefinite(d, damped, adjugate, determinant));
    const Vector3<D> there{now_.x + step.x, now_.y + step.y, now_.z + step.z};
    const auto small = hn::And(sound, StepRuleHolds(d, options, step));
    SelectInto<D>(small, there, now_);
    ends_.end(d, small, SolveStatus::converged, k + 1);
    judge(problems, options, there, step, lambda, hn::AndNot(small, sound), k);
  }

  HWY_INLINE void finish(const P& problems) const { problems.store(now_, cost_, ends_); }

 private:
  // Takes the step in those of the `sound` lanes where it helps.
  HWY_INLINE void judge(const P& problems, const DescentOptions& options, const Vector3<D>& there,
                        const Vector3<D>& step, hn::Vec<D> lambda, hn::Mask<D> sound, int k) {
    const D d = problems.d;
    const LaneEquations<D> trial = Linearise<Kind>(problems, there, options, bending_);
    auto gained = cost_ - trial.cost;
    auto predicted = lambda * Dot<D>(step, step) - Dot<D>(step, equations_.gradient);
    const auto stops = ObjectiveRuleHolds(d, options, hn::Neg(gained));
    // Near the minimum F says nothing any more, and the gradient takes its place.
    const auto flat = hn::And(sound, hn::Abs(gained) <= hn::Set(d, kRounding) * equations_.grain);
    if (HWY_UNLIKELY(!hn::AllFalse(d, flat))) {
      const auto before = Dot<D>(equations_.gradient, equations_.gradient);
      gained = Select<D>(flat, before - Dot<D>(trial.gradient, trial.gradient), gained);
      predicted = Select<D>(flat, before, predicted);
    }
    const auto taken = hn::And(sound, gained > hn::Zero(d));
    damping_.adapt(d, taken, DampingFactor(d, gained, predicted));
    if constexpr (Kind::curvature == Curvature::newton)
      bending_ = hn::IfThenElseZero(damping_.share < hn::Set(d, kTrusted), hn::Set(d, 1.0));
    SelectInto<D>(taken, there, now_);
    cost_ = Select<D>(taken, trial.cost, cost_);
    SelectInto<D>(taken, trial.matrix, equations_.matrix);
    SelectInto<D>(taken, trial.gradient, equations_.gradient);
    equations_.grain = Select<D>(taken, trial.grain, equations_.grain);
    // Also where the step is not taken: at the minimum itself none is.
    ends_.end(d, hn::And(sound, stops), SolveStatus::converged, k + 1);
  }

  Vector3<D> now_;
  LaneEquations<D> equations_;
  hn::Vec<D> cost_;
  Ends<D> ends_;
  LaneDamping<D> damping_;
  hn::Vec<D> bending_;
  hn::Vec<D> weights_;
};

template <class Kind, int known_sensors, bool one_rig, class D>
HWY_NOINLINE void DescendLanes(D d, const LaneView& view, const DescentOptions& options) {
  using P = Problems<D, known_sensors, one_rig>;
  using Descent =
      std::conditional_t<Kind::damping == Damping::lm, DampedDescent<Kind, P>, UndampedDescent<Kind, P>>;
  for (std::size_t lane = 0; lane < view.count; lane += hn::Lanes(d)) {
    const P problems{d, view, lane};
    Descent descent(problems, options);
    for (int k = 0; k < options.max_iterations && descent.goes_on(d); ++k) descent.step(problems, options, k);
    descent.finish(problems);
  }
}

template <class Kind, class D>
HWY_INLINE void DescendKind(D d, const LaneView& view, const DescentOptions& options) {
  if (view.sensors == 4)
    return view.one_rig ? DescendLanes<Kind, 4, true>(d, view, options)
                        : DescendLanes<Kind, 4, false>(d, view, options);
  return view.one_rig ? DescendLanes<Kind, 0, true>(d, view, options)
                      : DescendLanes<Kind, 0, false>(d, view, options);
}

template <class D>
HWY_INLINE void DescendWith(D d, const LaneView& view, const DescentOptions& options) {
  using enum Gradient;
  using enum Curvature;
  if (options.gradient == printed)
    return DescendKind<Variant<printed, Damping::none, gauss_newton>>(d, view, options);
  if (options.damping == Damping::none)
    return DescendKind<Variant<corrected, Damping::none, gauss_newton>>(d, view, options);
  if (options.curvature == newton)
    return DescendKind<Variant<corrected, Damping::lm, newton>>(d, view, options);
  DescendKind<Variant<corrected, Damping::lm, gauss_newton>>(d, view, options);
}

void DescendMany(const LaneView& view, const DescentOptions& options) {
  DescendWith(hn::ScalableTag<double>(), view, options);
}

void DescendPair(const LaneView& view, const DescentOptions& options) {
  DescendWith(hn::CappedTag<double, kPairLanes>(), view, options);
}

}  // namespace HWY_NAMESPACE
}  // namespace trilat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trilat {
HWY_EXPORT(DescendMany);
HWY_EXPORT(DescendPair);

namespace {

void check(int sensors, const DescentOptions& options) {
  TRILAT_CHECK(sensors >= 1 && sensors <= kMaxSensors, "a batch holds its sensors");
  TRILAT_CHECK(contradiction_in(options).empty(), "the settings of a descent fit together");
}

}  // namespace

std::string contradiction_in(const DescentOptions& options) {
  if (options.gradient == Gradient::printed) {
    if (options.damping == Damping::lm)
      return "lm needs the corrected gradient: the printed one is not a gradient of the cost";
    if (options.curvature == Curvature::newton) return "newton needs the corrected gradient";
  }
  if (options.damping == Damping::none && options.curvature == Curvature::newton)
    return "newton needs damping lm: away from the minimum the Hessian may point uphill";
  return {};
}

void LaneRows::Free::operator()(double* p) const { std::free(p); }

LaneRows::LaneRows(std::size_t rows, std::size_t lanes)
    : stride_((lanes + kLaneBlock - 1) / kLaneBlock * kLaneBlock) {
  // Rows a power of two apart would fall into the same few places of the cache.
  if (rows > 1 && stride_ % (8 * kLaneBlock) == 0) stride_ += kLaneBlock;
  const std::size_t bytes = rows * stride_ * sizeof(double);
  data_.reset(static_cast<double*>(std::aligned_alloc(64, std::max<std::size_t>(bytes, 64))));
  if (!data_) throw std::bad_alloc();
  std::fill_n(data_.get(), rows * stride_, 0.0);
}

DescentBatch::DescentBatch(int sensor_count, std::size_t lanes, bool shared_rig)
    : sensors(sensor_count),
      count(lanes),
      one_rig(shared_rig),
      sensor_m(3 * static_cast<std::size_t>(sensor_count), shared_rig ? 1 : lanes),
      range_m(static_cast<std::size_t>(sensor_count), lanes),
      weight(static_cast<std::size_t>(sensor_count), lanes),
      position_m(3, lanes),
      cost_m2(1, lanes),
      iterations(1, lanes),
      status(lanes, SolveStatus::not_solved) {
  for (int i = 0; i < sensor_count; ++i) {
    const auto row = static_cast<std::size_t>(i);
    std::fill_n(weight.row(row), weight.stride(), 1.0);
  }
}

void descend(DescentBatch& batch, const DescentOptions& options) {
  check(batch.sensors, options);
  const LaneView view{
      batch.sensors,           batch.count,          batch.one_rig,           batch.sensor_m.row(0),
      batch.range_m.row(0),    batch.weight.row(0),  batch.sensor_m.stride(), batch.range_m.stride(),
      batch.position_m.row(0), batch.cost_m2.row(0), batch.iterations.row(0), batch.status.data()};
  HWY_DYNAMIC_DISPATCH(DescendMany)(view, options);
}

void descend(DescentPair& pair, const DescentOptions& options) {
  check(pair.sensors, options);
  const LaneView view{pair.sensors,       kPairLanes,     false,           pair.sensor_m[0],
                      pair.range_m[0],    pair.weight[0], kPairLanes,      kPairLanes,
                      pair.position_m[0], pair.cost_m2,   pair.iterations, pair.status};
  HWY_DYNAMIC_DISPATCH(DescendPair)(view, options);
}

}  // namespace trilat
#endif  // HWY_ONCE
