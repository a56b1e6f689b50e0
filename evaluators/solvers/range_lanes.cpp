// SPDX-License-Identifier: MIT
// One source, compiled once for each instruction set. Additions and products are written out and never fused,
// and nothing is summed across lanes: so every set and every width gives the bits of descent.cpp.
#include "evaluators/solvers/range_lanes.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <new>

#include "datasets/base/error.h"

// SSE2 is there on every x86-64; these bring nothing beyond SSE4 and AVX-512 here.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "evaluators/solvers/range_lanes.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace trilat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

// Linearised in each lane, without rounding_scale.
struct LaneEquations {
  V xx, xy, xz, yy, yz, zz;  // J^T J
  V gx, gy, gz;              // gradient
  V cost;
};

// The problems in work, one a lane.
struct Work {
  alignas(64) double range_m[kMaxSensors][kLaneBlock];
  alignas(64) double x_m[3][kLaneBlock];
  alignas(64) double before_m2[kLaneBlock];  // F before the last step; -infinity before the first
  alignas(64) double step2_m2[kLaneBlock];   // square of the last step; infinity before the first
  alignas(64) double steps[kLaneBlock], status[kLaneBlock];
  std::size_t problem[kLaneBlock];

  void begin(std::size_t lane, std::size_t number, const RangeLanes& lanes) {
    problem[lane] = number;
    for (std::size_t i = 0; i < lanes.sensor_m.size(); ++i) range_m[i][lane] = lanes.range_m.row(i)[number];
    for (std::size_t axis = 0; axis < 3; ++axis) x_m[axis][lane] = lanes.position_m.row(axis)[number];
    step2_m2[lane] = std::numeric_limits<double>::infinity();
    before_m2[lane] = -step2_m2[lane];
    steps[lane] = 0.0;
  }
  void finish(std::size_t lane, RangeLanes& lanes) const {
    const std::size_t number = problem[lane];
    for (std::size_t axis = 0; axis < 3; ++axis) lanes.position_m.row(axis)[number] = x_m[axis][lane];
    lanes.iterations.row(0)[number] = steps[lane];
    lanes.status[number] = static_cast<SolveStatus>(static_cast<int>(status[lane]));
  }
};

// `known_sensors` is their number when the loop over them is written out, else 0.
template <bool printed, int known_sensors>
HWY_INLINE LaneEquations Linearise(const RangeLanes& lanes, const Work& work, V x, V y, V z, double unit_m) {
  const D d;
  const V zero = hn::Zero(d), unit = hn::Set(d, unit_m), one = hn::Set(d, 1.0);
  const V least = hn::Set(d, kOnSensor_m * kOnSensor_m);
  const std::size_t sensors = known_sensors > 0 ? known_sensors : lanes.sensor_m.size();
  // The sums are made in a second loop: one loop for all would need more registers than there are.
  V vx[kMaxSensors], vy[kMaxSensors], vz[kMaxSensors], q[kMaxSensors], slope[kMaxSensors];
  LaneEquations sum{zero, zero, zero, zero, zero, zero, zero, zero, zero, zero};
  for (std::size_t i = 0; i < sensors; ++i) {
    const Eigen::Vector3d& sensor_m = lanes.sensor_m[i];
    vx[i] = x - hn::Set(d, sensor_m.x());
    vy[i] = y - hn::Set(d, sensor_m.y());
    vz[i] = z - hn::Set(d, sensor_m.z());
    const V square = vx[i] * vx[i] + vy[i] * vy[i] + vz[i] * vz[i];
    const V distance = hn::Sqrt(square);
    const V f = distance - hn::Load(d, work.range_m[i]);
    // The quotient does not wait for the root, which shortens the chain of each iteration.
    q[i] = one / hn::Max(square, least);
    slope[i] = q[i] * ((printed ? unit : distance) * f);
    sum.cost = sum.cost + f * f;
  }
  for (std::size_t i = 0; i < sensors; ++i) {
    sum.gx = sum.gx + slope[i] * vx[i];
    sum.gy = sum.gy + slope[i] * vy[i];
    sum.gz = sum.gz + slope[i] * vz[i];
    const V qx = q[i] * vx[i], qy = q[i] * vy[i];
    sum.xx = sum.xx + qx * vx[i];
    sum.xy = sum.xy + qx * vy[i];
    sum.xz = sum.xz + qx * vz[i];
    sum.yy = sum.yy + qy * vy[i];
    sum.yz = sum.yz + qy * vz[i];
    sum.zz = sum.zz + q[i] * vz[i] * vz[i];
  }
  return sum;
}

// The inverse of J^T J is adjugate / determinant, eq. 18.
struct LaneAdjugate {
  V xx, xy, xz, yy, yz, zz, determinant;
};

