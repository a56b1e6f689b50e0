// SPDX-License-Identifier: MIT
// Casts rays (x, y, 1) at planes, spheres and capsules; the ray's parameter is the depth. Included once for
// each instruction set, behind hwy/foreach_target.h.
#if defined(TRILAT_DEPTH_CAST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRILAT_DEPTH_CAST_INL_H_
#undef TRILAT_DEPTH_CAST_INL_H_
#else
#define TRILAT_DEPTH_CAST_INL_H_
#endif

#include "datasets/synthetic/depth/depth_kernel.h"
#include "datasets/synthetic/depth/depth_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trilat {
namespace HWY_NAMESPACE {

// Rays and what they met so far: depth (infinite: nothing) and the cosine of the angle to its normal.
struct RayRow {
  const float* x;
  const float* y;
  float* depth_m;
  float* cosine;
};

struct Floats3 {
  Floats x, y, z;
};
HWY_INLINE Floats3 Broadcast(const FloatVector3& v) { return {Single(v[0]), Single(v[1]), Single(v[2])}; }
HWY_INLINE Floats Dot(const Floats3& a, const Floats3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
HWY_INLINE Floats3 Subtract(const Floats3& a, const Floats3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
HWY_INLINE Floats3 Scale(Floats t, const Floats3& ray) { return {t * ray.x, t * ray.y, t * ray.z}; }
HWY_INLINE Floats RootOrZero(Floats x) { return hn::Sqrt(hn::IfThenElseZero(x > Single(0.0f), x)); }

// Rays in a column, with what every object needs of them.
struct Rays {
  Floats3 ray;
  Floats square, inverse_square, inverse_length;
};
HWY_INLINE Rays RaysAt(const RayRow& row, int column) {
  const Floats3 ray{hn::LoadU(F(), row.x + column), hn::LoadU(F(), row.y + column), Single(1.0f)};
  const Floats square = Dot(ray, ray);
  const Floats inverse = Single(1.0f) / square;
  return {ray, square, inverse, hn::Sqrt(inverse)};
}

template <class Mask>
HWY_INLINE void KeepNearer(const RayRow& row, int column, Mask hit, Floats depth, Floats cosine) {
  const F f;
  const Floats before = hn::LoadU(f, row.depth_m + column);
  const auto nearer = hn::And(hit, hn::And(depth > Single(0.0f), depth < before));
  hn::StoreU(hn::IfThenElse(nearer, depth, before), f, row.depth_m + column);
  const Floats cosine_before = hn::LoadU(f, row.cosine + column);
  hn::StoreU(hn::IfThenElse(nearer, cosine, cosine_before), f, row.cosine + column);
}

// The nearest plane is the one of largest 1/depth, which takes no division to find.
HWY_INLINE void CastPlanes(const std::vector<ViewPlane>& planes, const RayRow& row, int columns) {
  const F f;
  for (int column = 0; column < columns; column += static_cast<int>(hn::Lanes(f))) {
    const Floats x = hn::LoadU(f, row.x + column), y = hn::LoadU(f, row.y + column);
    Floats inverse = hn::Zero(f), distance = hn::Zero(f);
    for (const ViewPlane& plane : planes) {
      const Floats here = x * Single(plane.per_x) + y * Single(plane.per_y) + Single(plane.constant);
      const auto nearer = here > inverse;
      inverse = hn::IfThenElse(nearer, here, inverse);
      distance = hn::IfThenElse(nearer, Single(plane.distance_m), distance);
    }
    const Floats square = x * x + y * y + Single(1.0f);
    hn::StoreU(Single(1.0f) / inverse, f, row.depth_m + column);
    hn::StoreU(inverse * distance / hn::Sqrt(square), f, row.cosine + column);
  }
}

// Points at which rays meet a sphere about the origin, from `start` on; `inside` is negative when they do
// not. From the ray's nearest point: nothing large cancels.
HWY_INLINE void IntersectSphere(const Floats3& start, const Rays& rays, Floats radius, Floats& inside,
                                Floats& depth) {
  const Floats to_nearest = hn::Neg(Dot(start, rays.ray)) * rays.inverse_square;
  const Floats3 along = Scale(to_nearest, rays.ray);
  const Floats3 nearest{start.x + along.x, start.y + along.y, start.z + along.z};
  inside = radius * radius - Dot(nearest, nearest);
  depth = to_nearest - RootOrZero(inside) * rays.inverse_length;
}

HWY_INLINE void CastSphere(const ViewSphere& sphere, const PixelBox& box, const RayRow& row) {
  const Floats3 centre = Broadcast(sphere.centre_m);
  const Floats radius = Single(sphere.radius_m), per_radius = Single(1.0f / sphere.radius_m);
  const Floats3 start{hn::Neg(centre.x), hn::Neg(centre.y), hn::Neg(centre.z)};
  for (int column = box.first_column; column < box.last_column; column += static_cast<int>(hn::Lanes(F()))) {
    const Rays rays = RaysAt(row, column);
    Floats inside, depth;
    IntersectSphere(start, rays, radius, inside, depth);
    const auto hit = inside > Single(0.0f);
    if (!hn::AllFalse(F(), hit)) KeepNearer(row, column, hit, depth, RootOrZero(inside) * per_radius);
  }
}

// The infinite cylinder first; where that is met beyond an end of the axis, the ball at that end.
HWY_INLINE void CastCapsule(const ViewCapsule& capsule, const PixelBox& box, const RayRow& row) {
  const Floats zero = hn::Zero(F());
  const Floats3 from = Broadcast(capsule.from_m), axis = Broadcast(capsule.axis_m);
  const Floats3 middle = Broadcast(capsule.middle_m);
  const Floats radius = Single(capsule.radius_m), per_radius = Single(1.0f / capsule.radius_m);
  const Floats axis2 = Single(capsule.axis_m2);
  const Floats per_axis2 = Single(1.0f / capsule.axis_m2);
  for (int column = box.first_column; column < box.last_column; column += static_cast<int>(hn::Lanes(F()))) {
    const Rays rays = RaysAt(row, column);
    const Floats closest =
        Dot(middle, rays.ray) * rays.inverse_square;  // start close by: nothing large cancels
    const Floats3 start = Subtract(Scale(closest, rays.ray), from);
    const Floats axis_ray = Dot(axis, rays.ray), axis_start = Dot(axis, start);
    const Floats a = axis2 * rays.square - axis_ray * axis_ray;
    const Floats b = axis2 * Dot(start, rays.ray) - axis_start * axis_ray;
    const Floats c = axis2 * (Dot(start, start) - radius * radius) - axis_start * axis_start;
    const Floats h = b * b - a * c;
    const auto parallel = a <= Single(1e-6f) * axis2 * rays.square;
    const auto meets = hn::Or(h > zero, parallel);
    if (hn::AllFalse(F(), meets)) continue;
    const Floats root = RootOrZero(h);
    const Floats to_side = (hn::Neg(b) - root) / a;
    const Floats height = hn::IfThenElse(parallel, hn::Neg(axis_ray), axis_start + to_side * axis_ray);
    const auto at_from = height <= zero;
    const auto on_side = hn::AndNot(parallel, hn::And(height > zero, height < axis2));
    const Floats3 end{hn::IfThenElse(at_from, start.x, start.x - axis.x),
                      hn::IfThenElse(at_from, start.y, start.y - axis.y),
                      hn::IfThenElse(at_from, start.z, start.z - axis.z)};
    Floats inside, to_end;
    IntersectSphere(end, rays, radius, inside, to_end);
    const auto hit = hn::And(meets, hn::Or(on_side, inside > zero));
    const Floats side_cosine = root * per_axis2 * rays.inverse_length;
    KeepNearer(row, column, hit, closest + hn::IfThenElse(on_side, to_side, to_end),
               per_radius * hn::IfThenElse(on_side, side_cosine, RootOrZero(inside)));
  }
}

HWY_INLINE void CastRow(const DepthView& view, const ViewBoxes& boxes, int row_number, int columns,
                        const RayRow& row) {
  CastPlanes(view.planes, row, columns);
  const auto in_row = [&](const PixelBox& box) {
    return row_number >= box.first_row && row_number < box.last_row;
  };
  for (std::size_t i = 0; i < view.spheres.size(); ++i)
    if (in_row(boxes.spheres[i])) CastSphere(view.spheres[i], boxes.spheres[i], row);
  for (std::size_t i = 0; i < view.capsules.size(); ++i)
    if (in_row(boxes.capsules[i])) CastCapsule(view.capsules[i], boxes.capsules[i], row);
}

}  // namespace HWY_NAMESPACE
}  // namespace trilat
HWY_AFTER_NAMESPACE();

#endif