HWY_INLINE LaneAdjugate AdjugateOf(const LaneEquations& e) {
  LaneAdjugate a{e.yy * e.zz - e.yz * e.yz,
                 e.xz * e.yz - e.xy * e.zz,
                 e.xy * e.yz - e.xz * e.yy,
                 e.xx * e.zz - e.xz * e.xz,
                 e.xy * e.xz - e.xx * e.yz,
                 e.xx * e.yy - e.xy * e.xy,
                 e.cost};
  a.determinant = e.xx * a.xx + e.xy * a.xy + e.xz * a.xz;
  return a;
}

// Lanes whose directions span space, by the inequality of is_rank_deficient().
HWY_INLINE M SpanSpace(const LaneEquations& e, const LaneAdjugate& a) {
  const V ratio = hn::Set(D(), kRankRatio), trace = e.xx + e.yy + e.zz, pairs = a.xx + a.yy + a.zz;
  return hn::And(pairs > ratio * trace * trace, a.determinant > ratio * trace * pairs);
}

HWY_INLINE V StatusOf(SolveStatus status) { return hn::Set(D(), static_cast<double>(status)); }

// Descents of one vector of lanes. Where descents are long, a lane that ends takes the next problem at once;
// where they are a few steps, taking one costs more than waiting for the others of the vector.
template <bool printed, int known_sensors>
class Descents {
 public:
  // `next`: the first problem that nobody took yet, for all vectors.
  Descents(RangeLanes& lanes, const DescentOptions& options, std::size_t& next)
      : lanes_(lanes), options_(options), next_(next) {
    take_vector();
  }

  HWY_INLINE bool goes_on() const { return !hn::AllFalse(D(), active_); }

  // One step of every lane.
  HWY_INLINE void step() {
    const D d;
    const V limit = hn::Set(d, static_cast<double>(options_.max_iterations)), one = hn::Set(d, 1.0);
    const LaneEquations e =
        Linearise<printed, known_sensors>(lanes_, work_, x_, y_, z_, options_.printed_unit_m);
    const LaneAdjugate a = AdjugateOf(e);
    const M stops = stop_rule_holds(e.cost), at_limit = steps_ >= limit, finite = hn::IsFinite(e.cost);
    const M stays = hn::AndNot(hn::Or(stops, at_limit), hn::And(finite, SpanSpace(e, a)));
    const M ends = hn::AndNot(stays, active_);
    active_ = hn::And(active_, stays);
    const V scale = hn::Set(d, -1.0) / a.determinant;
    const V sx = (a.xx * e.gx + a.xy * e.gy + a.xz * e.gz) * scale;
    const V sy = (a.xy * e.gx + a.yy * e.gy + a.yz * e.gz) * scale;
    const V sz = (a.xz * e.gx + a.yz * e.gy + a.zz * e.gz) * scale;
    x_ = hn::IfThenElse(active_, x_ + sx, x_);
    y_ = hn::IfThenElse(active_, y_ + sy, y_);
    z_ = hn::IfThenElse(active_, z_ + sz, z_);
    step2_ = sx * sx + sy * sy + sz * sz;
    before_ = e.cost;
    steps_ = hn::IfThenElse(active_, steps_ + one, steps_);
    if (HWY_LIKELY(hn::AllFalse(d, ends))) return;
    V how = hn::IfThenElse(at_limit, StatusOf(SolveStatus::iteration_limit),
                           StatusOf(SolveStatus::rank_deficient));
    how = hn::IfThenElse(stops, StatusOf(SolveStatus::converged), how);
    how = hn::IfThenElse(finite, how, StatusOf(SolveStatus::diverged));
    status_ = hn::IfThenElse(ends, how, status_);
    if (printed)
      take_some(ends);
    else if (!goes_on())
      take_vector();
  }

 private:
  HWY_INLINE M stop_rule_holds(V cost) const {
    const D d;
    if (options_.stop == StopRule::step)
      return step2_ < hn::Set(d, options_.step_tolerance_m * options_.step_tolerance_m);
    const V change = cost - before_, threshold = hn::Set(d, options_.threshold_m2);
    return (options_.stop == StopRule::printed ? change : hn::Abs(change)) < threshold;
  }

  // Writes down a vector of problems, all of which ended, and takes the next, while there are any.
  HWY_INLINE void take_vector() {
    const D d;
    if (taken_ > 0) {
      const std::size_t first = work_.problem[0];
      hn::Store(x_, d, lanes_.position_m.row(0) + first);
      hn::Store(y_, d, lanes_.position_m.row(1) + first);
      hn::Store(z_, d, lanes_.position_m.row(2) + first);
      hn::Store(steps_, d, lanes_.iterations.row(0) + first);
      hn::Store(status_, d, work_.status);
      for (std::size_t lane = 0; lane < taken_; ++lane)
        lanes_.status[first + lane] = static_cast<SolveStatus>(static_cast<int>(work_.status[lane]));
    }
    taken_ = std::min(hn::Lanes(d), lanes_.count - next_);
    active_ = hn::FirstN(d, taken_);
    if (taken_ == 0) return;
    for (std::size_t i = 0; i < lanes_.sensor_m.size(); ++i)
      hn::Store(hn::Load(d, lanes_.range_m.row(i) + next_), d, work_.range_m[i]);
    x_ = hn::Load(d, lanes_.position_m.row(0) + next_);
    y_ = hn::Load(d, lanes_.position_m.row(1) + next_);
    z_ = hn::Load(d, lanes_.position_m.row(2) + next_);
    step2_ = hn::Set(d, std::numeric_limits<double>::infinity());
    before_ = hn::Neg(step2_);
    steps_ = status_ = hn::Zero(d);
    for (std::size_t lane = 0; lane < taken_; ++lane) work_.problem[lane] = next_ + lane;
    next_ += taken_;
  }

  // Writes down the lanes that ended; each takes the next problem, while there are any.
  HWY_NOINLINE void take_some(M ended) {
    const D d;
    alignas(64) double is_ended[kLaneBlock], is_active[kLaneBlock];
    hn::Store(hn::IfThenElseZero(ended, hn::Set(d, 1.0)), d, is_ended);
    hn::Store(hn::IfThenElseZero(active_, hn::Set(d, 1.0)), d, is_active);
    hn::Store(x_, d, work_.x_m[0]);
    hn::Store(y_, d, work_.x_m[1]);
    hn::Store(z_, d, work_.x_m[2]);
    hn::Store(before_, d, work_.before_m2);
    hn::Store(step2_, d, work_.step2_m2);
    hn::Store(steps_, d, work_.steps);
    hn::Store(status_, d, work_.status);
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
      if (is_ended[lane] == 0.0) continue;
      work_.finish(lane, lanes_);
      if (next_ == lanes_.count) continue;
      work_.begin(lane, next_++, lanes_);
      is_active[lane] = 1.0;
    }
    x_ = hn::Load(d, work_.x_m[0]);
    y_ = hn::Load(d, work_.x_m[1]);
    z_ = hn::Load(d, work_.x_m[2]);
    before_ = hn::Load(d, work_.before_m2);
    step2_ = hn::Load(d, work_.step2_m2);
    steps_ = hn::Load(d, work_.steps);
    active_ = hn::Load(d, is_active) > hn::Zero(d);
  }

  RangeLanes& lanes_;
  const DescentOptions& options_;
  std::size_t& next_;
  std::size_t taken_ = 0;  // with the last vector
  Work work_{};
  V x_, y_, z_, step2_, before_, steps_, status_;
  M active_;
};

// Two vectors in turn: a step of one does not wait for that of the other.
template <bool printed, int known_sensors>
void DescendKind(RangeLanes& lanes, const DescentOptions& options) {
  std::size_t next = 0;
  Descents<printed, known_sensors> one(lanes, options, next), other(lanes, options, next);
  while (one.goes_on() || other.goes_on()) {
    if (HWY_LIKELY(one.goes_on())) one.step();
    if (HWY_LIKELY(other.goes_on())) other.step();
  }
}

void DescendAll(RangeLanes& lanes, const DescentOptions& options) {
  const bool four = lanes.sensor_m.size() == 4;
  if (options.gradient == Gradient::printed)
    return four ? DescendKind<true, 4>(lanes, options) : DescendKind<true, 0>(lanes, options);
  return four ? DescendKind<false, 4>(lanes, options) : DescendKind<false, 0>(lanes, options);
}

}  // namespace HWY_NAMESPACE
}  // namespace trilat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trilat {
HWY_EXPORT(DescendAll);

void AlignedRows::Free::operator()(double* p) const { std::free(p); }

AlignedRows::AlignedRows(std::size_t rows, std::size_t lanes)
    : stride_((lanes + kLaneBlock - 1) / kLaneBlock * kLaneBlock) {
  // Rows a power of two apart would fall into the same few places of the cache.
  if (rows > 1 && stride_ % (8 * kLaneBlock) == 0) stride_ += kLaneBlock;
  const std::size_t bytes = rows * stride_ * sizeof(double);
  data_.reset(static_cast<double*>(std::aligned_alloc(64, std::max<std::size_t>(bytes, 64))));
  if (!data_) throw std::bad_alloc();
  std::fill_n(data_.get(), rows * stride_, 0.0);
}

RangeLanes::RangeLanes(std::span<const Eigen::Vector3d> sensors_m, std::size_t lanes)
    : sensor_m(sensors_m.begin(), sensors_m.end()),
      count(lanes),
      range_m(sensors_m.size(), lanes),
      position_m(3, lanes),
      iterations(1, lanes),
      status(lanes, SolveStatus::not_solved) {}

void descend(RangeLanes& lanes, const DescentOptions& options) {
  TRILAT_CHECK(lanes.sensor_m.size() <= kMaxSensors, "lanes hold the sensors of one rig");
  TRILAT_CHECK(options.damping == Damping::none && contradiction_in(options).empty(),
               "lanes descend without damping, by settings that fit together");
  HWY_DYNAMIC_DISPATCH(DescendAll)(lanes, options);
}

}  // namespace trilat
#endif  // HWY_ONCE
